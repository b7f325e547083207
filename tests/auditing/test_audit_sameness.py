from __future__ import annotations

from typing import Any

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


def test_x_and_y_that_differ_in_one_box_are_not_the_same() -> None:
    boxes = drawn(walk(), 1)
    assert same(exact(boxes, [*boxes[:-1], boxes[-1]._replace(h=99)])) == []


def test_x_and_y_with_the_same_boxes_in_other_frames_are_not_the_same() -> None:
    still = [Box(f, 300, 200, 40, 100, score=0.6) for f in range(30)]
    assert same(exact(still, [box._replace(frame=box.frame + 1) for box in still])) == []


def test_few_boxes_may_be_the_same_by_chance() -> None:
    boxes = walk(stop=19)
    assert same(exact(boxes, boxes)) == []


def test_one_file_at_two_thresholds_is_a_comparison() -> None:
    boxes = drawn(walk(), 1)
    assert same(exact(boxes, boxes), Params(threshold_x=0.6)) == []


def test_a_system_against_itself_is_not_reported() -> None:
    assert same(exact(drawn(walk(), 1), drawn(walk(), 2)), x="x", y="x") == []


def test_the_truth_given_as_a_system_is_a_warning() -> None:
    (finding,) = same(exact(drawn(walk(), 1), walk()))
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "y", 40)
    assert "40 of 40 boxes are exactly those of the ground truth" in finding.message


def test_nineteen_of_twenty_boxes_of_the_truth_are_a_warning() -> None:
    # 38 of 40 boxes: 95 %
    boxes = [*walk(stop=38), *drawn(walk(first=38), 1)]
    (finding,) = same(exact(drawn(walk(), 1), boxes))
    assert finding.count == 38


def test_fewer_boxes_of_the_truth_are_no_finding() -> None:
    boxes = [*walk(stop=37), *drawn(walk(first=37), 1)]
    assert same(exact(drawn(walk(), 1), boxes)) == []


def test_a_system_that_repeats_its_own_boxes_does_not_pass_for_the_truth() -> None:
    # 30 boxes, each 40 times: all but 30 of 1,200 repeat another one, none is the truth's
    boxes = drawn(walk(stop=30), 1) * 40
    made = exact(drawn(walk(), 2), boxes)
    assert same(made) == []
    assert "duplicate-box" in codes(made)
