"""Scores that end at different values, distances of one source only, encounters of one frame."""

from __future__ import annotations

from dataclasses import replace

import pytest
from audit_comparison import codes, dataset, drawn, find, truth_walk, walk
from builders import NAN, Box, Place, make_dataset

from nvcore.common.findings import Remedy, Severity, Step
from nvcore.comparison.compare import compare
from nvcore.dataset import Dataset
from nvcore.evidence.operating_points import are_unequal
from nvcore.settings.params import Params

FRAMES = 40


def hits(low: float, off: float) -> list[Box]:
    """A right detection in every frame; the lowest score is the first one's."""
    return [box._replace(score=low if box.frame == 0 else 0.9) for box in drawn(walk(), off)]


def alarms(scores: list[float], x: float) -> list[Box]:
    """A false alarm in each of the first frames."""
    return [Box(f, x, 20, 30, 60, score=score) for f, score in enumerate(scores)]


def compared(x: list[Box], y: list[Box]) -> Dataset:
    return make_dataset(truth_walk(), x, y, n_frames=FRAMES, width=640, height=480)


def low_and_high() -> Dataset:
    """X: 20 false alarms of 0.01 to 0.77 by 0.04. Y: 10, and no score below 0.10."""
    x = [*hits(0.9, 1), *alarms([round(0.01 + 0.04 * i, 2) for i in range(20)], 500)]
    return compared(x, [*hits(0.9, 2), *alarms([0.1] * 10, 400)])


def test_scores_that_end_at_different_values_are_a_warning() -> None:
    finding = find(low_and_high(), "score-floors")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "x", 60)
    # 60 and 50 detections in 40 frames
    assert "x has scores down to 0.010 (1.5 detections per frame)" in finding.message
    assert "y down to 0.100 (1.2 detections per frame)" in finding.message


def test_the_advice_names_the_threshold_of_as_many_false_alarms() -> None:
    # X's ten highest are 0.41, 0.45, ..., 0.77, the next one 0.37
    finding = find(low_and_high(), "score-floors")
    assert dict(finding.suggestion) == {"threshold": pytest.approx(0.38, abs=0.01)}
    assert "0.38 for x alone leaves it 0.25 false alarms per frame" in finding.advice
    assert "y has 0.25 (10 false alarms in all)" in finding.advice


def test_the_threshold_is_that_of_the_system_with_more_false_alarms() -> None:
    many = [*hits(0.9, 1), *alarms([0.01] + [0.2 + i / 100 for i in range(19)], 500)]
    finding = find(compared([*hits(0.9, 2), *alarms([0.1] * 10, 400)], many), "score-floors")
    assert finding.subject == "y"
    assert "0.29 for y alone" in finding.advice


@pytest.mark.parametrize("name", ["threshold_x", "threshold_y"])
def test_a_given_threshold_is_a_choice(name: str) -> None:
    assert "score-floors" not in codes(low_and_high(), Params(**{name: 0.3}))


@pytest.mark.parametrize(
    ("low_x", "n_x", "low_y", "n_y"),
    [(0.5, 15, 0.54, 15), (0.5, 9, 0.01, 20)],
    ids=["about the same value", "49 and 60 detections are few"],
)
def test_lowest_scores_are_no_finding(low_x: float, n_x: int, low_y: float, n_y: int) -> None:
    x = [*hits(low_x, 1), *alarms([0.6] * n_x, 500)]
    y = [*hits(low_y, 2), *alarms([0.6] * n_y, 400)]
    assert "score-floors" not in codes(compared(x, y))


@pytest.mark.parametrize(("n_x", "is_unequal"), [(15, False), (16, True)])
def test_lowest_scores_are_a_finding_where_the_verdict_calls_the_operating_points_unequal(
    n_x: int, is_unequal: bool
) -> None:
    """Scores down to 0.01 and 0.10, and X with so many false alarms beside the ten of Y."""
    x = [*hits(0.9, 1), *alarms([0.01 + i / 100 for i in range(n_x)], 500)]
    data = compared(x, [*hits(0.9, 2), *alarms([0.1] * 10, 400)])
    assert ("score-floors" in codes(data)) is is_unequal
    assert are_unequal(compare(data)) is is_unequal


def test_a_system_without_scores_has_no_operating_point_to_choose() -> None:
    x = [box._replace(score=NAN) for box in [*hits(0.5, 1), *alarms([0.6] * 15, 500)]]
    y = [*hits(0.01, 2), *alarms([0.6] * 15, 400)]
    assert "score-floors" not in codes(compared(x, y))


