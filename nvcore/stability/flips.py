"""Flips of the verdict on a stability map: the nearest settings, and each setting moved alone.

A flip along one axis is also a candidate for the nearest flip, so that none reported along an axis
is nearer than the one reported as the nearest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal, get_args

import numpy as np
from scipy.ndimage import label

if TYPE_CHECKING:
    from nvcore.stability.map import StabilityMap

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
    """Range in which one setting can move alone, all else as analysed, before the verdict flips.

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


def winners(difference: np.ndarray) -> np.ndarray:
    """Return the `Winner` of every difference, object, the same shape."""
    code = np.select(
        [difference > ROUNDING, difference < -ROUNDING, np.abs(difference) <= ROUNDING],
        range(3),
        default=3,
    )
    names: np.ndarray = np.array(get_args(Winner), dtype=object)[code]
    return names


def find_flips(
    stability: StabilityMap, is_candidate: np.ndarray, *, is_plausible_only: bool = False
) -> Iterator[Flip]:
    """The nearest flip to each connected region of candidates, the nearest first.

    Parameters
    ----------
    is_candidate
        Cells in which the verdict does not hold; bool, the shape of the map.
    is_plausible_only
        Leave out flips outside the plausible range.

    Notes
    -----
    Considers the candidates themselves and, where the difference is continuous, the places at
    which it leaves 0 between a candidate and a neighbour that has the present verdict or is a tie.
    Of several equally near, the one with the largest difference.
    """
    region = label(is_candidate, np.ones((3,) * is_candidate.ndim))[0].ravel()
    seen = set()
    for flip in _by_distance(stability, is_candidate):
        if region[flip.cell] not in seen and (flip.is_plausible or not is_plausible_only):
            seen.add(region[flip.cell])
            yield flip
            if len(seen) == region.max():
                return


def find_interval(stability: StabilityMap, i: int, present: Sequence[int]) -> FlipInterval:
    """Find how far the verdict holds along axis i from `present`, the analysed indices."""
    line = stability.difference[
        tuple(slice(None) if j == i else index for j, index in enumerate(present))
    ]
    values, along, start = stability.axes[i].values, winners(line), present[i]
    others = np.flatnonzero(along != stability.verdict)
    before, after = others[others < start], others[others > start]
    first = int(before[-1]) + 1 if len(before) else 0
    last = int(after[0]) - 1 if len(after) else len(values) - 1

    def flip(inside: int, outside: int) -> float:
        difference_inside, difference_outside = line[[inside, outside]]
        if not stability.is_continuous[i] or not difference_inside * difference_outside < 0:
            return float(values[outside])
        return float(_cross(values[inside], values[outside], difference_inside, difference_outside))

    def beyond(outside: int, step: int) -> Winner:
        winner: Winner = along[outside]
        after: Winner = "undefined"
        if 0 <= outside + step < len(values):
            after = along[outside + step]
        is_crossing = winner == "even" and after in ("x", "y") and after != stability.verdict
        # a tie at a single point of a continuous setting is a flip to the winner after it
        return after if stability.is_continuous[i] and is_crossing else winner

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
    """Find where the straight line between the differences at `inside` and `outside` is 0."""
    fraction = difference_inside / (difference_inside - difference_outside)
    return inside + fraction * (outside - inside)


def _by_distance(stability: StabilityMap, is_candidate: np.ndarray) -> Iterator[Flip]:
    """All flips, the nearest first."""
    cell, places, is_between = _places(stability, is_candidate)
    distance_squared = np.zeros(len(cell))
    is_plausible = np.ones(len(cell), dtype=bool)
    for axis, values in zip(stability.axes, places.T, strict=True):
        distance_squared += axis.distance(values) ** 2
        is_plausible &= axis.is_plausible(values)
    distance = np.sqrt(distance_squared)
    difference = np.where(is_between, 0.0, stability.difference.ravel()[cell])
    order = np.lexsort((-np.abs(difference), distance.round(9)))
    for i in order:
        place = tuple(places[i].tolist())
        yield Flip(
            cell=int(cell[i]),
            place=place,
            settings=stability.settings_at(place),
            difference=float(difference[i]),
            winner=stability.winner.ravel()[cell[i]],
            distance=float(distance[i]),
            is_plausible=bool(is_plausible[i]),
        )


def _places(
    stability: StabilityMap, is_candidate: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cell, value on each axis (n, n_axes), and whether the flip is between two points."""
    shape = stability.difference.shape
    values = [axis.values for axis in stability.axes]
    at_cell = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, len(values))
    number = np.arange(stability.difference.size).reshape(shape)
    is_even = (stability.winner == "even").ravel()
    holds, is_target = (
        (stability.winner == stability.verdict).ravel() | is_even,
        is_candidate.ravel() & ~is_even,
    )
    flat = np.where(is_even, 0.0, stability.difference.ravel())
    cells, places = [np.flatnonzero(is_candidate)], [at_cell[is_candidate.ravel()]]
    for i, is_continuous in enumerate(stability.is_continuous):
        if not is_continuous or stability.verdict == "even":
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
