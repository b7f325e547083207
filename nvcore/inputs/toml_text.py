"""TOML from users, which may be made to break its parser."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any, Final

from nvcore.errors import InputError

_MOST_DOTS: Final = 20_000
"""In a line: each dot of a key takes as long as all before it."""


def parse_toml(
    content: bytes, *, file: str | Path, error: type[InputError] = InputError
) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Parameters
    ----------
    file
        Its name, for errors.
    error
        What is raised.

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
