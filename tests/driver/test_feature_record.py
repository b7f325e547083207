"""The record beside a file of features: with which settings they were computed."""

from __future__ import annotations

from pathlib import Path

import pytest

from nvcore.common.errors import FormatError
from nvcore.subjects.driver.features import FeatureSettings
from nvcore.subjects.driver.features.feature_record import (
    RECORD_FILE,
    about_features,
    record_beside,
    record_bytes,
)

WIDE = {"surround": 3.0, "bin_distance": 1.0}


@pytest.fixture
def features(tmp_path: Path) -> Path:
    path = tmp_path / "study.csv"
    path.write_text("image,pedestrian\n")
    return path


def record(features: Path, settings: object = WIDE) -> bytes:
    return record_bytes({features.name: features.read_bytes()}, settings={"features": settings})


@pytest.mark.parametrize("name", ["study.csv.json", RECORD_FILE])
def test_the_record_beside_the_file_is_found(features: Path, name: str):
    features.with_name(name).write_bytes(record(features))
    assert about_features(features)[0] == FeatureSettings(surround=3)


def test_without_a_record_nothing_is_known(features: Path):
    assert about_features(features)[0] is None
    assert about_features(features.with_name("gone.csv"))[0] is None


def test_a_record_of_another_content_says_nothing(features: Path):
    record_beside(features).write_bytes(record(features))
    features.write_text("image,pedestrian\npark.png,1\n")
    assert about_features(features)[0] is None


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"surround": 3.0}, "settings of the features: expected a bin_distance"),
        ({**WIDE, "more": 1}, "settings of the features has no key 'more'"),
        ({**WIDE, "surround": "3"}, "surround: expected a number, found '3'"),
        ({**WIDE, "surround": 10**400}, "surround: expected a number, found 1000"),
        ({**WIDE, "surround": 1.0}, "surround: expected 1.1 to 10, found 1"),
        ([], "features: expected a table"),
    ],
)
def test_a_record_that_is_none_is_refused_with_its_name(
    features: Path, settings: object, words: str
):
    record_beside(features).write_bytes(record(features, settings))
    with pytest.raises(FormatError, match=rf"study\.csv\.json: .*{words}"):
        about_features(features)
