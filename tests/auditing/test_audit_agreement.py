from __future__ import annotations

import dataclasses

import pytest
from audit_comparison import N, codes, dataset, find, truth_walk, walk, with_lines
from builders import Box

from nvcore.findings import Severity
from nvcore.params import Params


def extra(x: float, *, first: int = 10, n: int = 3) -> list[Box]:
    """A box of 40 x 100 px at a lateral position, in a few frames."""
    return [Box(f, x, 200, 40, 100, score=0.5 + f / 100) for f in range(first, first + n)]


def test_agreed_detections_of_nobody_are_a_note() -> None:
    made = dataset(x=[*walk(), *extra(500)], y=[*walk(), *extra(505)])
    finding = find(made, "agreed-by-both-not-in-truth")
    assert (finding.severity, finding.subject, finding.count) == (Severity.NOTE, "truth", 3)
    assert finding.example == "recording r0, frame 10"
    assert "x and y agree on 3 boxes" in finding.message


def test_false_alarms_of_one_system_only_are_no_finding() -> None:
    assert codes(dataset(x=[*walk(), *extra(500)])) == []


def test_false_alarms_that_overlap_too_little_do_not_agree() -> None:
    # moved by 20 of 40 px: IoU 1/3
    assert codes(dataset(x=[*walk(), *extra(500)], y=[*walk(), *extra(520)])) == []


def test_agreed_detections_on_an_ignore_region_are_no_finding() -> None:
    region = [Box(f, 480, 150, 100, 200, ignore=True) for f in range(N)]
    made = dataset([*truth_walk(), *region], [*walk(), *extra(500)], [*walk(), *extra(505)])
    assert codes(made) == []


def test_agreed_detections_below_the_threshold_do_not_count() -> None:
    weak = [box._replace(score=0.2) for box in extra(500)]
    made = dataset(x=[*walk(), *weak], y=[*walk(), *extra(505)])
    assert codes(made, Params(threshold_x=0.4)) == []


def disputed(n: int) -> tuple[list[Box], list[Box]]:
    """Truth, and detections that are 25 px off in the first n frames (IoU 15 / 65)."""
    off = [box._replace(x=box.x + 25) if box.frame < n else box for box in walk()]
    return truth_walk(), off


def test_a_pedestrian_that_both_draw_elsewhere_is_a_note() -> None:
    truth, off = disputed(3)
    made = with_lines(dataset(truth, off, off))
    finding = find(made, "box-disputed-by-both")
    assert (finding.severity, finding.subject, finding.count) == (Severity.NOTE, "truth", 3)
    assert (finding.file, finding.example) == ("gt.txt", "line 1, recording r0, frame 0")
    assert "agreed-by-both-not-in-truth" not in codes(made)


def test_many_such_pedestrians_are_a_warning() -> None:
    truth, off = disputed(20)
    assert find(dataset(truth, off, off), "box-disputed-by-both").severity is Severity.WARNING


def test_a_pedestrian_that_one_draws_elsewhere_is_no_finding() -> None:
    truth, off = disputed(3)
    assert codes(dataset(truth, off, walk())) == []


def test_a_pedestrian_that_both_miss_is_no_finding() -> None:
    assert codes(dataset(x=walk(first=3), y=walk(first=3))) == []


def test_a_matched_pedestrian_beside_an_agreed_box_is_not_disputed() -> None:
    # the second box overlaps the pedestrian as well, but the first one matches it
    off = [box._replace(x=box.x + 25) for box in walk(stop=3)]
    made = dataset(x=[*walk(), *off], y=[*walk(), *off])
    assert codes(made) == ["agreed-by-both-not-in-truth"]


@pytest.mark.parametrize("names", [{"x": "x", "y": "x"}, {"x": "y", "y": "y"}])
def test_a_system_against_itself_does_not_agree(names: dict[str, str]) -> None:
    made = dataset(x=[*walk(), *extra(500)], y=[*walk(), *extra(505)])
    assert codes(made, **names) == []


def test_a_single_system_is_audited() -> None:
    made = dataset(y=[])
    alone = dataclasses.replace(made, systems=("x",))
    assert codes(alone) == []
