"""Stability in sentences: every situation, with what its words must hold."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import map_stability
from nvcore.evidence.stability.notes import describe_in_short, describe_stability, difference_text
from nvcore.evidence.stability.scores import Criterion
from nvcore.settings.params import Params

ALPHA, EDGE, BOTH, MATCHING = "alpha-midpoint", "edge-weight", "edge-weight-alpha", "matching"
SIMILARITY, ENCOUNTERS, SALIENCY = "similarity", "encounters", "saliency"


def words(result: Result, plane: Plane, criterion: Criterion, n_points: int = 41) -> str:
    return " ".join(describe_stability(map_stability(result, plane, criterion, n_points=n_points)))


def turning(**params: float) -> Result:
    """X - Y = 0.5 - 1.5 alpha (see test_map)."""
    data = make_dataset([at(0, 50)], [], [at(0, 50, score=0.9), at(0, 25, score=0.4)])
    return result_of(data, **params)


def near_or_far(h: float, **params: float) -> Result:
    """An encounter that X detects, in a picture 100 px high."""
    return compare(make_dataset([at(0, 50, h=h)], [at(0, 50, h=h)], []), Params(**params))


def two_heights() -> Result:
    places = [Place([0], height=100), Place([0], height=300)]
    truth = [at(0, 50, recording=0), at(0, 50, recording=1)]
    return compare(make_dataset(truth, truth, [], places=places), Params())


def one_threshold() -> Result:
    """Y is even with X until its threshold leaves nothing."""
    truth = [at(i, 50, track=i) for i in range(2)]
    x = [box._replace(score=0.5) for box in truth] + [at(0, 5, score=0.1), at(0, 5, score=0.9)]
    y = [*(box._replace(score=0.9) for box in truth), at(0, 5, score=0.8)]
    return result_of(make_dataset(truth, x, y), threshold_x=0.5, threshold_y=0.95)


def plausible_tie() -> Result:
    data = make_dataset([at(0, 10), at(1, 10)], [], [at(0, 40), at(1, 40)])
    return result_of(data, alpha=1.0, edge_weight=0.6)


def same_scores() -> Result:
    boxes = [at(0, 50, score=0.5), at(0, 5, score=0.1), at(0, 5, score=0.9)]
    return result_of(make_dataset([at(0, 50)], boxes, boxes))


SITUATIONS: dict[str, Callable[[], Result]] = {
    "no frames": lambda: result_of(make_dataset(n_frames=0)),
    "x ahead": lambda: result_of(make_dataset([at(0, 50)], [at(0, 50)], [])),
    "implausible": lambda: turning(alpha=0.1),
    "nearly plausible": lambda: turning(alpha=0.2),
    "distant": lambda: near_or_far(1.0),
    "5 px": lambda: near_or_far(5.0, midpoint=4.0),
    "12 px": lambda: near_or_far(12.0),
    # X's box is too small for an overlap of a half, and in the right place
    "narrow box": lambda: result_of(make_dataset([at(0, 50, w=20.0)], [at(0, 50, w=4.0)], [])),
    "two heights": two_heights,
    "one threshold": one_threshold,
    "plausible tie": plausible_tie,
    "same scores": same_scores,
}


def test_a_verdict_that_turns_says_where() -> None:
    assert words(turning(), ALPHA, SIMILARITY, n_points=11) == (
        "As analysed, Y has the higher mean similarity, by 0.8500. The verdict holds in all of the "
        "plausible range: misses against false alarms (alpha) 0.5 to 1 (a miss counts at least as "
        "much as a false alarm). Alpha: with all else unchanged, the verdict holds for every value "
        "tried from 0.4 to 1; at 0.3333 it turns to X. The nearest setting on this map that "
        "overturns the verdict is alpha 0.3333, where it turns to X, outside the plausible range "
        "and 1.1 times its width away."
    )


def test_in_short_it_is_the_verdict_and_its_share() -> None:
    def in_short(result: Result, criterion: Criterion) -> str:
        return describe_in_short(map_stability(result, ALPHA, criterion, n_points=11))

    assert in_short(turning(), SIMILARITY) == (
        "As analysed, Y has the higher mean similarity, by 0.8500. The verdict holds in all of the "
        "plausible range."
    )
    assert "plausible" not in in_short(near_or_far(1.0), ENCOUNTERS)  # undefined


@pytest.mark.parametrize(
    ("situation", "plane", "criterion", "text"),
    [
        ("no frames", EDGE, SIMILARITY, "the verdict is undefined: there are no frames."),
        ("distant", ALPHA, ENCOUNTERS, "undefined: no encounter is near enough to count."),
        ("x ahead", BOTH, ENCOUNTERS, "X detects 1 encounter more. Traffic context"),
        ("x ahead", BOTH, ENCOUNTERS, "Traffic context and alpha have no effect on"),
        ("x ahead", BOTH, SALIENCY, "Alpha has no effect on the verdict. The verdict holds"),
        ("x ahead", EDGE, SIMILARITY, "the whole map. Y does not reach a tie anywhere on"),
        ("x ahead", ALPHA, SIMILARITY, "on this map. The nearest tie is at alpha 0, outside"),
        ("implausible", ALPHA, SIMILARITY, "holds in none of the"),
        ("implausible", ALPHA, SIMILARITY, "in use are outside the plausible range: alpha 0.1"),
        ("nearly plausible", ALPHA, SIMILARITY, "where it turns to Y, outside the plausible"),
        ("nearly plausible", ALPHA, SIMILARITY, "within the plausible range is alpha 0.5 (Y ahead"),
        ("narrow box", MATCHING, ENCOUNTERS, "X and Y detect the same number of encounters."),
        ("narrow box", MATCHING, ENCOUNTERS, "With matching by sideways position and all else"),
        ("narrow box", MATCHING, ENCOUNTERS, "ends the tie is IoU 0.2 and matching by overlap of"),
        ("same scores", EDGE, SALIENCY, "The verdict is a tie everywhere on this map."),
        ("two heights", ALPHA, SIMILARITY, "has a separate value in each recording here (10 to 30"),
        ("two heights", ALPHA, SIMILARITY, "6 to 45 px (6 % of the lowest picture's height to"),
        ("12 px", ALPHA, ENCOUNTERS, " px it becomes undefined."),
        ("12 px", ALPHA, ENCOUNTERS, "of the plausible range, where it is defined:"),
        ("5 px", ALPHA, ENCOUNTERS, "is undefined in the plausible range: counts half"),
        ("one threshold", "thresholds", ENCOUNTERS, "for 0.95 only; at 0.9 it becomes a tie."),
        ("plausible tie", EDGE, SIMILARITY, "inside the plausible range and 0.1 times its width"),
    ],
)
def test_each_situation_has_its_words(
    situation: str, plane: Plane, criterion: Criterion, text: str
) -> None:
    assert text in words(
        SITUATIONS[situation](), plane, criterion, 3 if plane == "thresholds" else 41
    )


def test_two_settings_with_one_reason_are_given_it_once() -> None:
    text = words(same_scores(), "thresholds", "similarity")
    assert text.count("0.01 to 1 false alarms per frame, where the scores give that") == 1


@pytest.mark.parametrize(
    ("criterion", "difference", "text"),
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
    criterion: Criterion, difference: float, text: str
) -> None:
    assert difference_text(criterion, difference) == text


@pytest.mark.parametrize("criterion", ["similarity", "encounters", "saliency"])
def test_a_share_of_nearly_all_is_not_told_as_all(criterion: Criterion) -> None:
    text = words(turning(alpha=0.34), ALPHA, criterion)
    assert "100 %" not in text
    assert " 0 %" not in text
