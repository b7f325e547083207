"""The record beside detections: written, read, refused."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nvcore.common.errors import FormatError, InputError
from nvcore.dataset.provenance import (
    About,
    Provenance,
    TrainedOn,
    is_in_ranges,
    provenance_json,
    ranges_of,
    read_provenance,
)

RECORD = Provenance(
    About(
        kind="hog",
        name="HOG",
        labels=("pedestrian",),
        settings={"stride": 8, "person_box": True, "classifier": "inria", "none": None},
        fingerprint="5f1c",
        trained_on=(TrainedOn("ab", "night", 0, 399), TrainedOn(fingerprint="cd")),
    ),
    files={"night.csv": "9e07"},
    frames={"night": ((0, 299), (400, 400)), "day": ()},
    written_by="nvcore 0.1.0",
)


def read(content: bytes | str, tmp_path: Path) -> Provenance:
    path = tmp_path / "record.json"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_provenance(path, "record.json")


def test_what_is_written_is_read(tmp_path: Path):
    assert read(provenance_json(RECORD), tmp_path) == RECORD


def test_a_record_by_hand_needs_the_training_alone(tmp_path: Path):
    record = read('{"detector": {"trained_on": [{"recording": "night"}]}}', tmp_path)
    assert record.about.trained_on == (TrainedOn(recording="night"),)
    assert (record.files, record.frames, record.about.kind) == ({}, {}, "")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("{", "is not JSON"),
        ("[" * 100_000, "is not JSON"),
        ("[]", "the record: expected a table, found []"),
        ('{"detector": []}', "detector: expected a table, found []"),
        (
            '{"detector": {"trained_on": [{}]}}',
            "detector: trained_on 1: expected a recording or a fingerprint",
        ),
        (
            '{"detector": {"trained_on": ["night"]}}',
            "detector: trained_on 1: expected a table, found 'night'",
        ),
        (
            '{"detector": {"trained_on": [{"recording": "a", "first_frame": 0.5}]}}',
            "detector: trained_on 1: first_frame: expected a whole number, found 0.5",
        ),
        (
            '{"detector": {"trained_on": [{"recording": "a", "first_frame": 9007199254740993}]}}',
            "expected a frame number",
        ),
        (
            '{"detector": {"settings": {"a": []}}}',
            "detector: settings: a: expected true or false or a whole number or a",
        ),
        ('{"recordings": [{"name": "a", "frames": ["5:2"]}]}', "in ascending order"),
        ('{"recordings": [{"name": "a", "frames": ["0:5", "3:9"]}]}', "in ascending order"),
        (
            '{"recordings": [{"name": "a", "frames": [[0, 5]]}]}',
            "recordings 1: frames: expected a list of texts, found [[0, 5]]",
        ),
        (
            '{"recordings": [{"name": 7, "frames": []}]}',
            "recordings 1: name: expected a text, found 7",
        ),
        ('{"files": {"a.csv": null}}', "files: a.csv: expected a text, found None"),
    ],
)
def test_anything_else_is_refused(content: str, words: str, tmp_path: Path):
    with pytest.raises(FormatError) as caught:
        read(content, tmp_path)
    assert str(caught.value).startswith("record.json: ")
    assert words in str(caught.value)
    assert str(caught.value).endswith("that nvcore detect writes (docs/detectors.md)")


def test_a_record_that_is_not_there_is_an_input_error(tmp_path: Path):
    with pytest.raises(InputError, match=r"gone\.json: cannot be opened"):
        read_provenance(tmp_path / "gone.json", "gone.json")


def test_a_record_of_another_size_is_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("nvcore.common.records.MAX_BYTES", 10)
    with pytest.raises(FormatError, match="is larger than"):
        read(json.dumps({"written_by": "somebody"}), tmp_path)


@given(st.lists(st.integers(-50, 50)))
def test_ranges_hold_exactly_their_frames(frames: list[int]):
    ranges = ranges_of(np.array(frames, np.int64))
    every = np.arange(-60, 60)
    assert every[is_in_ranges(every, ranges)].tolist() == sorted(set(frames))
    assert all(last < first - 1 for (_, last), (first, _) in pairwise(ranges))


def test_renaming_a_recording_renames_it_everywhere():
    record = RECORD.renamed({"night": "Night 1"})
    assert record.about.trained_on[0].recording == "Night 1"
    assert [*record.frames] == ["Night 1", "day"]
