"""Whether the verdict depends on the analyst: the difference X - Y over settings of the analysis.

>>> with ThreadPoolExecutor() as pool:  # doctest: +SKIP
...     found = map_stability(result, "alpha-midpoint", "similarity", executor=pool)
>>> found.share_held, found.overturn  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Final, Literal, get_args

import numpy as np

from nvcore.analysis import Result
from nvcore.errors import ParameterError
from nvcore.stability_axes import Axis, Plane, axes_of
from nvcore.stability_scores import (
    LETTERS,
    Criterion,
    Key,
    Letter,
    Score,
    enters,
    keys_of,
    match_fully,
    score_setting,
)
from nvcore.stability_steps import Progress, run_steps

Winner = Literal["x", "y", "even", "undefined"]

N_POINTS: Final = 41
"""Points of an axis, and one more where the analysed setting lies between them."""
ROUNDING: Final = 1e-9
"""Differences up to this are none: two ways to add up the same frames differ by as much."""
CONTINUOUS: Final = ("alpha", "edge_weight", "midpoint", "midpoint_m")
"""Settings in which mean similarity makes no steps; in thresholds and IoU it does."""


@dataclass(frozen=True)
class Turn:
    """A setting at which the present verdict does not hold.

    Attributes
    ----------
    cell
        Flat index into the map.
    settings
        Parameters by name, for ``dataclasses.replace(params, **settings)``.
    difference
        There; positive: X is better.
    winner
        There.
    distance
        From the analysed setting, Euclidean, in plausible ranges of the axes.
    is_plausible
        Whether it lies in the plausible range of every axis.
    """

    cell: int
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


@dataclass(frozen=True, eq=False)
class StabilityMap:
    """The difference between X and Y over one or two settings, all others as analysed.

    Attributes
    ----------
    plane, criterion
        What was mapped.
    axes
        One or two.
    difference
        X - Y with the sign turned so that positive always means X is better: mean similarity
        X - Y; encounters that X alone detects less those that Y alone detects; saliency Y - X in
        seconds. float64, shape (len(axes[0]), ...), NaN undefined; read-only.
    winner
        `Winner` of every cell; object, the same shape; read-only.
    present_difference
        At the analysed setting.
    is_moved_by
        Of each axis: whether the criterion depends on it at all.
    """

    plane: Plane
    criterion: Criterion
    axes: tuple[Axis, ...]
    difference: np.ndarray
    winner: np.ndarray
    present_difference: float
    is_moved_by: tuple[bool, ...]

    @property
    def verdict(self) -> Winner:
        """Who is better at the analysed setting."""
        return str(winners(np.array([self.present_difference]))[0])  # type: ignore[return-value]

    @property
    def present_cell(self) -> int | None:
        """Flat index of the analysed setting; None if the recordings' own values differ."""
        at = [axis.present_index for axis in self.axes]
        known = [i for i in at if i is not None]
        if len(known) < len(at):
            return None
        return int(np.ravel_multi_index(known, self.difference.shape))

    def settings(self, cell: int) -> dict[str, float | str]:
        """Parameters of a cell, by flat index, for ``dataclasses.replace(params, **settings)``."""
        at = np.unravel_index(cell, self.difference.shape)
        return {axis.name: axis.setting(int(i)) for axis, i in zip(self.axes, at, strict=True)}

    @cached_property
    def share_held(self) -> float:
        """Share of the plausible range in which the present verdict holds, 0..1; 1 is stable.

        Of what is defined there; NaN if nothing is, or the present verdict is not.
        """
        if self.verdict == "undefined" or not self.share_defined:
            return np.nan
        held = float(self._weights[self.winner == self.verdict].sum())
        return min(1.0, held / self.share_defined)

    @cached_property
    def share_defined(self) -> float:
        """Share of the plausible range in which the criterion is defined, 0..1."""
        return float(self._weights[self.winner != "undefined"].sum())

    @cached_property
    def _weights(self) -> np.ndarray:
        """Share of the plausible range that each cell stands for."""
        return _outer([axis.weights for axis in self.axes], np.multiply)

    @cached_property
    def end(self) -> Turn | None:
        """The nearest setting on the map at which the verdict does not hold: a tie is enough."""
        return self._nearest((self.winner != self.verdict) & (self.winner != "undefined"))

    @cached_property
    def overturn(self) -> Turn | None:
        """The nearest setting on the map at which the other system is better; None: nowhere.

        With a tie at present: at which one of them is better.
        """
        if self.verdict == "even":
            return self.end
        return self._nearest(self.winner == ("y" if self.verdict == "x" else "x"))

    def _nearest(self, is_candidate: np.ndarray) -> Turn | None:
        """The nearest candidate; of several equally near, the clearest."""
        if self.verdict == "undefined" or not is_candidate.any():
            return None
        squared = _outer([axis.distances**2 for axis in self.axes], np.add)
        cells = np.flatnonzero(is_candidate)
        distance = np.sqrt(squared.ravel()[cells])
        clarity = np.abs(self.difference.ravel()[cells])
        best = int(np.lexsort((-clarity, distance.round(9)))[0])
        cell = int(cells[best])
        winner: Winner = self.winner.ravel()[cell]
        at = np.unravel_index(cell, self.difference.shape)
        plausible = [axis.is_plausible(int(i)) for axis, i in zip(self.axes, at, strict=True)]
        return Turn(
            cell, self.settings(cell), float(self.difference.ravel()[cell]), winner,
            float(distance[best]), all(plausible),
        )  # fmt: skip

    @cached_property
    def stretches(self) -> tuple[Stretch, ...]:
        """For each numeric axis that matters, how far the verdict holds along it alone.

        Empty where the verdict is undefined or the analysed setting is no one point of the map.
        """
        at = [axis.present_index for axis in self.axes]
        if self.verdict == "undefined" or self.present_cell is None:
            return ()
        found = []
        for i, axis in enumerate(self.axes):
            if axis.labels or not self.is_moved_by[i]:
                continue
            line = tuple(slice(None) if j == i else at[j] for j in range(len(at)))
            place = axis.present_index
            assert place is not None
            found.append(self._stretch(i, self.difference[line], place))
        return tuple(found)

    def _stretch(self, i: int, line: np.ndarray, place: int) -> Stretch:
        values = self.axes[i].values
        along = winners(line)
        others = np.flatnonzero(along != self.verdict)
        before, after = others[others < place], others[others > place]
        first = int(before[-1]) + 1 if len(before) else 0
        last = int(after[0]) - 1 if len(after) else len(values) - 1
        return Stretch(
            axis=i,
            low=float(values[first]),
            high=float(values[last]),
            turns_below=self._turn(i, line, first, first - 1) if len(before) else np.nan,
            turns_above=self._turn(i, line, last, last + 1) if len(after) else np.nan,
            below=along[first - 1] if len(before) else "undefined",
            above=along[last + 1] if len(after) else "undefined",
        )

    def _turn(self, i: int, line: np.ndarray, inside: int, outside: int) -> float:
        """Where the difference is 0 between two points, if it moves continuously; else outside."""
        values = self.axes[i].values
        here, there = float(line[inside]), float(line[outside])
        is_continuous = self.criterion == "similarity" and self.axes[i].name in CONTINUOUS
        if not is_continuous or not here * there < 0:
            return float(values[outside])
        share = here / (here - there)
        return float(values[inside] + share * (values[outside] - values[inside]))


