"""No system is scored on what it was trained on without the audit saying so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest
from builders import Place, at, make_dataset

from nvcore.auditing import audit
from nvcore.common.findings import Finding, Severity
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, Provenance, TrainedOn
from nvcore.subjects.detectors.findings import audit_provenance
from nvcore.subjects.detectors.training.overlap import trained_part

TRUTH = [at(frame, 20 + frame, recording=number) for number in (0, 1) for frame in range(10)]


def dataset(*trained_on: TrainedOn, frames: Sequence[int] = range(10), **record: Any) -> Dataset:
    """Recordings r0 and r1 of 10 frames, and what is known of system x."""
    about = About("icf", "ICF", ("pedestrian",), {}, "f", trained_on)
    truth = [box for box in TRUTH if box.frame in frames]
    plain = make_dataset(truth, TRUTH[9:10], places=[Place(frames)] * 2)
    return replace(plain, provenance={"x": Provenance(about, **record)})


def print_of(first: int, last: int, *, shift: float = 0) -> str:
    boxes = [box._replace(x=box.x + shift) for box in TRUTH[:10]]
    return trained_part(
        make_dataset(boxes, places=[Place(range(10))]), "r0", first, last
    ).fingerprint


def codes_and_counts(data: Dataset) -> list[tuple[str, str, int]]:
    return [
        (finding.severity.value, finding.code, finding.count) for finding in audit_provenance(data)
    ]


def only_finding(data: Dataset) -> Finding:
    (finding,) = audit_provenance(data)
    return finding


def test_the_fingerprint_of_a_truth_depends_on_its_boxes_alone():
    own = print_of(2, 5)
    assert own == print_of(2, 5, shift=0.001) != print_of(2, 5, shift=0.1)
    assert own != print_of(3, 6)
    others = [at(frame, 20 + frame) for frame in range(2, 6)]
    reordered = make_dataset(others[::-1], places=[Place(range(2, 12))])
    assert trained_part(reordered, "r0", 2, 5).fingerprint == own
    assert trained_part(reordered, "r0", 7).fingerprint == ""


def test_a_whole_recording_of_the_training_is_an_error():
    finding = only_finding(dataset(TrainedOn(recording="r1")))
    assert finding.severity is Severity.ERROR
    assert finding.message == "Trained on 10 of the 20 evaluated frames: r1."
    assert finding.example == "recording r1, frame 0"
    assert finding.cases is not None
    assert finding.cases.rows.tolist() == [*range(10, 20)]


def test_frames_beside_those_of_the_training_are_a_warning():
    assert codes_and_counts(dataset(TrainedOn(recording="r0", first_frame=2, last_frame=5))) == [
        ("error", "trained-on-tested", 4),
        ("warning", "trained-beside-tested", 6),
    ]


def test_evaluating_the_other_frames_alone_leaves_the_warning():
    part = TrainedOn(recording="r0", last_frame=5)
    assert codes_and_counts(dataset(part, frames=range(6, 10))) == [
        ("warning", "trained-beside-tested", 4)
    ]


def test_several_parts_count_each_frame_once():
    parts = (TrainedOn(recording="r0", first_frame=a, last_frame=b) for a, b in ((0, 5), (3, 9)))
    assert codes_and_counts(dataset(*parts)) == [("error", "trained-on-tested", 10)]


def test_recordings_that_are_not_here_are_no_finding():
    assert codes_and_counts(dataset(TrainedOn(recording="elsewhere"), TrainedOn("f" * 64))) == []


def test_a_recording_is_known_by_its_truth_under_another_name():
    # both recordings have the same truth
    part = TrainedOn(print_of(2, 5), "renamed", 2, 5)
    assert codes_and_counts(dataset(part))[0] == ("error", "trained-on-tested", 8)


def test_a_namesake_with_another_truth_is_a_warning_only():
    part = TrainedOn(print_of(2, 5, shift=1), "r0", 2, 5)
    assert codes_and_counts(dataset(part)) == [("warning", "trained-on-namesake", 4)]


def test_with_a_part_of_its_frames_a_name_is_believed():
    part = TrainedOn(print_of(0, 9), "r0", 0, 9)
    assert codes_and_counts(dataset(part, frames=range(5, 10))) == [
        ("error", "trained-on-tested", 5)
    ]


def test_frames_that_were_not_run_are_said():
    data = dataset()
    assert codes_and_counts(data) == []
    record = replace(data.provenance["x"], frames={"r0": ((0, 9),), "r1": ((0, 3), (8, 9))})
    finding = only_finding(replace(data, provenance={"x": record}))
    assert (finding.code, finding.count) == ("frames-not-run", 4)
    assert finding.message == "Not run on 4 of the 20 evaluated frames: r1."


def test_a_record_of_other_files_is_said():
    data = dataset(files={"x.csv": "aa"})
    inputs = pd.DataFrame({"subject": ["x"], "file": ["x.csv"], "sha256": ["aa"]})
    assert codes_and_counts(replace(data, inputs=inputs)) == []
    changed = only_finding(replace(data, inputs=inputs.assign(sha256="bb")))
    assert (changed.code, changed.count, changed.file) == ("other-provenance", 1, "x.csv")
    several = {"subject": "x", "file": ["a.csv", "b.csv", "c.csv"], "sha256": ["aa", "bb", "cc"]}
    data = dataset(files={"a.csv": "aa", "b.csv": "changed", "c.csv": "cc"})
    changed = only_finding(replace(data, inputs=pd.DataFrame(several)))
    assert changed.file == "b.csv"
    assert "(1 of 3 files: b.csv)" in changed.message


@pytest.mark.parametrize("new", ["x", "ICF 2"])
def test_renamed_systems_and_recordings_keep_what_is_known(new: str):
    data = dataset(TrainedOn(recording="r1")).renamed({"x": new}, {"r1": "Night", "r0": "r1"})
    finding = only_finding(data)
    assert (finding.subject, finding.message) == (
        new,
        "Trained on 10 of the 20 evaluated frames: Night.",
    )


def test_what_a_training_notes_is_found_again_under_another_name():
    part = trained_part(dataset(), "r0", 2, 5)
    assert (part.recording, part.first_frame, part.last_frame) == ("r0", 2, 5)
    assert part.fingerprint == print_of(2, 5)
    assert codes_and_counts(dataset(part))[0] == ("error", "trained-on-tested", 4)
    elsewhere = dataset(replace(part, recording="lost"), frames=range(2, 10))
    assert codes_and_counts(elsewhere)[0] == ("error", "trained-on-tested", 8)


def test_a_training_notes_the_frames_that_it_has():
    part = trained_part(dataset(), "r1", first_frame=7)
    assert (part.first_frame, part.last_frame) == (7, 9)


def test_other_recordings_alone_are_fine():
    data = dataset(TrainedOn(recording="r1"))
    assert audit_provenance(data.only(names=["r0"])) == []
    codes = [finding.code for finding in audit(data) if finding.severity is Severity.ERROR]
    assert "trained-on-tested" in codes
