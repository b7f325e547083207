from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from audit_comparison import N, codes, dataset, find, reported, truth_walk, walk, with_lines
from builders import Box

from nvcore.params import Params


def extra(x: float, **more: Any) -> list[Box]:
    """Detections with a box of 40 x 100 px more at a lateral position, in three frames."""
    boxes = [Box(f, x, 200, 40, 100, score=0.5 + f / 100) for f in range(10, 13)]
    return [*walk(), *(box._replace(**more) for box in boxes)]


def off(n: int) -> list[Box]:
    """Detections that are 25 px off in the first n frames (IoU 15 / 65)."""
    return [box._replace(x=box.x + 25) if box.frame < n else box for box in walk()]


def test_agreed_detections_of_nobody_are_a_note() -> None:
    made = dataset(x=extra(500), y=extra(505))
    assert reported(made, "agreed-by-both-not-in-truth") == ("note", "truth", 3)
    finding = find(made, "agreed-by-both-not-in-truth")
    assert finding.example == "recording r0, frame 10"
    assert "x and y agree on 3 boxes" in finding.message


REGION = [Box(f, 480, 150, 100, 200, ignore=True) for f in range(N)]
NO_FINDINGS = {
    "false alarms of one system": {"x": extra(500)},
    "IoU 1/3 of false alarms": {"x": extra(500), "y": extra(520)},
    "agreed on an ignore region": {
        "truth": [*truth_walk(), *REGION],
        "x": extra(500),
        "y": extra(505),
    },
    "a pedestrian whom one draws elsewhere": {"x": off(3)},
    "a pedestrian whom both miss": {"x": walk(first=3), "y": walk(first=3)},
}


@pytest.mark.parametrize("case", NO_FINDINGS)
def test_is_not_reported(case: str) -> None:
    assert codes(dataset(**NO_FINDINGS[case])) == []


def test_agreed_detections_below_the_threshold_do_not_count() -> None:
    made = dataset(x=extra(500, score=0.2), y=extra(505))
    assert codes(made, Params(threshold_x=0.4)) == []


@pytest.mark.parametrize(("n", "severity"), [(3, "note"), (20, "warning")])
def test_a_pedestrian_that_both_draw_elsewhere_is_reported(n: int, severity: str) -> None:
    made = with_lines(dataset(truth_walk(), off(n), off(n)))
    assert reported(made, "box-disputed-by-both") == (severity, "truth", n)
    finding = find(made, "box-disputed-by-both")
    assert (finding.file, finding.example) == ("gt.txt", "line 1, recording r0, frame 0")
    assert "agreed-by-both-not-in-truth" not in codes(made)


def test_a_matched_pedestrian_beside_an_agreed_box_is_not_disputed() -> None:
    # the second box overlaps the pedestrian as well, but the first one matches it
    boxes = [*walk(), *(box._replace(x=box.x + 25) for box in walk(stop=3))]
    assert codes(dataset(x=boxes, y=boxes)) == ["agreed-by-both-not-in-truth"]


@pytest.mark.parametrize("name", ["x", "y"])
def test_a_system_against_itself_does_not_agree(name: str) -> None:
    assert codes(dataset(x=extra(500), y=extra(505)), x=name, y=name) == []


def test_a_single_system_is_audited() -> None:
    assert codes(dataclasses.replace(dataset(y=[]), systems=("x",))) == []
