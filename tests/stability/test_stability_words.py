"""Stability in sentences."""

from __future__ import annotations

import pytest
from builders import Box, Place, at, make_dataset, result_of

from nvcore.comparison import Result, compare
from nvcore.params import Params
from nvcore.stability.map import map_stability
from nvcore.stability.scores import Criterion
from nvcore.stability.words import describe_stability, difference_text


def words(result: Result, plane: str, criterion: str, **more: int) -> str:
    return " ".join(describe_stability(map_stability(result, plane, criterion, **more)))


def turning(**params: float) -> Result:
    """X - Y = 0.5 - 1.5 alpha (see test_stability)."""
    data = make_dataset([at(0, 50)], [], [at(0, 50, score=0.9), at(0, 25, score=0.4)])
    return result_of(data, **params)


def test_a_verdict_that_turns_says_where() -> None:
    assert words(turning(), "alpha-midpoint", "similarity", n_points=11) == (
        "As analysed, Y has the higher mean similarity, by 0.8500. The verdict holds in all of the "
        "plausible range: misses against false alarms (alpha) 0.5 to 1 (a miss counts at least as "
        "much as a false alarm). Alpha: all else as it is, it holds for every value tried from 0.4 "
        "to 1; at 0.3333 it turns to X. The nearest setting on this map that overturns this: alpha "
        "0.3333, where it turns to X, outside the plausible range and 1.1 times its width away."
    )


def test_a_verdict_outside_the_plausible_range_holds_in_none_of_it() -> None:
    said = words(turning(alpha=0.1), "alpha-midpoint", "similarity")
    assert "X has the higher mean similarity, by 0.3500. The verdict holds in none of the" in said
    assert "The settings in use lie outside the plausible range themselves: alpha 0.1." in said
    assert (
        "Alpha: all else as it is, it holds for every value "
        "tried from 0 to 0.325; at 0.3333 it turns to Y." in said
    )


def test_a_verdict_that_never_turns_says_so() -> None:
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)], []))
    assert words(result, "edge-weight", "similarity") == (
        "As analysed, X has the higher mean similarity, by 0.9000. The verdict holds in all of the "
        "plausible range: traffic context (edge weight) 0 to 1 (from towns to rural roads). "
        "Traffic context: all else as it is, it "
        "holds for every value tried from 0 to 1, the whole map. Nowhere on this map does Y "
        "come level."
    )
    assert words(result, "alpha-midpoint", "similarity").endswith(
        "Nowhere on this map is Y better; the nearest tie: alpha 0, outside the plausible range "
        "and 1.8 times its width away."
    )


def test_a_setting_that_does_not_enter_is_said_not_to() -> None:
    result = result_of(make_dataset([at(0, 50, track=1)], [at(0, 50)], []))
    assert words(result, "edge-weight-alpha", "encounters") == (
        "As analysed, X detects more encounters, by 1 encounter. Traffic context and alpha do not "
        "enter into it."
    )
    said = words(result, "edge-weight-alpha", "saliency")
    assert (
        "Alpha does not enter into it. The verdict holds in all of the plausible range: traffic"
        in said
    )


def test_choices_are_told_one_by_one() -> None:
    # X's box is too small for an overlap of a half, and in the right place
    truth = [at(0, 50, w=20.0, track=1)]
    result = result_of(make_dataset(truth, [at(0, 50, w=4.0)], []))
    said = words(result, "matching", "encounters")
    assert "As analysed, X and Y detect equally many encounters." in said
    assert (
        "With matching by sideways position, all else as it is, "
        "X detects more encounters, by 1 encounter."
    ) in said
    assert (
        "IoU: all else as it is, it holds for every value "
        "tried from 0.22 to 0.9; at 0.2 it turns to X." in said
    )
    assert (
        "ends the tie: IoU 0.2 and matching by overlap of the boxes "
        "(X ahead by 1 encounter), outside the" in said
    )
    assert (
        "nearest within the plausible range: "
        "IoU 0.5 and matching by sideways position (X ahead by 1" in said
    )


def test_a_tie_everywhere_is_a_tie() -> None:
    result = result_of(make_dataset([at(0, 50)], [at(0, 50)], [at(0, 50)]))
    said = words(result, "edge-weight", "saliency")
    assert said.endswith("It is a tie all over this map.")


def test_what_is_undefined_says_why() -> None:
    assert words(result_of(make_dataset(n_frames=0)), "edge-weight", "similarity") == (
        "As analysed the verdict is undefined: there are no frames."
    )
    far = compare(make_dataset([at(0, 50, h=1.0)], [], []), Params())
    assert words(far, "alpha-midpoint", "encounters") == (
        "As analysed the verdict is undefined: no encounter is near enough to count."
    )


