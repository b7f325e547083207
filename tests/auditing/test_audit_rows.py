from __future__ import annotations

import pytest
from audit_comparison import N, codes, dataset, find, with_left_out
from builders import Box

from nvcore.auditing.cases import place
from nvcore.dataset import Dataset
from nvcore.findings import Severity


def test_a_coordinate_that_is_no_number_is_an_error() -> None:
    made = with_left_out(dataset(), ("x", "r0", 7, "not a number"), ("x", "r0", 9, "not a number"))
    finding = find(made, "not-a-number")
    assert (finding.severity, finding.count) == (Severity.ERROR, 2)
    assert (finding.file, finding.example) == ("x.txt", "line 1, recording r0, frame 7")


def test_a_box_of_no_area_is_an_error() -> None:
    # peers.md 46: a box of size 0 stopped another tool; here it is left out and reported
    finding = find(with_left_out(dataset(), ("truth", "r0", 7, "no area")), "no-area")
    assert (finding.severity, finding.subject) == (Severity.ERROR, "truth")


def test_rows_of_two_files_say_so() -> None:
    made = with_left_out(dataset(), ("x", "r0", 7, "no area"), ("x", "r0", 9, "no area"))
    made.left_out["file"] = [1, 2]
    assert "2 files" in find(made, "no-area").message


def test_a_row_beyond_the_last_listed_frame_is_a_warning() -> None:
    # peers.md 46: a frame beyond the sequence's length aborted another tool
    made = with_left_out(dataset(), ("x", "r0", 60, "frame not listed"))
    finding = find(made, "frame-not-listed")
    assert finding.severity is Severity.WARNING
    assert "--frames" in finding.advice


def test_rows_just_before_the_first_frame_hint_at_the_frame_base() -> None:
    made = with_left_out(dataset(), ("x", "r0", -1, "frame not listed"))
    assert "count frames from 0" in find(made, "frame-not-listed").advice


def test_rows_just_after_the_last_frame_hint_at_the_frame_base() -> None:
    made = with_left_out(dataset(), ("x", "r0", N, "frame not listed"))
    assert "count frames from 1" in find(made, "frame-not-listed").advice


def sampled() -> Dataset:
    """Every 20th frame is listed: 9, 29, ... 789."""
    frames = range(9, 800, 20)
    boxes = [Box(f, 100, 200, 40, 100, track=1, score=0.5 + f / 2000) for f in frames]
    return dataset(boxes, boxes, boxes, frames=frames, fps=20)


def test_a_system_that_ran_between_sampled_frames_gets_a_note() -> None:
    made = with_left_out(sampled(), ("x", "r0", 10, "frame not listed"))
    assert codes(made) == ["between-sampled-frames"]
    assert find(made, "between-sampled-frames").severity is Severity.NOTE


def test_truth_between_sampled_frames_is_a_warning() -> None:
    made = with_left_out(sampled(), ("truth", "r0", 10, "frame not listed"))
    assert find(made, "frame-not-listed").severity is Severity.WARNING


def test_rows_between_and_outside_sampled_frames_are_told_apart() -> None:
    rows = [("x", "r0", frame, "frame not listed") for frame in (10, 11, 900)]
    made = with_left_out(sampled(), *rows)
    assert find(made, "between-sampled-frames").count == 2
    assert find(made, "frame-not-listed").count == 1


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
