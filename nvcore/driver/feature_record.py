"""Records beside feature files: the settings and pictures behind the features."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from nvcore import __version__
from nvcore.dataset.records import numbers_of, read_record, typed, value_of
from nvcore.driver.features import FeatureSettings
from nvcore.errors import ParameterError

RECORD_FILE: Final = "driver.json"
"""The record of features of recordings, in their folder."""
_LONGEST_SIDE: Final = 2**32
_EXPECTED: Final = (
    "expected the record that nvcore driver features writes (docs/driver-reference.md)"
)


def record_beside(features: Path) -> Path:
    """Return the path of the record of a feature file: its name and ``.json``."""
    return features.with_name(f"{features.name}.json")


def record_bytes(contents: Mapping[str, bytes], **entries: object) -> bytes:
    """Serialize a record as JSON, with the version and the hashes of the files it describes."""
    digests = {name: sha256(content).hexdigest() for name, content in contents.items()}
    record = {"written_by": f"nvcore {__version__}", **entries, "files": digests}
    return (json.dumps(record, ensure_ascii=False, indent=1) + "\n").encode()


def about_features(features: Path) -> tuple[FeatureSettings | None, tuple[int, int] | None]:
    """Return the settings behind a feature file, and width and height of all its pictures.

    None: no record beside it is about this content or, of the size, the record does not say it.

    Raises
    ------
    InputError
        If the file cannot be read, or a record about it is none.
    """
    if not features.is_file():
        return None, None
    parse = partial(_parse, name=features.name, digest=sha256(features.read_bytes()).hexdigest())
    for path in (record_beside(features), features.with_name(RECORD_FILE)):
        if path.is_file():
            about = read_record(path, path.name, parse, expected=_EXPECTED)
            if about is not None:
                return about
    return None, None


def picture_px_from_json(content: object) -> tuple[int, int] | None:
    """Parse width and height from a list of two whole numbers. None stays None.

    Raises
    ------
    ValueError
        If it is something else.
    """
    if content is None:
        return None
    values = content if isinstance(content, list) else []
    sides = [value for value in values if type(value) is int and 1 <= value <= _LONGEST_SIDE]
    if len(sides) != 2 or len(values) != 2:
        raise ValueError("picture_px: expected width and height, two whole numbers above 0")
    return sides[0], sides[1]


def settings_from_json(content: Mapping[str, Any]) -> FeatureSettings:
    """Parse feature settings from values as `dataclasses.asdict` gives them.

    Raises
    ------
    ValueError
        If one is missing, unknown, no number or outside its range.
    """
    names = [spec.name for spec in fields(FeatureSettings)]
    values = numbers_of(content, names, "settings of the features")
    try:
        return FeatureSettings(**values)
    except ParameterError as error:
        raise ValueError(str(error)) from error


def _parse(
    content: object, name: str, digest: str
) -> tuple[FeatureSettings, tuple[int, int] | None] | None:
    """Parse a record if it lists this file name and hash, else return None."""
    record = typed(content, dict, "the record")
    if value_of(record, "files", dict).get(name) != digest:
        return None
    settings = value_of(value_of(record, "settings", dict), "features", dict)
    return settings_from_json(settings), picture_px_from_json(record.get("picture_px"))