def winners(difference: np.ndarray) -> np.ndarray:
    """`Winner` of every difference; object, the same shape."""
    code = np.select(
        [difference > ROUNDING, difference < -ROUNDING, np.abs(difference) <= ROUNDING],
        range(3), default=3,
    )  # fmt: skip
    names: np.ndarray = np.array(get_args(Winner), dtype=object)[code]
    return names


def map_stability(
    result: Result,
    plane: Plane,
    criterion: Criterion = "similarity",
    *,
    n_points: int = N_POINTS,
    executor: Executor | None = None,
    progress: Progress | None = None,
    is_cancelled: Callable[[], bool] | None = None,
) -> StabilityMap:
    """Who is better at other settings: every cell is what `analyse` would give there.

    Parameters
    ----------
    result
        The comparison at the present setting; what a setting leaves alone is taken from it.
    plane
        Which settings move: ``"alpha-midpoint"``, ``"thresholds"`` (of X, of Y), ``"matching"``
        (IoU, mode), ``"edge-weight"``, ``"edge-weight-alpha"``. An axis that these data cannot
        show is left out: the midpoint without proximity, a threshold without scores.
    criterion
        ``"similarity"`` (mean), ``"encounters"`` (detected by X alone less by Y alone),
        ``"saliency"``.
    n_points
        Points of each numeric axis.
    executor
        Runs the settings side by side; threads do, for the kernels release the lock. None: one
        after the other in this thread.
    progress
        Called from this thread after each step.
    is_cancelled
        Asked before and between steps, such as ``threading.Event().is_set``.

    Raises
    ------
    ParameterError
        If there is no such plane or criterion, or there are fewer than 3 points.
    InputError
        If no axis is left.
    concurrent.futures.CancelledError
        If `is_cancelled` said so.

    Notes
    -----
    Undefined cells: no frames; for encounters, none near enough to count at that setting.
    """
    if criterion not in get_args(Criterion):
        raise ParameterError(
            f"criterion: expected one of {', '.join(get_args(Criterion))}, got {criterion!r}"
        )
    axes = axes_of(result, plane, n_points=n_points)
    if is_cancelled is not None and is_cancelled():
        raise CancelledError
    keys = {letter: keys_of(result, criterion, letter, axes) for letter in LETTERS}
    wanted: dict[Key, list[Letter]] = {}
    for letter in LETTERS:
        for key in dict.fromkeys(keys[letter].ravel()):
            wanted.setdefault(key, []).append(letter)
    full = match_fully(result, [axis.name for axis in axes])
    jobs = [
        partial(score_setting, result, criterion, key, letters, full)
        for key, letters in wanted.items()
    ]
    found = dict(zip(wanted, run_steps(jobs, executor, progress, is_cancelled), strict=True))
    alpha = result.params.alpha
    scores = {letter: _score_grid(keys[letter], found, letter, axes, alpha) for letter in LETTERS}
    difference = scores["x"] - scores["y"]
    if criterion == "saliency":
        difference = 0.0 - difference  # less is better; no negative zeros
    shape = tuple(len(axis) for axis in axes)
    difference = np.broadcast_to(difference, shape).copy()
    winner = winners(difference)
    difference.flags.writeable = winner.flags.writeable = False
    moved = tuple(
        any(enters(axis.name, criterion, letter, result) for letter in LETTERS) for axis in axes
    )
    return StabilityMap(
        plane, criterion, axes, difference, winner, present_difference(result, criterion), moved
    )


