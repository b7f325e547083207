"""Records beside feature files: the settings and pictures behind the features."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Final, TypeVar

from nvcore.driver.features import FeatureSettings
from nvcore.records import convert, decode, read_record, values_of

T = TypeVar("T")
RECORD_FILE: Final = "driver.json"
"""The record of features of recordings, in their folder."""
_ENTRIES: Final = {
    "files": Mapping[str, object],
    "settings": Mapping[str, object],
    "picture_px": object,
}
_LONGEST_SIDE: Final = 2**32
_EXPECTED: Final = (
    "expected the record that nvcore driver features writes (docs/driver-reference.md)"
)


def record_beside(features: Path) -> Path:
    """Return the path of the record of a feature file: its name and ``.json``."""
    return features.with_name(f"{features.name}.json")


def record_bytes(contents: Mapping[str, bytes], **entries: object) -> bytes:
    """Serialize a record as JSON, with the hashes of the files that it describes."""
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    record = {**entries, "files": digests}
    return (json.dumps(record, ensure_ascii=False, indent=1) + "\n").encode()


def settings_beside(features: Path) -> FeatureSettings | None:
    """Return the settings behind a feature file, or None if no record matches its content.

    Raises
    ------
    InputError
        If the file cannot be read, or a record about it is none.
    """
    return _beside(features, _settings_in)


def picture_px_beside(features: Path) -> tuple[int, int] | None:
    """Return width and height of the pictures behind a feature file, or None if unknown.

    None: no record beside it is about this content, or says a size that all of them have.

    Raises
    ------
    InputError
        If the file cannot be read, or a record about it is none.
    """
    return _beside(features, _picture_px_in)


def _beside(features: Path, entry: Callable[[dict[str, Any]], T | None]) -> T | None:
    """Look up an entry of the record next to a feature file. Return None if it is outdated."""
    if not features.is_file():
        return None
    digest = hashlib.sha256(features.read_bytes()).hexdigest()
    parse = partial(_entry_about, name=features.name, digest=digest, entry=entry)
    for path in (record_beside(features), features.with_name(RECORD_FILE)):
        if path.is_file():
            value = read_record(path, path.name, parse, expected=_EXPECTED)
            if value is not None:
                return value
    return None


def picture_px_from_json(content: object) -> tuple[int, int] | None:
    """Parse width and height from a list of two whole numbers. None stays None.

    Raises
    ------
    ValueError
        If it is something else.
    """
    sides: tuple[int, int] | None = convert(tuple[int, int] | None, content, "picture_px")
    if sides is not None and not all(1 <= side <= _LONGEST_SIDE for side in sides):
        raise ValueError("picture_px: expected width and height, two whole numbers above 0")
    return sides


def settings_from_json(content: object) -> FeatureSettings:
    """Parse feature settings from values as `dataclasses.asdict` gives them.

    Raises
    ------
    ValueError
        If one is missing, unknown, no number or outside its range.
    """
    return decode(FeatureSettings, content, "settings of the features", complete=True)


def _entry_about(
    content: object, name: str, digest: str, entry: Callable[[dict[str, Any]], T | None]
) -> T | None:
    """Return an entry of a record if it lists this file name and hash, else None."""
    record = values_of(_ENTRIES, content, "", known_only=False)
    return entry(record) if record.get("files", {}).get(name) == digest else None


def _settings_in(record: dict[str, Any]) -> FeatureSettings:
    return settings_from_json(record.get("settings", {}).get("features", {}))


def _picture_px_in(record: dict[str, Any]) -> tuple[int, int] | None:
    return picture_px_from_json(record.get("picture_px"))
