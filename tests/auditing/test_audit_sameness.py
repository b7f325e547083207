from __future__ import annotations

from typing import Any

import pytest
from audit_comparison import codes, drawn, truth_walk, walk
from builders import Box, make_dataset

from nvcore.auditing import audit
from nvcore.dataset import Dataset
from nvcore.findings import Finding, Severity
from nvcore.params import Params


def exact(x: list[Box], y: list[Box], truth: list[Box] | None = None) -> Dataset:
    """A comparison of just these boxes, not redrawn."""
    truth = truth_walk() if truth is None else truth
    return make_dataset(truth, x, y, n_frames=40, width=640, height=480)


def same(made: Dataset, params: Params | None = None, **names: Any) -> list[Finding]:
    return [one for one in audit(made, params, **names) if one.code == "same-boxes"]


def test_x_and_y_with_the_same_boxes_are_a_warning() -> None:
    boxes = drawn(walk(), 1)
    (finding,) = same(exact(boxes, boxes))
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "x", 40)
    assert "x and y have exactly the same 40 boxes" in finding.message
    assert "given twice" in finding.advice


def test_the_order_of_the_rows_and_the_scores_do_not_matter() -> None:
    pairs = [*drawn(walk(), 1), *drawn(walk(), 200)]
    other = [box._replace(score=0.7) for box in reversed(pairs)]
    assert len(same(exact(pairs, other))) == 1


BOXES = drawn(walk(), 1)
STILL = [Box(f, 300, 200, 40, 100, score=0.6) for f in range(30)]


@pytest.mark.parametrize(
    ("x", "y"),
    [
        (BOXES, [*BOXES[:-1], BOXES[-1]._replace(h=99)]),
        (STILL, [box._replace(frame=box.frame + 1) for box in STILL]),
        (walk(stop=19), walk(stop=19)),
        # 37 of the truth's 40 boxes
        (BOXES, [*walk(stop=37), *drawn(walk(first=37), 1)]),
    ],
    ids=["differ in one box", "other frames", "few may be the same by chance", "37 of the truth"],
)
def test_boxes_are_not_the_same(x: list[Box], y: list[Box]) -> None:
    assert same(exact(x, y)) == []


def test_one_system_at_two_thresholds_or_against_itself_is_a_comparison() -> None:
    assert same(exact(BOXES, BOXES), Params(threshold_x=0.6)) == []
    assert same(exact(BOXES, drawn(walk(), 2)), x="x", y="x") == []


@pytest.mark.parametrize("n", [38, 40])
def test_the_truth_given_as_a_system_is_a_warning_from_95_percent_on(n: int) -> None:
    (finding,) = same(exact(BOXES, [*walk(stop=n), *drawn(walk(first=n), 1)]))
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "y", n)
    assert f"{n} of 40 boxes are exactly those of the ground truth" in finding.message


def test_a_system_that_repeats_its_own_boxes_does_not_pass_for_the_truth() -> None:
    # 30 boxes, each 40 times: all but 30 of 1,200 repeat another one, none is the truth's
    boxes = drawn(walk(stop=30), 1) * 40
    made = exact(drawn(walk(), 2), boxes)
    assert same(made) == []
    assert "duplicate-box" in codes(made)