def present_difference(result: Result, criterion: Criterion) -> float:
    """Difference of the criterion as analysed; positive: X is better; NaN undefined."""
    if result.dataset.frames.empty:
        return np.nan
    if criterion == "similarity":
        return result.x.summary.mean - result.y.summary.mean
    if criterion == "saliency":
        return result.y.saliency_s - result.x.saliency_s
    return float(result.venn.x_only - result.venn.y_only) if result.venn.n_near else np.nan


def _score_grid(
    keys: np.ndarray,
    found: Mapping[Key, Mapping[Letter, Score]],
    letter: Letter,
    axes: Sequence[Axis],
    present_alpha: float,
) -> np.ndarray:
    """A system's figure in each cell; float64, broadcasts to the map's shape."""
    scores = [found[key][letter] for key in keys.ravel()]
    at_0 = np.array([score.at_0 for score in scores]).reshape(keys.shape)
    at_1 = np.array([score.at_1 for score in scores]).reshape(keys.shape)
    alpha: np.ndarray = np.array(present_alpha)
    for place, axis in enumerate(axes):
        if axis.name == "alpha":
            alpha = axis.values.reshape([-1 if i == place else 1 for i in range(len(axes))])
    grid: np.ndarray = at_0 + alpha * (at_1 - at_0)
    return grid


def _outer(parts: Sequence[np.ndarray], combine: np.ufunc) -> np.ndarray:
    """One number per cell from one number per point of each axis."""
    whole = parts[0]
    for part in parts[1:]:
        whole = combine.outer(whole, part)
    return whole