def crowded(n: int) -> Dataset:
    """Scores from -1 to 5; X has 1.25 detections per frame, Y n more in every frame."""
    x = [*hits(-1, 1), *alarms([5] * 10, 500)]
    more = [Box(f, 100 + 40 * i, 400, 30, 60, score=5) for f in range(FRAMES) for i in range(n)]
    return compared(x, [*hits(-1, 2), *more])


def test_far_more_detections_are_a_warning_on_any_scale_of_scores() -> None:
    # 1.25 and 4 detections per frame
    assert find(crowded(3), "score-floors").subject == "y"


def test_up_to_three_times_the_detections_are_no_finding() -> None:
    assert "score-floors" not in codes(crowded(2))


BY_DISTANCE = Params(proximity="distance")


NEAR = walk(distance_m=20.0)


@pytest.mark.parametrize(
    ("truth", "x", "y"),
    [
        (truth_walk(distance_m=20.0), NEAR, NEAR),
        (truth_walk(), walk(), walk()),
        (truth_walk(distance_m=20.0), [*walk(stop=30, distance_m=20.0), *walk(first=30)], NEAR),
        (truth_walk(distance_m=20.0), [], NEAR),
    ],
    ids=["everywhere", "nowhere", "a few missing", "no boxes"],
)
def test_distances_are_weighted_alike(truth: list[Box], x: list[Box], y: list[Box]) -> None:
    assert "mixed-weighting" not in codes(dataset(truth, x, y), BY_DISTANCE)


def test_without_proximity_by_distance_it_does_not_matter() -> None:
    made = dataset(truth_walk(distance_m=20.0), walk(), NEAR)
    assert "mixed-weighting" not in codes(made, Params())


def test_a_system_without_distances_beside_one_with_them_is_a_warning() -> None:
    made = dataset(truth_walk(distance_m=20.0), walk(), walk(distance_m=20.0))
    finding = find(made, "mixed-weighting", BY_DISTANCE)
    assert (finding.severity.value, finding.subject, finding.count) == ("warning", "x", 40)
    assert finding.message == (
        "All 40 boxes that count have no distance and weigh by height: in 1 recording, r0. "
        "Boxes without a distance, by source: truth 0 %, x 100 %, y 0 %."
    )


def test_boxes_without_distances_are_no_cases_but_said_by_recording() -> None:
    """X has distances in one of three recordings alone."""
    places = [(recording, frame) for recording in range(3) for frame in range(2)]
    truth = [Box(f, 50, 20, 20, 60, 1, distance_m=9.0, recording=r) for r, f in places]
    x = [box._replace(track=-1, distance_m=NAN if box.recording else 9.0) for box in truth]
    made = make_dataset(truth, x, drawn(truth, 1.0), places=[Place(range(2))] * 3)
    finding = find(made, "mixed-weighting", BY_DISTANCE)
    assert finding.cases is None
    assert "4 of 6 boxes that count (67 %) have no distance and weigh by height" in finding.message
    assert "the others by metres: in 2 recordings, r1, r2." in finding.message


def test_boxes_without_distances_are_those_that_the_scorecard_counts() -> None:
    """Half of X's boxes lie on ignore regions, a quarter is below the threshold."""
    regions = [Box(f, 400, 200, 40, 100, ignore=True) for f in range(40)]
    low = [box._replace(x=250, score=0.1) for box in walk(stop=20)]
    x = [*walk(), *(box._replace(ignore=False, score=0.9) for box in regions), *low]
    made = dataset([*truth_walk(distance_m=20.0), *regions], x, NEAR)
    params = replace(BY_DISTANCE, threshold_x=0.3)
    finding = find(made, "mixed-weighting", params)
    assert "All 40 boxes that count" in finding.message
    assert compare(made, params).x.weights.n_without_distance == finding.count == 40


def people(n_short: int, n_long: int, *, step: int = 1, h: float = 100) -> Dataset:
    """People seen in one frame, one after the other, and people seen in three, apart from them."""
    boxes = [Box(step * i, 50 + 200 * (i % 2), 200, 40, h, track=i) for i in range(n_short)]
    boxes += [
        Box(step * (3 * i + j), 500, 200, 40, h, track=100 + i)
        for i in range(n_long)
        for j in range(3)
    ]
    place = Place(range(0, 40 * step, step), 640, 480, 10.0)
    return make_dataset(boxes, places=[place])


