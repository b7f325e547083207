"""Where on a stability map the verdict turns: nearest settings, and how far one can be moved alone.

A turn along one axis is also a candidate for the nearest one, so that no turn that is told along
an axis is nearer than the one told as the nearest.
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
"""Differences up to this are none: two ways to add up the same frames differ by as much."""


@dataclass(frozen=True)
class Turn:
    """A setting at which the present verdict does not hold.

    Attributes
    ----------
    cell
        Flat index into the map; between two points, of the one beyond.
    at
        Its place on each axis.
    settings
        Parameters by name, for ``dataclasses.replace(params, **settings)``.
    difference
        There; positive: X is better; 0 where it passes through 0 between two points.
    winner
        There, or just beyond.
    distance
        From the analysed setting, Euclidean, in plausible ranges of the axes.
    is_plausible
        Whether it lies in the plausible range of every axis.
    """

    cell: int
    at: tuple[float, ...]
    settings: Mapping[str, float | str]
    difference: float
    winner: Winner
    distance: float
    is_plausible: bool


@dataclass(frozen=True)
class Stretch:
    """How far one setting can be moved alone, all else as analysed, before the verdict ends.

    Attributes
    ----------
    axis
        Position in ``StabilityMap.axes``.
    low, high
        First and last value on the axis, around the analysed one, with the present verdict.
    turns_below, turns_above
        Where it ends: for mean similarity over a setting in which it is continuous, between two
        points by linear interpolation (for alpha that is exact); else the first point beyond.
        NaN: not on this axis.
    below, above
        Who is better there; "undefined": not on this axis, or undefined there.
    """

    axis: int
    low: float
    high: float
    turns_below: float
    turns_above: float
    below: Winner
    above: Winner


@dataclass(frozen=True)
class Field:
    """The cells of a map.

    Attributes
    ----------
    axes
        Of the map.
    difference, winner
        Of the map, shape (len(axes[0]), ...).
    is_continuous
        Of each axis: whether the difference makes no steps along it.
    """

    axes: tuple[Axis, ...]
    difference: np.ndarray
    winner: np.ndarray
    is_continuous: tuple[bool, ...]


def winners(difference: np.ndarray) -> np.ndarray:
    """`Winner` of every difference; object, the same shape."""
    code = np.select(
        [difference > ROUNDING, difference < -ROUNDING, np.abs(difference) <= ROUNDING],
        range(3), default=3,
    )  # fmt: skip
    names: np.ndarray = np.array(get_args(Winner), dtype=object)[code]
    return names


def find_turns(field: Field, verdict: Winner, is_candidate: np.ndarray) -> tuple[Turn, ...]:
    """The nearest turn to each connected region of candidates, the nearest first.

    Parameters
    ----------
    is_candidate
        Cells to be reached; bool, the shape of the map.

    Notes
    -----
    Tried are the candidates themselves and, where the difference is continuous, the places at
    which it leaves 0 between a neighbour that has the present verdict, or is a tie, and a
    candidate. Of several equally near, the clearest.
    """
    nearest: dict[int, Turn] = {}
    region = label(is_candidate, np.ones((3,) * is_candidate.ndim))[0].ravel()
    for turn in _by_distance(field, verdict, is_candidate, is_plausible_only=False):
        if (number := int(region[turn.cell])) not in nearest:
            nearest[number] = turn
            if len(nearest) == region.max():
                break
    return tuple(nearest.values())


def find_plausible_turn(field: Field, verdict: Winner, is_candidate: np.ndarray) -> Turn | None:
    """The nearest turn in the plausible range, as by `find_turns`."""
    return next(_by_distance(field, verdict, is_candidate, is_plausible_only=True), None)


def find_stretch(field: Field, verdict: Winner, i: int, at: Sequence[int]) -> Stretch:
    """How far the verdict holds along axis i from the analysed point, given on every axis."""
    line = field.difference[tuple(slice(None) if j == i else place for j, place in enumerate(at))]
    values, along, place = field.axes[i].values, winners(line), at[i]
    others = np.flatnonzero(along != verdict)
    before, after = others[others < place], others[others > place]
    first = int(before[-1]) + 1 if len(before) else 0
    last = int(after[0]) - 1 if len(after) else len(values) - 1

    def turn(inside: int, outside: int) -> float:
        here, there = line[[inside, outside]]
        if not field.is_continuous[i] or not here * there < 0:
            return float(values[outside])
        return float(_cross(values[inside], values[outside], here, there))

    def beyond(outside: int, step: int) -> Winner:
        winner: Winner = along[outside]
        after: Winner = "undefined"
        if 0 <= outside + step < len(values):
            after = along[outside + step]
        is_passed = winner == "even" and after in ("x", "y") and after != verdict
        # a tie at a single point of a continuous setting is a turn to who is better after it
        return after if field.is_continuous[i] and is_passed else winner

    return Stretch(
        axis=i,
        low=float(values[first]),
        high=float(values[last]),
        turns_below=turn(first, first - 1) if len(before) else np.nan,
        turns_above=turn(last, last + 1) if len(after) else np.nan,
        below=beyond(first - 1, -1) if len(before) else "undefined",
        above=beyond(last + 1, 1) if len(after) else "undefined",
    )


def outer(parts: Sequence[np.ndarray], combine: np.ufunc) -> np.ndarray:
    """One number per cell from one number per point of each axis."""
    whole = parts[0]
    for part in parts[1:]:
        whole = combine.outer(whole, part)
    return whole


def _cross(inside: Any, outside: Any, here: Any, there: Any) -> Any:
    """Where a straight line from `here` at `inside` to `there` at `outside` is 0."""
    return inside + here / (here - there) * (outside - inside)


def _by_distance(
    field: Field, verdict: Winner, is_candidate: np.ndarray, *, is_plausible_only: bool
) -> Iterator[Turn]:
    """All turns, the nearest first."""
    cell, at, is_between = _places(field, verdict, is_candidate)
    squared = np.zeros(len(cell))
    is_plausible = np.ones(len(cell), dtype=bool)
    for axis, values in zip(field.axes, at.T, strict=True):
        squared += axis.distance(values) ** 2
        is_plausible &= axis.is_plausible(values)
    distance = np.sqrt(squared)
    difference = np.where(is_between, 0.0, field.difference.ravel()[cell])
    order = np.lexsort((-np.abs(difference), distance.round(9)))
    for one in order[is_plausible[order]] if is_plausible_only else order:
        place = tuple(at[one].tolist())
        yield Turn(
            cell=int(cell[one]),
            at=place,
            settings={
                axis.name: axis.setting_at(value)
                for axis, value in zip(field.axes, place, strict=True)
            },
            difference=float(difference[one]),
            winner=field.winner.ravel()[cell[one]],
            distance=float(distance[one]),
            is_plausible=bool(is_plausible[one]),
        )


def _places(
    field: Field, verdict: Winner, is_candidate: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cell, place on each axis (n, n_axes), and whether it lies between two points."""
    shape = field.difference.shape
    values = [axis.values for axis in field.axes]
    at_cell = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, len(values))
    number = np.arange(field.difference.size).reshape(shape)
    is_even = (field.winner == "even").ravel()
    holds, reached = (field.winner == verdict).ravel() | is_even, is_candidate.ravel() & ~is_even
    flat = np.where(is_even, 0.0, field.difference.ravel())
    cells, at = [np.flatnonzero(is_candidate)], [at_cell[is_candidate.ravel()]]
    for i, is_continuous in enumerate(field.is_continuous):
        if not is_continuous or verdict == "even":
            continue
        lower = number.take(range(shape[i] - 1), axis=i).ravel()
        upper = number.take(range(1, shape[i]), axis=i).ravel()
        for inside, outside in ((lower, upper), (upper, lower)):
            passes = holds[inside] & reached[outside]
            passes &= is_even[inside] | (flat[inside] * flat[outside] < 0)
            a, b = inside[passes], outside[passes]
            place = at_cell[b].copy()
            place[:, i] = _cross(at_cell[a, i], at_cell[b, i], flat[a], flat[b])
            cells.append(b)
            at.append(place)
    cell = np.concatenate(cells)
    return cell, np.concatenate(at), np.arange(len(cell)) >= len(cells[0])
