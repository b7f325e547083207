"""A detector by its name or its file."""

from __future__ import annotations

from pathlib import Path

import pytest

from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.registry import DETECTORS, kind_of_file, open_detector


def test_every_built_in_detector_opens_and_says_its_kind():
    names = [(name, kind.key) for kind in DETECTORS.values() for name in kind.built_in]
    assert names == [("hog", "hog"), ("hog:daimler", "hog"), ("icf:sample", "icf")]
    for name, key in names:
        assert open_detector(name).about.kind == key


@pytest.mark.parametrize(
    ("content", "key"),
    [(b"PK\3\4rest", "icf"), (b"\x08\x08\x12\x04nvco", "onnx"), (b"\x12\x04nvcorest", "onnx")],
)
def test_a_model_is_known_by_its_content(content: bytes, key: str, tmp_path: Path):
    path = tmp_path / "model.bin"
    path.write_bytes(content)
    assert kind_of_file(path).key == key


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "is empty, no model"),
        (b"frame,x,y\n", "is text, no model"),
        (b"\x89PNG\r\n", "is a PNG picture, no model; expected one that nvcore train wrote"),
    ],
)
def test_another_file_is_refused_by_what_it_is(content: bytes, words: str, tmp_path: Path):
    path = tmp_path / "model.bin"
    path.write_bytes(content)
    with pytest.raises(DetectorError, match=words):
        open_detector(path)


def test_a_misspelt_name_gets_a_proposal():
    with pytest.raises(DetectorError, match="no such detector or file; did you mean 'hog"):
        open_detector("hog:daimer")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"stride": 0}, "stride: expected 1 to 256, got 0"),
        (
            {"scales": "2,1"},
            "scales: expected 1 to 64 of them, ascending, such as 1, 1.1, 1.2; got 2, 1",
        ),
        ({"features": 7}, "features: fixed by the training; of a run there are cascade"),
        ({"strid": 7}, "there is no setting 'strid'; did you mean 'stride'"),
    ],
)
def test_a_setting_that_a_model_cannot_have_is_an_error_of_the_detector(settings: dict, words: str):
    with pytest.raises(DetectorError, match=words):
        open_detector("icf:sample", settings)


def test_a_folder_is_no_model(tmp_path: Path):
    with pytest.raises(DetectorError, match="cannot be opened"):
        open_detector(tmp_path)
