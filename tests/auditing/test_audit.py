from __future__ import annotations

import dataclasses

import pandas as pd
import pytest
from audit_comparison import dataset, find, truth_walk, walk, with_left_out, with_lines
from builders import Box

from nvcore.auditing import audit
from nvcore.common.errors import InputError
from nvcore.common.findings import Finding, Severity
from nvcore.settings.params import AUDIT_SETTINGS, SETTINGS, Params


def test_a_clean_comparison_has_no_finding() -> None:
    assert audit(dataset()) == ()


def test_the_worst_finding_comes_first() -> None:
    double = [*truth_walk(), Box(3, 400, 200, 40, 100, track=1)]
    made = dataset(double, x=[*walk(), Box(3, 700, 0, 10, 10, score=1.5)])
    severities = [finding.severity for finding in audit(made)]
    assert severities == sorted(severities, key=["error", "warning", "note"].index)
    assert {"error", "warning", "note"} == set(severities)


def test_what_readers_reported_is_passed_on() -> None:
    reported = Finding(Severity.NOTE, "rotated-box", "truth", 1, "m", "a")
    assert audit(dataclasses.replace(dataset(), findings=(reported,))) == (reported,)


def test_the_first_example_names_file_line_recording_and_frame() -> None:
    made = with_lines(dataset(x=[*walk(), Box(12, 700, 0, 10, 10, score=0.5)]))
    finding = find(made, "outside-picture")
    assert finding.file == "x.txt"
    assert finding.example.endswith(", recording r0, frame 12")
    assert finding.example.startswith("line 14, ")


def test_boxes_from_memory_have_an_example_without_a_line() -> None:
    made = dataset(x=[*walk(), Box(12, 700, 0, 10, 10, score=0.5)])
    finding = find(made, "outside-picture")
    assert (finding.file, finding.example) == ("", "recording r0, frame 12")


def test_an_unknown_system_is_an_error() -> None:
    with pytest.raises(InputError, match="no system 'z'"):
        audit(dataset(), x="z")


def test_x_is_the_first_system_that_is_not_y() -> None:
    made = dataset(x=walk(), y=walk())
    findings = audit(made, Params(threshold_x=9.0), y="x")
    kept_nothing = [
        finding.subject for finding in findings if finding.code == "threshold-keeps-nothing"
    ]
    assert kept_nothing == ["y"]


def test_the_audit_changes_nothing() -> None:
    made = with_left_out(dataset(), ("x", "r0", 3, "no area"))
    before = made.boxes.copy(), made.left_out.copy()
    audit(made)
    pd.testing.assert_frame_equal(made.boxes, before[0])
    pd.testing.assert_frame_equal(made.left_out, before[1])


class ReadParams(Params):
    """Settings that keep which of them were read."""

    def __getattribute__(self, name: str) -> object:
        if name in SETTINGS:
            READ.add(name)
        return super().__getattribute__(name)


READ: set[str] = set()


@pytest.mark.parametrize("proximity", ["height", "horizon", "distance"])
@pytest.mark.parametrize("match", ["iou", "lateral"])
def test_the_audit_reads_no_setting_but_those_that_are_said_to_move_it(match, proximity) -> None:
    params = ReadParams(match=match, proximity=proximity)
    READ.clear()
    audit(dataset(truth_walk(), walk(), walk()), params)
    assert {"threshold_x", "distance", "speed_kmh"} <= READ <= {*AUDIT_SETTINGS}