def test_mostly_short_encounters_are_a_warning() -> None:
    finding = find(people(11, 9), "short-encounters")
    assert (finding.severity, finding.subject, finding.count) == (Severity.WARNING, "truth", 11)
    assert "11 of 20 encounters that count are one evaluated frame long." in finding.message


@pytest.mark.parametrize(
    ("n_short", "n_long", "h"),
    # 20 px of 480 are below the midpoint of 48 px
    [(10, 10, 100), (9, 0, 100), (11, 0, 20)],
    ids=["half of them short", "few of them", "far away"],
)
def test_short_encounters_are_no_finding(n_short: int, n_long: int, h: float) -> None:
    assert "short-encounters" not in codes(people(n_short, n_long, h=h))


def test_sampled_frames_are_named_as_the_reason() -> None:
    message = find(people(11, 9, step=20), "short-encounters").message
    assert "every 20th frame is evaluated" in message
    assert "linked" not in message


def test_linked_tracks_are_named_as_the_reason() -> None:
    # 12 people, each in one frame at a place of their own: nobody overlaps anybody
    boxes = [Box(i, 50 * i, 200, 40, 100) for i in range(12)]
    made = make_dataset(boxes, n_frames=12, width=640, height=480)
    finding = find(made, "short-encounters")
    assert finding.count == 12
    assert "pedestrians without track ids were linked" in finding.message


def test_an_unknown_horizon_is_left_to_the_analysis() -> None:
    assert "short-encounters" not in codes(people(11, 0), Params(proximity="horizon"))
    assert "short-encounters" in codes(people(11, 0), Params(proximity="horizon", horizon=100))


BORROWED = replace(BY_DISTANCE, missing_distance="borrow")


def test_borrowed_distances_are_told_and_no_mixed_weighting() -> None:
    near = walk(distance_m=20.0)
    made = dataset(truth_walk(), near, near)
    assert "mixed-weighting" in codes(made, BY_DISTANCE)
    assert "borrowed-distances" not in codes(made, BY_DISTANCE)
    finding = find(made, "borrowed-distances", BORROWED)
    assert (finding.severity.value, finding.subject, finding.count) == ("note", "truth", 40)
    assert "as x (40) and y (40) report, 0 between those" in finding.message
    assert "differ by 0 % (median)" in finding.message
    assert "mixed-weighting" not in codes(made, BORROWED)


def test_a_single_lender_among_two_systems_is_a_warning() -> None:
    finding = find(dataset(truth_walk(), NEAR, walk()), "borrowed-distances", BORROWED)
    assert finding.severity.value == "warning"
    assert finding.steps == (Step(Remedy.OPTION, "height", "missing_distance"),)


def test_lenders_far_apart_are_a_warning() -> None:
    made = dataset(truth_walk(), NEAR, walk(distance_m=65.0))
    finding = find(made, "borrowed-distances", BORROWED)
    assert finding.severity.value == "warning"
    assert "Check the unit" in finding.advice


def test_many_pedestrians_whom_no_distance_reaches_are_a_warning() -> None:
    seen = walk(stop=20, distance_m=20.0)
    finding = find(dataset(truth_walk(), seen, seen), "borrowed-distances", BORROWED)
    assert finding.severity.value == "warning"
    assert "Of 40 truth boxes 20 (50 %) have no distance and weigh by height." in finding.message
    assert finding.steps == (Step(Remedy.OPTION, "height", "proximity"),)


def test_without_any_lender_borrowing_is_a_warning_where_a_distance_is_missing() -> None:
    finding = find(dataset(truth_walk(), walk(), walk()), "borrowed-distances", BORROWED)
    assert (finding.severity.value, finding.count) == ("warning", 40)
    assert finding.message.startswith("No match reports a distance that could be borrowed")
    assert "distance_m" in finding.advice
    everywhere = dataset(truth_walk(distance_m=20.0), walk(), walk())
    assert "borrowed-distances" not in codes(everywhere, BORROWED)


def test_ignore_regions_weigh_nothing_and_need_no_distance() -> None:
    regions = [box._replace(ignore=True, track=-1) for box in truth_walk()] * 3
    made = dataset([*truth_walk(distance_m=20.0), *regions], NEAR, NEAR)
    assert "mixed-weighting" not in codes(made, BY_DISTANCE)
