"""Where X and Y agree against the truth, and boxes that are the very same."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from audit_comparison import N, codes, dataset, drawn, find, reported, truth_walk, walk, with_lines
from builders import Box, make_dataset

from nvcore.auditing import audit
from nvcore.common.findings import Finding, Remedy, Severity
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.notes import Note
from nvcore.report.verdict import verdict
from nvcore.settings.params import Params


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


@pytest.mark.parametrize(("n", "n_others"), [(20, 0), (20, 60), (19, 0), (20, 61)])
def test_false_alarms_on_pedestrians_who_count_as_missed_are_reported(n: int, n_others: int):
    # 20 px off: IoU 20 / 60, no match
    beside = [box._replace(x=box.x + 20) if box.frame < n else box for box in walk()]
    nobody = [Box(f % N, 400 + 50 * (f // N), 200, 40, 100) for f in range(n_others)]
    made = dataset(x=[*beside, *nobody])
    if n < 20 or n_others > 60:  # too few, or less than a quarter
        assert "loose-boxes" not in codes(made)
        return
    assert reported(made, "loose-boxes") == ("warning", "x", n)
    assert f"{n} of {n + n_others} false alarms overlap" in find(made, "loose-boxes").message
    assert "loose-boxes" not in codes(made, Params(iou=0.3))


def test_a_matched_pedestrian_beside_an_agreed_box_is_not_disputed() -> None:
    # the second box overlaps the pedestrian as well, but the first one matches it
    boxes = [*walk(), *(box._replace(x=box.x + 25) for box in walk(stop=3))]
    assert codes(dataset(x=boxes, y=boxes)) == ["agreed-by-both-not-in-truth"]


@pytest.mark.parametrize("name", ["x", "y"])
def test_a_system_against_itself_does_not_agree(name: str) -> None:
    assert codes(dataset(x=extra(500), y=extra(505)), x=name, y=name) == []


def test_a_single_system_is_audited() -> None:
    assert codes(dataclasses.replace(dataset(y=[]), systems=("x",))) == []


def exact(x: list[Box], y: list[Box], truth: list[Box] | None = None) -> Dataset:
    """A comparison of just these boxes, not redrawn."""
    truth = truth_walk() if truth is None else truth
    return make_dataset(truth, x, y, n_frames=40, width=640, height=480)


def same(made: Dataset, params: Params | None = None, **names: Any) -> list[Finding]:
    return [finding for finding in audit(made, params, **names) if finding.code == "same-boxes"]


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


def test_the_truth_given_as_a_system_is_no_comparison() -> None:
    made = exact(BOXES, walk())
    finding = find(made, "truth-as-system")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "y", 40)
    said = verdict(compare(made), audit(made))
    assert (said.headline, said.doubt) == (Note("verdict.truth_as_system"), None)


def test_a_verdict_is_given_beside_the_truth_as_a_further_system() -> None:
    made = exact(BOXES, walk())
    said = verdict(compare(made, x="x", y="x"), audit(made, x="x", y="x"))
    assert said.headline != Note("verdict.truth_as_system")


@pytest.mark.parametrize(
    ("boxes", "n"),
    [
        (walk(stop=26), "26 of 26"),
        ([*walk(stop=38), *drawn(walk(first=38), 1)], "38 of 40"),
        ([*walk(), Box(39, 500, 200, 40, 100)], "40 of 41"),
    ],
    ids=["part of the truth", "95 percent", "the truth and an alarm"],
)
def test_a_system_whose_boxes_are_the_truth_s_is_a_warning(boxes: list[Box], n: str) -> None:
    made = exact(BOXES, boxes)
    assert same(made) == []
    finding = find(made, "boxes-of-truth")
    assert (finding.severity, finding.subject) == (Severity.WARNING, "y")
    assert f"{n} boxes are exactly those of the ground truth" in finding.message


def test_a_verdict_is_given_on_a_system_without_errors_of_place() -> None:
    made = exact(BOXES, walk(stop=26))
    result = compare(made)
    said = verdict(result, audit(made))
    assert said.headline == verdict(result).headline
    assert said.doubt == Note("verdict.doubt", known=["boxes-of-truth"], n_others=0)
    assert verdict(result, audit(exact(BOXES, BOXES))).doubt is None  # the headline says it


@pytest.mark.parametrize(("n", "is_found"), [(20, True), (19, False)])
def test_several_boxes_on_most_pedestrians_are_a_warning_and_not_the_truth_s_fault(
    n: int, is_found: bool
) -> None:
    # three boxes on each pedestrian: IoU of the truth 38 / 42
    beside = [box._replace(x=box.x + dx, score=0.3) for box in walk(stop=n) for dx in (-2, 2)]
    made = dataset(x=[*walk(), *beside], y=[*walk(), *beside])
    assert "agreed-by-both-not-in-truth" not in codes(made)
    found = [finding for finding in audit(made) if finding.code == "several-boxes"]
    if not is_found:
        assert found == []
        return
    assert [(one.severity, one.subject, one.count) for one in found] == [
        ("warning", "x", 40),
        ("warning", "y", 40),
    ]
    assert "20 of 40 pedestrians matched have several boxes: 40 false" in found[0].message
    assert codes(made, Params(threshold_x=0.5, threshold_y=0.5)) == []


@pytest.mark.parametrize(("n_counted", "n_ignored"), [(19, 21), (20, 0)])
def test_more_ignored_boxes_than_pedestrians_detected_are_a_warning(
    n_counted: int, n_ignored: int
) -> None:
    # as where a tool numbers the classes of MOTChallenge's text in another order
    truth = [*truth_walk(stop=n_counted), *truth_walk(first=n_counted, ignore=True)]
    found = [one for one in audit(dataset(truth)) if one.code == "ignored-boxes-detected"]
    assert [one.count for one in found] == [n_ignored, n_ignored] * bool(n_ignored)
    if found:
        assert found[0].message.startswith("x has boxes on 21 of 21 ignored boxes")
        assert found[0].steps[0].remedy is Remedy.CLASSES


def test_a_system_that_repeats_its_own_boxes_does_not_pass_for_the_truth() -> None:
    # 30 boxes, each 40 times: all but 30 of 1,200 repeat another one, none is the truth's
    boxes = drawn(walk(stop=30), 1) * 40
    made = exact(drawn(walk(), 2), boxes)
    assert same(made) == []
    assert "duplicate-box" in codes(made)
