"""Findings carry every place that they concern, not only the first."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from audit_comparison import dataset, find, truth_walk, walk, with_left_out, with_lines
from builders import Box, Place, make_dataset

from nvcore.auditing import audit
from nvcore.common.findings import Cases, Finding, Severity
from nvcore.inputs.load import read_source
from nvcore.inputs.session import Source
from nvcore.settings.params import Params
from nvcore.tables import entries_as_cvat, entry_frames, finding_entries


def agreed_in(*frames: int):
    """Both systems see somebody in these frames whom the truth does not have."""
    more = [Box(frame, 400, 50, 30, 80, score=0.9) for frame in frames]
    return with_lines(dataset(x=[*walk(), *more], y=[*walk(), *more]))


def test_all_boxes_on_which_both_agree_are_listed_with_place_box_and_line():
    made = agreed_in(3, 17, 39)
    finding = find(made, "agreed-by-both-not-in-truth")
    entries = finding_entries(made, [finding])
    assert entries["frame"].tolist() == [3, 17, 39]
    assert len(entries) == finding.count
    assert set(entries["x"]) == {400.125}
    assert set(entries["file"]) == {"x.txt"}
    rows = made.boxes.iloc[finding.cases.rows]
    assert entries["line"].tolist() == rows["line"].tolist()
    assert entries["finding"].tolist() == [1, 1, 1]


def test_the_truths_boxes_are_those_of_the_finding():
    truth = truth_walk()
    truth[7] = truth[7]._replace(x=-100)
    truth[9] = truth[9]._replace(x=-100)
    made = dataset(truth=truth)
    entries = finding_entries(made, [find(made, "outside-picture")])
    assert entries["frame"].tolist() == [7, 9]
    assert entries["track"].tolist() == [1, 1]


def test_a_recording_is_listed_with_its_first_frame():
    there = [Box(5, 20, 20, 10, 30, recording=1)]
    made = dataset(truth=there, places=[Place([3, 4]), Place([5, 6])], x=there, y=there)
    finding = find(made, "recording-without-pedestrians")
    entries = finding_entries(made, [finding])
    assert entries[["recording", "frame"]].to_numpy().tolist() == [["r0", 3]]


def test_rows_that_could_not_be_placed_are_listed_as_they_stand_in_the_file():
    made = with_left_out(
        dataset(), ("x", "r0", 77, "frame not listed"), ("x", "other", 3, "unknown recording")
    )
    findings = [find(made, "frame-not-listed"), find(made, "unknown-recording")]
    entries = finding_entries(made, findings)
    assert entries["frame"].tolist() == [77, 3]
    assert entries["line"].tolist() == [1, 2]
    assert entries["finding"].tolist() == [1, 2]
    assert [entry_frames(made, finding.cases).tolist() for finding in findings] == [[-1], [-1]]


def test_a_left_out_row_of_an_evaluated_frame_leads_to_that_frame():
    made = with_left_out(dataset(), ("x", dataset().recordings["name"][0], 12, "no area"))
    assert entry_frames(made, find(made, "no-area").cases).tolist() == [12]


def test_a_finding_about_an_input_as_a_whole_has_no_entries():
    made = dataset()
    findings = audit(made, Params(threshold_x=2.0))
    (whole,) = [finding for finding in findings if finding.code == "threshold-keeps-nothing"]
    assert whole.cases is None
    assert finding_entries(made, [whole]).empty


@pytest.mark.parametrize("n", [1, 5])
def test_every_finding_that_counts_boxes_lists_as_many(n: int):
    made = agreed_in(*range(n))
    assert len(finding_entries(made, [find(made, "agreed-by-both-not-in-truth")])) == n


def test_cases_do_not_make_equal_findings_differ():
    finding = Finding(Severity.NOTE, "a", "truth", 1, "m", "a")
    assert finding == dataclasses.replace(finding, cases=Cases("boxes", np.arange(1)))


def test_annotators_get_the_frames_and_boxes_as_cvat(tmp_path: Path):
    made = agreed_in(3, 17)
    finding = find(made, "agreed-by-both-not-in-truth")
    file = tmp_path / "look.xml"
    file.write_bytes(entries_as_cvat(made, [finding]))
    reading = read_source(Source(str(file), classes=("agreed-by-both-not-in-truth",)), role="truth")
    assert reading.boxes["frame"].tolist() == [3, 17]
    boxes = reading.boxes[["x", "y", "w", "h"]].to_numpy()
    assert np.allclose(boxes, [[400.12, 50, 30, 80]] * 2, atol=0.006)
    assert reading.recordings["name"].tolist() == made.recordings["name"].tolist()
    assert reading.recordings[["width", "height"]].to_numpy().tolist() == [[640, 480]]


def test_cvat_finds_pictures_by_the_names_of_their_files(tmp_path: Path):
    made = agreed_in(3, 17)
    frame_row = np.flatnonzero(made.frames["frame"] == 17)[0]
    text = entries_as_cvat(
        made, [find(made, "agreed-by-both-not-in-truth")], file_names={int(frame_row): "I00018.jpg"}
    ).decode()
    assert re.findall('<image id="." name="([^"]*)"', text) == ["r0/000003.png", "I00018.jpg"]


def test_names_of_files_of_several_recordings_stand_below_them():
    places = [Place(range(3)), Place(range(3))]
    made = make_dataset([Box(1, 5, 5, 5, 9, 1, recording=r) for r in (0, 1)], places=places)
    finding = Finding(Severity.NOTE, "a", "truth", 2, "m", "a", cases=Cases("boxes", np.arange(2)))
    text = entries_as_cvat(made, [finding], file_names={1: "b.png", 4: "b.png"}).decode()
    assert re.findall('<image id="." name="([^"]*)"', text) == ["r0/b.png", "r1/b.png"]


def test_names_in_cvat_cannot_break_the_xml(tmp_path: Path):
    made = agreed_in(3)
    odd = made.recordings.assign(name='a"<&\x01')
    made = dataclasses.replace(made, recordings=odd)
    finding = find(made, "agreed-by-both-not-in-truth")
    file = tmp_path / "look.xml"
    file.write_bytes(entries_as_cvat(made, [finding], label="<person>"))
    reading = read_source(Source(str(file), classes=("<person>",)), role="truth")
    assert len(reading.boxes) == 1
