"""Which frames a detector was trained on: by name, and by the truth under another name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from builders import Place, at, make_dataset

from nvcore.common.findings import Severity
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, TrainedOn
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.detectors.findings import trained_findings
from nvcore.subjects.detectors.training import overlap as overlap_module
from nvcore.subjects.detectors.training.overlap import trained_part, training_overlap
from pages import FRAMES, rows, write


def opened(folder: Path) -> Dataset:
    boxes = "".join(f"night,{frame},300,200,40,120,0.9\n" for frame in FRAMES)
    return load(read_session(write(folder, {"one": boxes}, truth=rows(300))))


@pytest.mark.parametrize("recording", ["night", "under another name", ""])
def test_frames_of_the_training_are_known_by_name_or_truth(tmp_path: Path, recording: str):
    dataset = opened(tmp_path)
    part = replace(trained_part(dataset, "night", 5, 9), recording=recording)
    about = About("icf", "model", ("pedestrian",), {}, "", (part,))
    assert np.flatnonzero(training_overlap(dataset, about.trained_on).is_trained).tolist() == [
        5,
        6,
        7,
        8,
        9,
    ]


def test_another_recording_is_none_of_the_training(tmp_path: Path):
    dataset = opened(tmp_path)
    parts = TrainedOn(recording="day"), TrainedOn(fingerprint="5f1c", first_frame=0, last_frame=9)
    about = About("icf", "model", ("pedestrian",), {}, "", parts)
    assert not training_overlap(dataset, about.trained_on).is_trained.any()


def renamed(part: TrainedOn) -> TrainedOn:
    return replace(part, recording="another")


def test_frames_without_a_box_that_are_not_evaluated_make_no_other_recording():
    boxes = [at(frame, frame + 1) for frame in range(3, 10)]
    part = renamed(trained_part(make_dataset(boxes, places=[Place(range(12))]), "r0"))
    assert (part.first_frame, part.last_frame) == (0, 11)
    assert training_overlap(make_dataset(boxes, frames=range(3, 10)), [part]).is_trained.all()


def test_a_list_of_1100_recordings_is_compared_with_200_others():
    boxes = [at(frame, frame + n, recording=n) for n in range(200) for frame in range(5)]
    dataset = make_dataset(boxes, places=[Place(range(5))] * 200)
    parts = [TrainedOn("5f1c", "another", 0, n) for n in range(1100)]
    overlap = training_overlap(dataset, [*parts, renamed(trained_part(dataset, "r199"))])
    assert not overlap.is_unchecked.any()
    assert np.flatnonzero(overlap.has_part).tolist() == [199]


@pytest.fixture
def little_is_hashed(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(overlap_module, "MOST_HASHED", 50)


@pytest.mark.usefixtures("little_is_hashed")
def test_a_list_that_is_too_long_to_be_compared_is_said():
    dataset = make_dataset([at(frame, frame + 1) for frame in range(10)])
    parts = [TrainedOn("5f1c", "another", first, 9) for first in range(10)]
    (finding,) = trained_findings(dataset, "x", [*parts, renamed(trained_part(dataset, "r0"))])
    assert (finding.severity, finding.code) == (Severity.WARNING, "training-unchecked")
    assert finding.message == (
        "The ground truth of 10 of the 10 evaluated frames was not compared with the 11 parts of "
        "its training, which are too many: r0."
    )


@pytest.mark.usefixtures("little_is_hashed")
def test_a_namesake_that_was_not_compared_is_no_error():
    dataset = make_dataset([at(frame, frame + 1) for frame in range(10)])
    parts = [TrainedOn("5f1c", "another", first, 9) for first in range(10)]
    findings = trained_findings(dataset, "x", [*parts, TrainedOn("5f1c", "r0", 0, 9)])
    assert [finding.code for finding in findings] == ["training-unchecked"]
    by_name = TrainedOn(recording="r0", first_frame=1, last_frame=2)  # has nothing to compare
    assert training_overlap(dataset, [*parts, by_name]).is_trained.sum() == 2
