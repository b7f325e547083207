"""With which settings the features in a file were computed, as the record beside it says."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import Any, Final

from nvcore.dataset.records import numbers_of, read_record, typed, value_of
from nvcore.driver.features import FeatureSettings
from nvcore.errors import ParameterError

RECORD_FILE: Final = "driver.json"
"""The record of features of recordings, in their folder."""
_EXPECTED: Final = "expected the record that nvcore driver features writes (docs/driver.md)"


def record_beside(features: Path) -> Path:
    """The record of features of single pictures: their file's name and ``.json``."""
    return features.with_name(f"{features.name}.json")


def record_bytes(contents: Mapping[str, bytes], **entries: object) -> bytes:
    """A record as JSON, with the hashes of the files that it is about."""
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    record = {**entries, "files": digests}
    return (json.dumps(record, ensure_ascii=False, indent=1) + "\n").encode()


def settings_beside(features: Path) -> FeatureSettings | None:
    """The settings of a file of features; None: no record beside it is about this content.

    Raises
    ------
    InputError
        If the file cannot be read, or a record about it is none.
    """
    if not features.is_file():
        return None
    digest = hashlib.sha256(features.read_bytes()).hexdigest()
    parse = partial(_settings_about, name=features.name, digest=digest)
    for path in (record_beside(features), features.with_name(RECORD_FILE)):
        if path.is_file():
            settings = read_record(path, path.name, parse, expected=_EXPECTED)
            if settings is not None:
                return settings
    return None


def settings_from_json(content: Mapping[str, Any]) -> FeatureSettings:
    """Settings as `dataclasses.asdict` gives them.

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


def settings_words(settings: FeatureSettings) -> str:
    """Settings in words.

    Examples
    --------
    >>> settings_words(FeatureSettings(surround=3))
    'surround 3, bin distance 1'
    """
    return ", ".join(
        f"{name.replace('_', ' ')} {value:g}" for name, value in asdict(settings).items()
    )


def _settings_about(content: object, name: str, digest: str) -> FeatureSettings | None:
    """The settings in a record, if it is about the file of this name and hash."""
    record = typed(content, dict, "the record")
    if value_of(record, "files", dict).get(name) != digest:
        return None
    return settings_from_json(value_of(value_of(record, "settings", dict), "features", dict))
