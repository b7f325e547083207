"""Tables of TOML and JSON as dataclasses, checked by the types of their fields."""

from __future__ import annotations

import json
import math
import reprlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, Final, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from nvcore.common.errors import FormatError, InputError, ParameterError
from nvcore.common.wording import did_you_mean, shortened

T = TypeVar("T")
MAX_BYTES: Final = 16 << 20
"""Largest record: millions of frames, unless selected one by one, or 100,000 recordings."""
_WORDS: Final = {
    str: ("a text", "texts"),
    int: ("a whole number", "whole numbers"),
    float: ("a number", "numbers"),
    bool: ("true or false", "true or false"),
}
"""One and several values of each type."""
MOST_TABLES: Final = 100_000
"""Maximum number of tables in a list."""
_SHOWN_KEY: Final = 80
_COUNTS: Final = ("no", "one", "two", "three", "four")


def read_record(path: Path, name: str, parse: Callable[[object], T], *, expected: str) -> T:
    """Read a record from a JSON file.

    Parameters
    ----------
    name
        Name of the file as the user gave it.
    parse
        Function from the content to the record. Raises ValueError or ParameterError if invalid.
    expected
        Expected content, for errors.

    Raises
    ------
    InputError
        If it cannot be opened, or is not a valid record. Records are never used in part.
    """
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FormatError(f"is larger than {MAX_BYTES >> 20} MiB; {expected}", file=name)
        content = parse_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be opened ({error.strerror})", file=name) from error
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is not JSON: {error}; {expected}", file=name) from error
    try:
        return parse(content)
    except (ValueError, ParameterError) as error:
        raise FormatError(f"{error}; {expected}", file=name) from error


def parse_json(content: bytes) -> Any:
    """Parse JSON whose numbers are all finite.

    Raises
    ------
    ValueError, RecursionError
        If it is something else, or nested too deeply.
    """
    return json.loads(content, parse_constant=_finite, parse_float=_finite)


def _finite(text: str) -> float:
    if not math.isfinite(value := float(text)):
        raise ValueError(f"JSON numbers must be finite, found {text[:30]}")
    return value


def decode(
    kind: type[T], table: object, where: str, *, known_only: bool = True, complete: bool = False
) -> T:
    """Create a dataclass from the table with its fields.

    Parameters
    ----------
    where
        Path of the table, for errors. Empty: the whole file.
    known_only
        True if other keys are refused, False if they are ignored.
    complete
        True if fields with a default have to be there, too.

    Raises
    ------
    ValueError
        If a key is unknown or missing, a value has the wrong type, or the dataclass refuses one.
    """
    path = f"{where}: " if where else ""
    values = values_of(types_of(kind), table, where, known_only=known_only)  # type: ignore[arg-type]
    for spec in fields(kind):  # type: ignore[arg-type]
        is_needed = complete or spec.default is spec.default_factory is MISSING
        if is_needed and spec.name not in values:
            raise ValueError(f"{path}expected a {spec.name}")
    try:
        return kind(**values)
    except (ValueError, ParameterError, InputError) as error:
        raise ValueError(f"{path}{error}") from error


def values_of(
    types: Mapping[str, Any], table: object, where: str, *, known_only: bool = True
) -> dict[str, Any]:
    """Return the values of a table by key, converted to the type of each key.

    Raises
    ------
    ValueError
        As `decode`.
    """
    values: dict[str, Any] = {}
    for key, value in convert(Mapping[str, object], table, where or "the record").items():
        if key in types:
            values[key] = convert(types[key], value, f"{where}: {key}" if where else key)
        elif known_only:
            shown = shortened(key, _SHOWN_KEY)
            hint = did_you_mean(shown, types, f"its keys are {', '.join(sorted(types))}")
            raise ValueError(f"{where or 'the record'} has no key {shown!r}; {hint}")
    return values


@cache
def types_of(kind: Any) -> dict[str, Any]:
    """Return the declared type of each field of a dataclass."""
    return get_type_hints(kind)


class _OtherTypeError(Exception):
    """A value has another type than declared."""


def convert(declared: Any, value: object, where: str) -> Any:
    """Convert a value of TOML or JSON to the declared type of a field.

    Parameters
    ----------
    declared
        bool, int, float, str, object, a Literal of texts, a dataclass, a tuple or a mapping of
        these, or a union of them. A float may be a whole number, and only a bool is a bool.
    where
        Path of the value, for errors.

    Raises
    ------
    ValueError
        If the type is wrong, with the path, the expectation and the actual value.

    Examples
    --------
    >>> convert(tuple[float, float] | None, [1, 2.5], "scale")
    (1.0, 2.5)
    >>> convert(tuple[str, ...], ["night", 3], "tags")
    Traceback (most recent call last):
    ...
    ValueError: tags: expected a list of texts, found ['night', 3]
    """
    try:
        return _convert(declared, value, where)
    except _OtherTypeError:
        found = reprlib.repr(value)
        raise ValueError(f"{where}: expected {_in_words(declared)}, found {found}") from None


def _convert(declared: Any, value: Any, where: str) -> Any:
    """Convert a value, or raise `_OtherTypeError`."""
    origin, parts = get_origin(declared), get_args(declared)
    if origin in (Union, UnionType):
        if type(value) in parts:
            return value
        for part in parts:
            with suppress(_OtherTypeError):
                return _convert(part, value, where)
        raise _OtherTypeError
    if is_dataclass(declared):
        return decode(declared, value, where, known_only=False)  # type: ignore[arg-type]
    if origin is tuple and isinstance(value, list | tuple):
        each_kind = parts[:1] * len(value) if parts[-1] is ... else parts
        if len(each_kind) != len(value):
            raise _OtherTypeError
        if is_dataclass(parts[0]) and len(value) > MOST_TABLES:
            raise ValueError(f"{where}: expected at most {MOST_TABLES:,} entries")
        each = enumerate(zip(each_kind, value, strict=True), start=1)
        return tuple(_convert(part, item, f"{where} {n}") for n, (part, item) in each)
    if origin is Mapping and isinstance(value, Mapping):
        return {
            key: convert(parts[1], item, f"{where}: {shortened(key, _SHOWN_KEY)}")
            for key, item in value.items()
        }
    if declared is object or (origin is Literal and value in parts):
        return value
    if origin is None and isinstance(value, bool) == (declared is bool):
        if isinstance(value, declared):
            return value
        if declared is float and isinstance(value, int):
            with suppress(OverflowError):
                return float(value)
    raise _OtherTypeError


def _in_words(declared: Any) -> str:
    """Name a type in a few words."""
    origin, parts = get_origin(declared), get_args(declared)
    if origin in (Union, UnionType):
        return " or ".join(_in_words(part) for part in parts if part is not NoneType)
    if origin is Literal:
        return f"one of {', '.join(parts)}"
    if origin is tuple and get_origin(parts[0]) is Literal:
        return f"some of {', '.join(get_args(parts[0]))}"
    if origin is tuple:
        several = _WORDS[parts[0]][1] if parts[0] in _WORDS else "tables"
        return f"a list of {several}" if parts[-1] is ... else f"{_COUNTS[len(parts)]} {several}"
    of = f" of {_WORDS[parts[1]][1]}" if origin is Mapping and parts[1] in _WORDS else ""
    return _WORDS[declared][0] if declared in _WORDS else f"a table{of}"
