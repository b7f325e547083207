"""Records as JSON of how data were made: read, and their entries checked."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.errors import FormatError, InputError

T = TypeVar("T")
MAX_BYTES: Final = 16 << 20
"""Millions of frames, unless they were picked one by one; a hundred thousand recordings."""
_WORDS: Final = {dict: "an object", list: "a list", str: "a text", int: "a whole number"}


def read_record(path: Path, name: str, parse: Callable[[object], T], *, expected: str) -> T:
    """Read a record.

    Parameters
    ----------
    name
        Of the file, as the user gave it.
    parse
        From the content to the record; ValueError where it is none.
    expected
        What it should be, for errors.

    Raises
    ------
    InputError
        If it cannot be opened, or is no such record; it is never half believed.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FormatError(f"is larger than {MAX_BYTES >> 20} MiB; {expected}", file=name)
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=name) from error
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is not JSON: {error}; {expected}", file=name) from error
    try:
        return parse(content)
    except ValueError as error:
        raise FormatError(f"{error}; {expected}", file=name) from error


def value_of(table: dict[str, Any], key: str, kind: type) -> Any:
    """What a JSON object has under a key, of this type; empty where it has nothing."""
    return typed(table[key], kind, key) if key in table else kind()


def typed(value: object, kind: type, where: str) -> Any:
    """The value, which has to be of this type; ValueError, which says where, if it is not."""
    if not isinstance(value, kind) or isinstance(value, bool):
        raise ValueError(f"{where}: expected {_WORDS[kind]}, found {str(value)[:30]!r}")
    return value
