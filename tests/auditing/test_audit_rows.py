from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from audit_comparison import N, codes, dataset, find, reported, with_left_out
from builders import Box
from inputs import drive, session_of

from nvcore.auditing import audit
from nvcore.auditing.cases import place
from nvcore.auditing.rows import audit_left_out
from nvcore.common.findings import Severity
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import About, Provenance
from nvcore.inputs.load import load


def test_rows_without_numbers_or_area_are_an_error() -> None:
    # A box of size 0 stopped another tool; here it is left out and reported
    made = with_left_out(dataset(), ("x", "r0", 7, "not a number"), ("x", "r0", 9, "not a number"))
    assert reported(made, "not-a-number") == ("error", "x", 2)
    finding = find(made, "not-a-number")
    assert (finding.file, finding.example) == ("x.txt", "line 1, recording r0, frame 7")
    made.left_out["file"] = [1, 2]
    assert "2 files" in find(made, "not-a-number").message
    made = with_left_out(dataset(), ("truth", "r0", 7, "no area"))
    assert reported(made, "no-area") == ("error", "truth", 1)


def test_rows_that_say_that_nothing_is_there_are_a_note() -> None:
    made = with_left_out(dataset(), ("x", "r0", 7, "not a number"), ("truth", "r0", 9, "no area"))
    made.left_out[[*"xywh"]] = [[math.nan] * 4, [0.0] * 4]
    findings = [finding for finding in audit(made) if finding.code == "empty-box"]
    severities = {finding.subject: finding.severity for finding in findings}
    assert severities == {"x": Severity.NOTE, "truth": Severity.WARNING}


@pytest.mark.parametrize(
    ("frame", "advice"),
    [(60, "the list of"), (-1, "count frames from 0"), (N, "count frames from 1")],
)
def test_a_row_outside_the_listed_frames_is_a_warning(frame: int, advice: str) -> None:
    # A frame beyond the sequence's length aborted another tool. Frames just before
    # the first and just after the last hint at the frame base
    made = with_left_out(dataset(), ("x", "r0", frame, "frame not listed"))
    assert reported(made, "frame-not-listed") == ("warning", "x", 1)
    assert advice in find(made, "frame-not-listed").advice


def sampled() -> Dataset:
    """Every 20th frame is listed: 9, 29, ... 789."""
    frames = range(9, 800, 20)
    boxes = [Box(f, 100, 200, 40, 100, track=1, score=0.5 + f / 2000) for f in frames]
    return dataset(boxes, boxes, boxes, frames=frames, fps=20)


def test_a_system_that_ran_between_sampled_frames_gets_a_note() -> None:
    made = with_left_out(sampled(), ("x", "r0", 10, "frame not listed"))
    assert codes(made) == ["between-sampled-frames"]
    note = find(made, "between-sampled-frames")
    assert note.severity is Severity.NOTE
    assert note.cases is None  # they may be most of the input: no table of findings holds them


def test_truth_between_sampled_frames_is_a_warning() -> None:
    made = with_left_out(sampled(), ("truth", "r0", 10, "frame not listed"))
    assert find(made, "frame-not-listed").severity is Severity.WARNING


def test_rows_between_and_outside_sampled_frames_are_told_apart() -> None:
    rows = [("x", "r0", frame, "frame not listed") for frame in (10, 11, 900)]
    made = with_left_out(sampled(), *rows)
    assert find(made, "between-sampled-frames").count == 2
    assert find(made, "frame-not-listed").count == 1


def test_rows_of_frames_that_were_not_given_are_a_note(tmp_path: Path) -> None:
    session = session_of(drive(tmp_path), frames="0:18")
    by_subject = {finding.subject: finding for finding in audit_left_out(load(session))}
    assert {finding.code for finding in by_subject.values()} == {"left-out-by-choice"}
    assert {name: finding.count for name, finding in by_subject.items()} == {
        "truth": 2,
        "fir": 2,
        "nir": 1,
    }
    assert "not among those given" in by_subject["truth"].message


def test_given_frames_beside_those_of_the_truth_are_a_warning(tmp_path: Path) -> None:
    shifted = load(session_of(drive(tmp_path), frames="1:20"))
    codes_found = {finding.code for finding in audit_left_out(shifted)}
    assert codes_found == {"frame-not-listed"}


def test_the_record_of_a_run_knows_its_frames(tmp_path: Path) -> None:
    about = About("icf", "ICF", ("pedestrian",), {}, "f")
    made = load(session_of(drive(tmp_path), frames="5:9"))
    later = [{"recording": "urban", "frame": 40, "file": 1, "line": 1, "subject": "fir",
              "reason": "frame not listed"}]  # fmt: skip
    made = replace(made, left_out=pd.DataFrame(later))
    assert [finding.code for finding in audit_left_out(made)] == ["frame-not-listed"]
    record = Provenance(about, frames={"urban": ((0, 99),)})
    made = replace(made, provenance={"fir": record})
    assert [finding.code for finding in audit_left_out(made)] == ["left-out-by-choice"]


def test_an_unknown_recording_is_a_warning_that_names_the_known_ones() -> None:
    made = with_left_out(dataset(), ("y", "elsewhere", 1, "unknown recording"))
    finding = find(made, "unknown-recording")
    assert finding.severity is Severity.WARNING
    assert "elsewhere" in finding.message
    assert "r0" in finding.advice


@pytest.mark.parametrize("reason", ["unknown recording", "frame not listed"])
def test_it_is_an_error_when_nothing_is_left_of_the_system(reason: str) -> None:
    made = with_left_out(dataset(y=[]), ("y", "elsewhere" if "un" in reason else "r0", 99, reason))
    assert find(made, reason.replace(" ", "-")).severity is Severity.ERROR


def test_the_example_of_a_json_file_counts_records_not_lines():
    assert place("A", 12, line=17, file="truth.json") == "record 17, recording A, frame 12"
    assert place("A", 12, line=17, file="truth.txt") == "line 17, recording A, frame 12"
