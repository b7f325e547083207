"""Where on a stability map the verdict flips: the nearest settings, and each setting moved alone.

A flip along one axis is also a candidate for the nearest flip, so that none reported along an axis
is nearer than the one reported as the nearest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np
from scipy.ndimage import label

from nvcore.stability.axes import Axis

Winner = Literal["x", "y", "even", "undefined"]

ROUNDING: Final = 1e-9
"""Differences up to this count as 0: two ways to add up the same frames differ by as much."""


@dataclass(frozen=True)
class Flip:
    """A setting at which the present verdict does not hold.

    Attributes
    ----------
    cell
        Flat index into the map; between two points, the index of the one beyond.
    place
        Its value on each axis.
    settings
        Parameters by name, for ``dataclasses.replace(params, **settings)``.
    difference
        Difference there; positive: X is better; 0 where it crosses 0 between two points.
    winner
        Who is better there, or just beyond.
    distance
        Euclidean distance from the analysed setting, in plausible ranges of the axes.
    is_plausible
        Whether it lies in the plausible range of every axis.
    """

    cell: int
    place: tuple[float, ...]
    settings: Mapping[str, float | str]
    difference: float
    winner: Winner
    distance: float
    is_plausible: bool


@dataclass(frozen=True)
class FlipInterval:
    """How far one setting can be moved alone, all else as analysed, before the verdict flips.

    Attributes
    ----------
    axis
        Position in ``StabilityMap.axes``.
    low, high
        First and last value on the axis, around the analysed value, with the present verdict.
    flips_below, flips_above
        Where it flips: for mean similarity over a setting in which it is continuous, between two
        points by linear interpolation (exact for alpha); else the first point beyond. NaN: not on
        this axis.
    below, above
        Who is better there; "undefined": not on this axis, or undefined there.
    """

    axis: int
    low: float
    high: float
    flips_below: float
    flips_above: float
    below: Winner
    above: Winner


@dataclass(frozen=True)
class Field:
    """The cells of a map.

    Attributes
    ----------
    axes
        Axes of the map.
    difference, winner
        Cells of the map, shape (len(axes[0]), ...).
    is_continuous
        For each axis, whether the difference changes along it without steps.
    """

    axes: tuple[Axis, ...]
    difference: np.ndarray
    winner: np.ndarray
    is_continuous: tuple[bool, ...]


def winners(difference: np.ndarray) -> np.ndarray:
    """`Winner` of every difference; object, the same shape."""
    code = np.select(
        [difference > ROUNDING, difference < -ROUNDING, np.abs(difference) <= ROUNDING],
        range(3),
        default=3,
    )
    names: np.ndarray = np.array(get_args(Winner), dtype=object)[code]
    return names


def find_flips(field: Field, verdict: Winner, is_candidate: np.ndarray) -> tuple[Flip, ...]:
    """The nearest flip to each connected region of candidates, the nearest first.

    Parameters
    ----------
    is_candidate
        Cells in which the verdict does not hold; bool, the shape of the map.

    Notes
    -----
    Considers the candidates themselves and, where the difference is continuous, the places at
    which it leaves 0 between a candidate and a neighbour that has the present verdict or is a tie.
    Of several equally near, the one with the largest difference.
    """
    nearest: dict[int, Flip] = {}
    region = label(is_candidate, np.ones((3,) * is_candidate.ndim))[0].ravel()
    for flip in _by_distance(field, verdict, is_candidate, is_plausible_only=False):
        if (number := int(region[flip.cell])) not in nearest:
            nearest[number] = flip
            if len(nearest) == region.max():
                break
    return tuple(nearest.values())


def find_plausible_flip(field: Field, verdict: Winner, is_candidate: np.ndarray) -> Flip | None:
    """The nearest flip in the plausible range, as in `find_flips`."""
    return next(_by_distance(field, verdict, is_candidate, is_plausible_only=True), None)


def find_interval(field: Field, verdict: Winner, i: int, present: Sequence[int]) -> FlipInterval:
    """How far the verdict holds along axis i from the analysed point, an index on every axis."""
    line = field.difference[
        tuple(slice(None) if j == i else index for j, index in enumerate(present))
    ]
    values, along, start = field.axes[i].values, winners(line), present[i]
    others = np.flatnonzero(along != verdict)
    before, after = others[others < start], others[others > start]
    first = int(before[-1]) + 1 if len(before) else 0
    last = int(after[0]) - 1 if len(after) else len(values) - 1

    def flip(inside: int, outside: int) -> float:
        difference_inside, difference_outside = line[[inside, outside]]
        if not field.is_continuous[i] or not difference_inside * difference_outside < 0:
            return float(values[outside])
        return float(_cross(values[inside], values[outside], difference_inside, difference_outside))

    def beyond(outside: int, step: int) -> Winner:
        winner: Winner = along[outside]
        after: Winner = "undefined"
        if 0 <= outside + step < len(values):
            after = along[outside + step]
        is_crossing = winner == "even" and after in ("x", "y") and after != verdict
        # a tie at a single point of a continuous setting is a flip to the winner after it
        return after if field.is_continuous[i] and is_crossing else winner

    return FlipInterval(
        axis=i,
        low=float(values[first]),
        high=float(values[last]),
        flips_below=flip(first, first - 1) if len(before) else np.nan,
        flips_above=flip(last, last + 1) if len(after) else np.nan,
        below=beyond(first - 1, -1) if len(before) else "undefined",
        above=beyond(last + 1, 1) if len(after) else "undefined",
    )


def combine_axes(parts: Sequence[np.ndarray], combine: np.ufunc) -> np.ndarray:
    """One number per cell from one number per point of each axis."""
    grid = parts[0]
    for part in parts[1:]:
        grid = combine.outer(grid, part)
    return grid


def _cross(inside: Any, outside: Any, difference_inside: Any, difference_outside: Any) -> Any:
    """Where the straight line between the differences at `inside` and `outside` is 0."""
    fraction = difference_inside / (difference_inside - difference_outside)
    return inside + fraction * (outside - inside)


def _by_distance(
    field: Field, verdict: Winner, is_candidate: np.ndarray, *, is_plausible_only: bool
) -> Iterator[Flip]:
    """All flips, the nearest first."""
    cell, places, is_between = _places(field, verdict, is_candidate)
    distance_squared = np.zeros(len(cell))
    is_plausible = np.ones(len(cell), dtype=bool)
    for axis, values in zip(field.axes, places.T, strict=True):
        distance_squared += axis.distance(values) ** 2
        is_plausible &= axis.is_plausible(values)
    distance = np.sqrt(distance_squared)
    difference = np.where(is_between, 0.0, field.difference.ravel()[cell])
    order = np.lexsort((-np.abs(difference), distance.round(9)))
    for i in order[is_plausible[order]] if is_plausible_only else order:
        place = tuple(places[i].tolist())
        yield Flip(
            cell=int(cell[i]),
            place=place,
            settings={
                axis.name: axis.setting_at(value)
                for axis, value in zip(field.axes, place, strict=True)
            },
            difference=float(difference[i]),
            winner=field.winner.ravel()[cell[i]],
            distance=float(distance[i]),
            is_plausible=bool(is_plausible[i]),
        )


def _places(
    field: Field, verdict: Winner, is_candidate: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cell, value on each axis (n, n_axes), and whether the flip is between two points."""
    shape = field.difference.shape
    values = [axis.values for axis in field.axes]
    at_cell = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, len(values))
    number = np.arange(field.difference.size).reshape(shape)
    is_even = (field.winner == "even").ravel()
    holds, is_target = (field.winner == verdict).ravel() | is_even, is_candidate.ravel() & ~is_even
    flat = np.where(is_even, 0.0, field.difference.ravel())
    cells, places = [np.flatnonzero(is_candidate)], [at_cell[is_candidate.ravel()]]
    for i, is_continuous in enumerate(field.is_continuous):
        if not is_continuous or verdict == "even":
            continue
        lower = number.take(range(shape[i] - 1), axis=i).ravel()
        upper = number.take(range(1, shape[i]), axis=i).ravel()
        for inside, outside in ((lower, upper), (upper, lower)):
            passes = holds[inside] & is_target[outside]
            passes &= is_even[inside] | (flat[inside] * flat[outside] < 0)
            a, b = inside[passes], outside[passes]
            place = at_cell[b].copy()
            place[:, i] = _cross(at_cell[a, i], at_cell[b, i], flat[a], flat[b])
            cells.append(b)
            places.append(place)
    cell = np.concatenate(cells)
    return cell, np.concatenate(places), np.arange(len(cell)) >= len(cells[0])
