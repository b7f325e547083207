"""Turns of a stability map: what is told of one map agrees with itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nvcore.evidence.stability.axes import Axis
from nvcore.evidence.stability.map import StabilityMap, winners
from nvcore.evidence.stability.notes import describe_stability
from nvcore.evidence.stability.scores import Criterion

NAMES = ("alpha", "midpoint", "iou")
CRITERIA: tuple[Criterion, ...] = ("similarity", "encounters", "saliency")
few = settings(max_examples=60, deadline=None, derandomize=True)


def make_axis(name: str, values: list[float], plausible: tuple[int, int], present: int) -> Axis:
    """Plausible between two of the values, analysed at one of them."""
    grid = np.array(values)
    ends = (values[plausible[0]], values[plausible[1]])
    return Axis(name, name, "", grid, ends, "a reason", (values[present], values[present]), name)


def make_map(axes: tuple[Axis, ...], difference: np.ndarray, criterion: Criterion) -> StabilityMap:
    at_present = tuple(axis.present_index for axis in axes)
    return StabilityMap(
        "alpha-midpoint", criterion, axes, difference, winners(difference),
        float(difference[at_present]), (True,) * len(axes),
    )  # fmt: skip


def plain_map(difference: list[list[float]], present: tuple[int, int]) -> StabilityMap:
    """Axes 0, 1, 2, ... on which everything is plausible."""
    field = np.array(difference)
    axes = tuple(
        make_axis(name, [float(i) for i in range(n)], (0, n - 1), at)
        for name, n, at in zip(NAMES, field.shape, present, strict=False)
    )
    return make_map(axes, field, "similarity")


@st.composite
def axes(draw: st.DrawFn, name: str) -> Axis:
    steps = draw(st.lists(st.integers(1, 9), min_size=3, max_size=7))
    values = np.cumsum(steps).astype(float).tolist()
    place = st.integers(0, len(values) - 1)
    low, high = sorted(draw(st.lists(place, min_size=2, max_size=2, unique=True)))
    return make_axis(name, values, (low, high), draw(place))


@st.composite
def maps(draw: st.DrawFn) -> StabilityMap:
    names = draw(st.permutations(NAMES))[: draw(st.integers(1, 2))]
    drawn_axes = tuple(draw(axes(name)) for name in names)
    size = int(np.prod([len(axis) for axis in drawn_axes]))
    cells = st.sampled_from([-2.0, -0.5, 0.0, 0.25, 1.0, 3.0, np.nan])
    field = np.array(draw(st.lists(cells, min_size=size, max_size=size)))
    field = field.reshape([len(axis) for axis in drawn_axes])
    return make_map(drawn_axes, field, draw(st.sampled_from(CRITERIA)))


@few
@given(maps())
def test_no_cell_that_overturns_is_nearer_than_the_nearest(stability: StabilityMap) -> None:
    other = {"x": ["y"], "y": ["x"], "even": ["x", "y"], "undefined": []}[stability.verdict]
    cells = np.argwhere(np.isin(stability.winner.astype(str), other))
    assert (stability.overturn is None) == (len(cells) == 0)
    for cell in cells:
        apart = [
            abs(axis.values[i] - axis.present[0]) / (axis.plausible[1] - axis.plausible[0])
            for axis, i in zip(stability.axes, cell, strict=True)
        ]
        assert stability.overturn.distance <= np.hypot.reduce(apart) + 1e-8


@few
@given(maps())
def test_inside_or_outside_is_that_of_the_numbers_told(stability: StabilityMap) -> None:
    for turn in (*stability.overturns, stability.plausible_overturn, stability.end):
        if turn is None:
            continue
        inside = [
            axis.plausible[0] - 1e-6 <= value <= axis.plausible[1] + 1e-6
            for axis, value in zip(stability.axes, turn.place, strict=True)
        ]
        assert turn.is_plausible == all(inside)
        names = [axis.name for axis in stability.axes]
        assert turn.settings == dict(zip(names, turn.place, strict=True))


@few
@given(maps())
def test_a_share_of_all_goes_with_no_turn_inside_and_less_with_one(stability: StabilityMap) -> None:
    if stability.verdict == "undefined" or np.isnan(stability.share_held):
        return
    ends_inside = [
        winner not in (stability.verdict, "undefined")
        and all(
            axis.is_plausible(axis.values[i]) for axis, i in zip(stability.axes, at, strict=True)
        )
        for at, winner in np.ndenumerate(stability.winner)
    ]
    assert (stability.share_held > 1 - 1e-9) == (not any(ends_inside))
    if stability.plausible_overturn is not None:
        assert stability.share_held < 1 - 1e-9
        assert stability.overturn.distance <= stability.plausible_overturn.distance + 1e-8


@few
@given(maps())
def test_the_sentences_give_the_nearest_number_of_the_map(stability: StabilityMap) -> None:
    text = " ".join(describe_stability(stability))
    assert ("overturns the verdict is " in text or "ends the tie is " in text) == bool(
        stability.overturns
    )
    assert ("within the plausible range" in text) == (
        stability.plausible_overturn is not None
        and stability.plausible_overturn != stability.overturn
    )
    assert ("also better in" in text) == (len(stability.overturns) > 1)


OBLIQUE = [[8, 8, 8, -8], [8, 8, -1, -8], [8, -8, -8, -8], [-8, -8, -8, -8]]


@pytest.mark.parametrize(
    ("difference", "present", "place", "distance"),
    [
        # along the second axis from 3 to -1: zero at 3/4 of the way
        ([[9, 9, 9], [9, 3, -1], [9, 9, 9]], (1, 1), (1.0, 1.75), 0.75 / 2),
        ([[9, 3, 0, -2], [9, 9, 9, 9]], (0, 1), (0.0, 2.0), 1 / 3),  # a tie at one point
        (OBLIQUE, (0, 0), (1.5, 1.0), np.hypot(1.5, 1) / 3),  # along the axes: 2.5
    ],
)
def test_the_nearest_turn_is_where_the_difference_is_zero(
    difference: list[list[float]],
    present: tuple[int, int],
    place: tuple[float, float],
    distance: float,
) -> None:
    turn = plain_map(difference, present).overturn
    assert turn is not None
    assert (turn.place, turn.winner) == (place, "y")
    assert turn.distance == pytest.approx(distance)


def test_where_the_difference_makes_steps_the_point_beyond_is_told() -> None:
    stability = replace(plain_map([[9, 9], [3, -1]], (1, 0)), criterion="encounters")
    assert stability.overturn is not None
    assert (stability.overturn.place, stability.overturn.difference) == ((1.0, 1.0), -1)


def test_every_separate_part_of_the_map_is_told() -> None:
    stability = plain_map([[-1, 1, 1, 1, 1], [1, 1, 1, 1, 1], [1, 1, 1, 1, -3]], (1, 3))
    assert [turn.cell for turn in stability.overturns] == [14, 0]
    sentence = describe_stability(stability)[-1]
    assert sentence.startswith("Y is also better in another part of this map. The nearest ")
    assert "where it turns to Y, inside the plausible range and" in sentence


def test_parts_that_touch_at_a_corner_are_one() -> None:
    stability = plain_map([[1, 1, 1], [1, -1, 1], [1, 1, -1]], (0, 0))
    assert len(stability.overturns) == 1


def test_a_turn_among_the_recordings_own_values_is_no_distance_away() -> None:
    stability = plain_map([[3, 1, -1, 3]] * 2, (0, 0))
    own = replace(stability.axes[1], present=(0.0, 3.0))
    stability = replace(stability, axes=(stability.axes[0], own))
    assert stability.overturn is not None
    assert stability.overturn.distance == 0
    assert describe_stability(stability)[-1].endswith(
        "inside the plausible range and among the recordings' own values."
    )


def test_a_tie_that_ends_on_several_sides_names_no_winner_for_all_of_them() -> None:
    stability = plain_map([[0, 0, 2, 0, -2, 0, -1], [0] * 7], (0, 0))
    *_, nearest, others = describe_stability(stability)
    assert "ends the tie is alpha 0 and midpoint 2 (X ahead by 2.0000)" in nearest
    assert others.startswith(
        "X or Y is also better in 2 other parts of this map. The nearest setting there is alpha 0 "
        "and midpoint 4 (Y"
    )
