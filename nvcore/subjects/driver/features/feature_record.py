"""Records beside feature files: the settings and pictures behind the features."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Final

from nvcore import __version__
from nvcore.common.records import convert, decode, read_record, values_of
from nvcore.subjects.driver.features import FeatureSettings

RECORD_FILE: Final = "driver.json"
"""Record file of recordings' features, in their folder."""
_ENTRIES: Final = {
    "files": Mapping[str, object],
    "settings": Mapping[str, object],
    "picture_px": object,
}
SETTINGS: Final = "settings of the features"
_LONGEST_SIDE: Final = 2**32


def record_beside(features: Path) -> Path:
    """Return the path of the record of a feature file: its name plus ``.json``."""
    return features.with_name(f"{features.name}.json")


def record_bytes(contents: Mapping[str, bytes], **entries: object) -> bytes:
    """Serialize a record as JSON, with the version and the hashes of the files it describes."""
    digests = {name: sha256(content).hexdigest() for name, content in contents.items()}
    record = {"written_by": f"nvcore {__version__}", **entries, "files": digests}
    return (json.dumps(record, ensure_ascii=False, indent=1) + "\n").encode()


def about_features(features: Path) -> tuple[FeatureSettings | None, tuple[int, int] | None]:
    """Return the settings behind a feature file, and width and height of all its pictures.

    Both are None if no record beside the file describes this content. The size is also None if the
    record does not state it.

    Raises
    ------
    InputError
        If the file cannot be read, or its record is invalid.
    """
    if not features.is_file():
        return None, None
    parse = partial(_parse, name=features.name, digest=sha256(features.read_bytes()).hexdigest())
    expected = "expected the record that nvcore driver features writes (docs/driver-reference.md)"
    for path in (record_beside(features), features.with_name(RECORD_FILE)):
        if path.is_file():
            about = read_record(path, path.name, parse, expected=expected)
            if about is not None:
                return about
    return None, None


def picture_px_from_json(content: object) -> tuple[int, int] | None:
    """Parse width and height from a list of two whole numbers. None stays None.

    Raises
    ------
    ValueError
        If the value is anything else.
    """
    sides: tuple[int, int] | None = convert(tuple[int, int] | None, content, "picture_px")
    if sides is not None and not all(1 <= side <= _LONGEST_SIDE for side in sides):
        raise ValueError("picture_px: expected width and height, two whole numbers above 0")
    return sides


def _parse(
    content: object, name: str, digest: str
) -> tuple[FeatureSettings, tuple[int, int] | None] | None:
    """Parse a record if it lists this file name and hash, else return None."""
    record = values_of(_ENTRIES, content, "", known_only=False)
    if record.get("files", {}).get(name) != digest:
        return None
    given = record.get("settings", {}).get("features", {})
    settings = decode(FeatureSettings, given, SETTINGS, complete=True)
    return settings, picture_px_from_json(record.get("picture_px"))
