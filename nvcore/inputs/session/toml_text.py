"""Parse TOML from users, guarding the parser against malicious input."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Final

from nvcore.common.errors import InputError

_MOST_DOTS: Final = 20_000
"""Largest number of dots in a line, since parsing a key takes quadratic time."""


def parse_toml(
    content: bytes, *, file: str | Path, error: type[InputError] = InputError
) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Parameters
    ----------
    file
        Name of the file, for errors.
    error
        Class of the error to raise.

    Raises
    ------
    InputError
        If it is not TOML, or has an integer of more than 64 bits.
    """
    try:
        text = content.decode()
        if any(line.count(".") > _MOST_DOTS for line in text.splitlines()):
            raise ValueError(f"a line with more than {_MOST_DOTS:,} dots")
        tables = tomllib.loads(text)
        _check_integers(tables)
    except (ValueError, RecursionError) as fault:  # bad UTF-8, bad TOML, thousands of digits
        raise error(f"is not TOML: {fault}", file=file) from fault
    return tables


def _check_integers(value: object) -> None:
    if isinstance(value, dict | list):
        for part in value.values() if isinstance(value, dict) else value:
            _check_integers(part)
    elif isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ValueError("an integer of more than 64 bits")
