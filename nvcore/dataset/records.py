"""Records as JSON of how data were made: read, and their entries checked."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Final, Literal, TypeVar, Union, get_args, get_origin

from nvcore.errors import FormatError, InputError

T = TypeVar("T")
MAX_BYTES: Final = 16 << 20
"""Millions of frames, unless they were picked one by one; a hundred thousand recordings."""
_WORDS: Final = {
    dict: "an object",
    list: "a list",
    str: "a text",
    int: "a whole number",
    bool: "true or false",
}


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
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise ValueError(f"{where}: expected {_WORDS[kind]}, found {str(value)[:30]!r}")
    return value


def expected_instead(value: object, declared: Any) -> str | None:
    """What a value has to be by the declared type of its field, in words; None if it is that.

    Parameters
    ----------
    declared
        bool, int, float, str, a Literal of texts, a tuple of these of any length, or one of these
        or None. A float may be a whole number, has to be finite, and nothing stands for a bool but
        a bool.

    Examples
    --------
    >>> expected_instead([0.5], float)
    'a number'
    >>> expected_instead((1, 2.5), tuple[float, ...])
    """
    origin, parts = get_origin(declared), get_args(declared)
    if origin is Literal:
        return None if isinstance(value, str) and value in parts else f"one of {', '.join(parts)}"
    if origin in (Union, UnionType):
        kinds = [part for part in parts if part is not NoneType]
        assert len(kinds) == 1, declared
        return None if value is None else expected_instead(value, kinds[0])
    if origin is tuple:
        if not isinstance(value, tuple):
            return "several values"
        odd = next(filter(None, (expected_instead(part, parts[0]) for part in value)), None)
        choices = get_args(parts[0])
        return f"some of {', '.join(choices)}" if odd and choices else odd
    if declared is float:
        return None if _is_number(value) else "a number"
    is_of_kind = isinstance(value, declared) and (declared is bool or not isinstance(value, bool))
    return None if is_of_kind else _WORDS[declared]


def numbers_of(table: Mapping[str, object], names: Collection[str], where: str) -> dict[str, float]:
    """The finite numbers that a JSON object has under these keys, and no others.

    Raises
    ------
    ValueError
        If a key is missing or unknown, or has no number; `where` says of what the keys are.
    """
    if set(table) != set(names):
        raise ValueError(f"{where}: its keys are others than there are")
    return {name: _number(value, name) for name, value in table.items()}


def _number(value: Any, where: str) -> float:
    if not _is_number(value):
        raise ValueError(f"{where}: expected a number, found {str(value)[:30]!r}")
    return float(value)


def _is_number(value: object) -> bool:
    """Whether it is a finite number that float64 can hold, and no bool."""
    try:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and math.isfinite(value)  # type: ignore[arg-type]
    except OverflowError:  # a whole number of hundreds of digits
        return False