def test_recordings_of_different_height_are_told_the_share_only() -> None:
    places = [Place([0], height=100), Place([0], height=300)]
    truth: list[Box] = [at(0, 50, recording=0), at(0, 50, recording=1)]
    said = words(
        compare(make_dataset(truth, truth, [], places=places), Params()),
        "alpha-midpoint", "similarity",
    )  # fmt: skip
    assert (
        '"Counts half at (midpoint)" is each recording\'s own here, 10 to 30 px: the settings in '
        "use are no single point of this map."
    ) in said
    assert (
        "counts half at (midpoint) 6 to 45 px "
        "(6 % of the lowest picture's height to 15 % of the tallest" in said
    )
    assert "all else as it is" not in said
    assert "X has the higher mean similarity" in said


def test_a_stretch_that_ends_without_a_near_encounter_says_so() -> None:
    data = make_dataset([at(0, 50, h=12.0)], [at(0, 50, h=12.0)], [])  # 100 px high picture
    said = words(compare(data, Params()), "alpha-midpoint", "encounters", n_points=24)
    assert "for every value tried from 2 to 12 px; at 13 px it becomes undefined." in said
    assert (
        "in all of the plausible range, where that is defined: "
        "counts half at (midpoint) 6 to 15 px (" in said
    )


def test_a_plausible_range_without_a_near_encounter_is_undefined() -> None:
    data = make_dataset([at(0, 50, h=5.0)], [at(0, 50, h=5.0)], [])  # 100 px high picture
    said = words(compare(data, Params(midpoint=4.0)), "alpha-midpoint", "encounters")
    assert "In the plausible range it is undefined: counts half at (midpoint) 6 to 15 px (" in said


def test_a_verdict_of_one_point_is_told_as_such() -> None:
    # Y is even with X until its threshold leaves nothing
    truth = [at(i, 50, track=i) for i in range(2)]
    x = [box._replace(score=0.5) for box in truth] + [at(0, 5, score=0.1), at(0, 5, score=0.9)]
    y = [*(box._replace(score=0.9) for box in truth), at(0, 5, score=0.8)]
    result = result_of(make_dataset(truth, x, y), threshold_x=0.5, threshold_y=0.95)
    said = words(result, "thresholds", "encounters", n_points=3)
    assert (
        "Threshold of Y: all else as it is, it holds for 0.95 only; at 0.9 it becomes a tie."
        in said
    )


def test_a_plausible_turn_is_not_told_to_be_none() -> None:
    truth = [at(0, 10), at(1, 10)]
    tie = result_of(make_dataset(truth, [], [at(0, 40), at(1, 40)]), alpha=1.0, edge_weight=0.6)
    said = words(tie, "edge-weight", "similarity", n_points=11)
    assert said.endswith(
        "the nearest tie: traffic context 0.5, "
        "inside the plausible range and 0.1 times its width away."
    )


def test_a_turn_before_the_plausible_range_does_not_hide_the_one_within() -> None:
    said = words(turning(alpha=0.2), "alpha-midpoint", "similarity", n_points=11)
    assert (
        "The nearest setting on this map that overturns this: alpha 0.3333, where it turns to Y, "
        "outside the plausible range and 0.27 times its width away. The nearest within the "
        "plausible range: alpha 0.5 (Y ahead by 0.2500), inside"
    ) in said


def test_two_settings_with_one_reason_are_given_it_once() -> None:
    boxes = [at(0, 50, score=0.5), at(0, 5, score=0.1), at(0, 5, score=0.9)]
    said = words(result_of(make_dataset([at(0, 50)], boxes, boxes)), "thresholds", "similarity")
    assert said.count("0.01 to 1 false alarms per frame, where the scores give that") == 1


@pytest.mark.parametrize(
    ("criterion", "difference", "said"),
    [
        ("similarity", 0.0404, "0.0404"),
        ("similarity", -0.04, "0.0400"),
        ("similarity", 0.00002, "less than 0.0001"),
        ("similarity", 0.00008, "0.0001"),
        ("saliency", -0.4256, "0.43 s"),
        ("saliency", 0.001, "less than 0.01 s"),
        ("encounters", -1.0, "1 encounter"),
    ],
)
def test_differences_have_the_digits_of_the_tables(
    criterion: Criterion, difference: float, said: str
) -> None:
    assert difference_text(criterion, difference) == said


@pytest.mark.parametrize("criterion", ["similarity", "encounters", "saliency"])
def test_a_share_of_nearly_all_is_not_told_as_all(criterion: str) -> None:
    said = words(turning(alpha=0.34), "alpha-midpoint", criterion)
    assert "100 %" not in said
    assert " 0 %" not in said
