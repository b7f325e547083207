"""Dependence of the verdict on the analyst: the difference X - Y over settings of the analysis.

>>> with ThreadPoolExecutor() as pool:  # doctest: +SKIP
...     stability = map_stability(result, "alpha-midpoint", "similarity", executor=pool)
>>> stability.share_held, stability.overturn  # doctest: +SKIP

A flip along one axis is also a candidate for the nearest flip, so that none reported along an axis
is nearer than the one reported as the nearest.
"""

# ruff: noqa: PD011  (the values of a setting's axis are an array)

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial, reduce
from typing import Any, Final, Literal, get_args

import numpy as np
import pandas as pd
from scipy.ndimage import label

from nvcore.common.errors import ParameterError
from nvcore.common.progress import Progress, no_progress, run_steps
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.entry import HIGHER
from nvcore.comparison.measures.table import measure_of
from nvcore.evidence.stability.axes import ALARMS_PLAUSIBLE, Axis, Plane, axes_of
from nvcore.evidence.stability.scores import (
    LETTERS,
    MEASURE_OF,
    Criterion,
    Key,
    Letter,
    enters,
    keys_of,
    match_fully,
    score_setting,
)
from nvcore.metrics.detection.operating_point import false_alarm_curve

Winner = Literal["x", "y", "even", "undefined"]

N_POINTS: Final = 41
"""Points of an axis, plus one if the analysed setting lies between them."""
MAPS: Final = "stability maps"
"""Description of this work for `Progress`."""
CONTINUOUS: Final = ("alpha", "edge_weight", "midpoint", "midpoint_m")
"""Settings in which mean similarity changes without steps; not so thresholds and IoU."""
ROUNDING: Final = 1e-9
"""Differences up to this count as 0: two ways to add up the same frames differ by as much."""
N_RATES: Final = 41
"""Number of false-alarm rates, in equal ratios like those over which the miss rate is averaged."""
CURVE_POINTS: Final = 100_000
"""Most thresholds of a system that are tried."""
ALIKE: Final = 0.1
"""Numbers of false alarms count as equal if they differ by at most this share of the larger."""


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


@dataclass(frozen=True, eq=False)
class EqualAlarms:
    """The difference between X and Y where both have equally many false alarms per frame.

    Attributes
    ----------
    alarms_per_frame
        Increasing in equal ratios, float64, shape (n,); n is 0 if no thresholds are equal in this.
    threshold_x, threshold_y
        Thresholds that give these rates, float64, shape (n,).
    difference
        Difference at these thresholds; positive: X is better; float64, shape (n,).
    present_x, present_y
        False alarms per frame as analysed.
    """

    alarms_per_frame: np.ndarray
    threshold_x: np.ndarray
    threshold_y: np.ndarray
    difference: np.ndarray
    present_x: float
    present_y: float

    def share(self, winner: Winner) -> float:
        """Return the share of these pairs with this winner, 0..1, or NaN without pairs."""
        if not len(self.difference):
            return np.nan
        return float(np.mean(winners(self.difference) == winner))


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
        Positive means that X is better: mean similarity X - Y; encounters that only X detects
        minus those that only Y detects; saliency Y - X in seconds. float64, shape
        (len(axes[0]), ...), NaN undefined; read-only.
    winner
        `Winner` of every cell; object, the same shape; read-only.
    present_difference
        Difference at the analysed setting.
    is_moved_by
        For each axis, whether the criterion depends on it at all.
    equal_alarms
        In the plane of both thresholds: where X and Y have equally many false alarms; else None.
    """

    plane: Plane
    criterion: Criterion
    axes: tuple[Axis, ...]
    difference: np.ndarray
    winner: np.ndarray
    present_difference: float
    is_moved_by: tuple[bool, ...]
    equal_alarms: EqualAlarms | None = None

    @property
    def verdict(self) -> Winner:
        """Winner at the analysed setting."""
        return str(winners(np.array([self.present_difference]))[0])  # type: ignore[return-value]

    @property
    def present_indices(self) -> list[int] | None:
        """Analysed setting's index on each axis, or None if the recordings' own values differ."""
        indices = [i for axis in self.axes if (i := axis.present_index) is not None]
        return indices if len(indices) == len(self.axes) else None

    def settings(self, cell: int) -> dict[str, float | str]:
        """Parameters of a cell, by flat index, for ``dataclasses.replace(params, **settings)``."""
        indices = np.unravel_index(cell, self.difference.shape)
        places = [axis.values[i] for axis, i in zip(self.axes, indices, strict=True)]
        return self.settings_at(places)

    def settings_at(self, place: Sequence[float]) -> dict[str, float | str]:
        """Parameters at a value on each axis."""
        axes = zip(self.axes, place, strict=True)
        return {axis.name: axis.setting_at(value) for axis, value in axes}

    @cached_property
    def share_held(self) -> float:
        """Share of the plausible range in which the present verdict holds, 0..1, where 1 is stable.

        Undefined cells do not count; NaN if all are undefined, or the present verdict is.
        """
        if self.verdict == "undefined" or not self.share_defined:
            return np.nan
        share = float(self._weights[self.winner == self.verdict].sum())
        return min(1.0, share / self.share_defined)

    @cached_property
    def share_defined(self) -> float:
        """Share of the plausible range in which the criterion is defined, 0..1."""
        return float(self._weights[self.winner != "undefined"].sum())

    @cached_property
    def _weights(self) -> np.ndarray:
        """Share of the plausible range that each cell represents."""
        return reduce(np.multiply.outer, [axis.weights for axis in self.axes])

    @cached_property
    def end(self) -> Flip | None:
        """The nearest setting on the map at which the verdict no longer holds (a tie ends it)."""
        is_other = (self.winner != self.verdict) & (self.winner != "undefined")
        return next(find_flips(self, is_other & (self.verdict != "undefined")), None)

    @cached_property
    def overturns(self) -> tuple[Flip, ...]:
        """The nearest setting in each separate part of the map in which the other system is better.

        The nearest part first. If it is a tie at present: in which either system is better.
        """
        return tuple(find_flips(self, self._is_overturned))

    @property
    def overturn(self) -> Flip | None:
        """Nearest setting on the map that overturns the verdict, or None if there is none."""
        return self.overturns[0] if self.overturns else None

    @cached_property
    def plausible_overturn(self) -> Flip | None:
        """Nearest plausible setting that overturns the verdict, or None if there is none."""
        return next(find_flips(self, self._is_overturned, is_plausible_only=True), None)

    @property
    def _is_overturned(self) -> np.ndarray:
        others = {"x": ["y"], "y": ["x"], "even": ["x", "y"], "undefined": []}
        return np.isin(self.winner, others[self.verdict])

    @property
    def is_continuous(self) -> tuple[bool, ...]:
        """For each axis, whether the difference changes along it without steps."""
        is_by_similarity = self.criterion == "similarity"
        return tuple(is_by_similarity and axis.name in CONTINUOUS for axis in self.axes)

    @cached_property
    def intervals(self) -> tuple[FlipInterval, ...]:
        """For each numeric axis that matters, how far the verdict holds along it alone.

        Empty if the verdict is undefined or the analysed setting is not a single point of the map.
        """
        present = self.present_indices
        if self.verdict == "undefined" or present is None:
            return ()
        return tuple(
            find_interval(self, i, present)
            for i, axis in enumerate(self.axes)
            if not axis.labels and self.is_moved_by[i]
        )


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
    place = tuple(slice(None) if j == i else index for j, index in enumerate(present))
    line, along = stability.difference[place], stability.winner[place]
    values, n = stability.axes[i].values, len(line)

    def end(step: int) -> tuple[float, float, Winner]:
        """Return the last value with the verdict, where it flips beyond it, and to whom."""
        inside = present[i]
        while 0 <= inside + step < n and along[inside + step] == stability.verdict:
            inside += step
        outside = inside + step
        if not 0 <= outside < n:
            return float(values[inside]), np.nan, "undefined"
        flip, winner = values[outside], along[outside]
        if stability.is_continuous[i]:
            if line[inside] * line[outside] < 0:
                flip = _cross(values[inside], values[outside], line[inside], line[outside])
            # a tie at a single point is a flip to the winner after it
            after = along[outside + step] if 0 <= outside + step < n else "undefined"
            if winner == "even" and after in {"x", "y"} - {stability.verdict}:
                winner = after
        return float(values[inside]), float(flip), winner

    low, flips_below, below = end(-1)
    high, flips_above, above = end(1)
    return FlipInterval(i, low, high, flips_below, flips_above, below, above)


def _cross(inside: Any, outside: Any, difference_inside: Any, difference_outside: Any) -> Any:
    """Find where the straight line between the differences at `inside` and `outside` is 0."""
    fraction = difference_inside / (difference_inside - difference_outside)
    return inside + fraction * (outside - inside)


def _by_distance(stability: StabilityMap, is_candidate: np.ndarray) -> Iterator[Flip]:
    """All flips, the nearest first: cells, and places between two cells."""
    shape, winner = stability.difference.shape, stability.winner.ravel()
    values = [axis.values for axis in stability.axes]
    at_cell = np.stack(np.meshgrid(*values, indexing="ij"), axis=-1).reshape(-1, len(values))
    number = np.arange(len(winner)).reshape(shape)
    is_even = winner == "even"
    holds, is_target = (winner == stability.verdict) | is_even, is_candidate.ravel() & ~is_even
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
            between = at_cell[b].copy()
            between[:, i] = _cross(at_cell[a, i], at_cell[b, i], flat[a], flat[b])
            cells.append(b)
            places.append(between)
    cell, place = np.concatenate(cells), np.concatenate(places)
    difference = stability.difference.ravel()[cell]
    difference[len(cells[0]) :] = 0.0
    along = [*zip(stability.axes, place.T, strict=True)]
    distance = np.sqrt(np.sum([axis.distance(values) ** 2 for axis, values in along], axis=0))
    is_plausible = np.all([axis.is_plausible(values) for axis, values in along], axis=0)
    for i in np.lexsort((-np.abs(difference), distance.round(9))):
        at = tuple(place[i].tolist())
        yield Flip(
            cell=int(cell[i]),
            place=at,
            settings=stability.settings_at(at),
            difference=float(difference[i]),
            winner=winner[cell[i]],
            distance=float(distance[i]),
            is_plausible=bool(is_plausible[i]),
        )


def map_stability(
    result: Result,
    plane: Plane,
    criterion: Criterion = "similarity",
    *,
    n_points: int = N_POINTS,
    executor: Executor | None = None,
    progress: Progress = no_progress,
) -> StabilityMap:
    """Map who is better at other settings. Every cell is what `compare` would give there.

    Parameters
    ----------
    result
        The comparison at the present setting; whatever a setting does not change comes from it.
    plane
        Which settings change: ``"alpha-midpoint"``, ``"thresholds"`` (of X, of Y), ``"matching"``
        (IoU, mode), ``"edge-weight"``, ``"edge-weight-alpha"``, ``"pairing-alpha"``,
        ``"saliency-rule"`` (weight, whose events). An axis that these data do not have is left
        out: the midpoint without proximity, a threshold without scores.
    criterion
        ``"similarity"`` (mean), ``"encounters"`` (detected by only X minus by only Y),
        ``"saliency"``.
    n_points
        Points of each numeric axis.
    executor
        Runs the settings side by side; threads suffice, as the kernels release the lock. None: one
        after another in this thread.
    progress
        Called from this thread before and between steps.

    Raises
    ------
    ParameterError
        If there is no such plane or criterion, or there are fewer than 3 points.
    InputError
        If no axis is left.

    Notes
    -----
    Undefined cells: no frames; for encounters, none near enough to count there.
    """
    if criterion not in get_args(Criterion):
        raise ParameterError(
            f"criterion: expected one of {', '.join(get_args(Criterion))}, got {criterion!r}"
        )
    axes = axes_of(result, plane, n_points=n_points)
    progress(0.0, MAPS)
    pairs = None
    keys = {letter: keys_of(result, criterion, letter, axes) for letter in LETTERS}
    along: dict[Letter, np.ndarray] = {}
    if plane == "thresholds" and len(axes) == len(LETTERS):
        pairs = equal_alarm_thresholds(result)
        for letter in LETTERS:
            name = f"threshold_{letter}"
            along[letter] = np.fromiter(
                (((name, value),) for value in pairs[name].tolist()), object
            )
    letters_of: dict[Key, list[Letter]] = {}
    for letter in LETTERS:
        for key in dict.fromkeys([*keys[letter].ravel(), *along.get(letter, ())]):
            letters_of.setdefault(key, []).append(letter)
    full = match_fully(result, [axis.name for axis in axes])
    jobs = [
        partial(score_setting, result, criterion, key, letters, full)
        for key, letters in letters_of.items()
    ]
    scores_of = dict(zip(letters_of, run_steps(jobs, executor, progress, MAPS), strict=True))
    alpha: Any = result.params.alpha
    for axis, values in zip(axes, np.ix_(*(axis.values for axis in axes)), strict=True):
        alpha = values if axis.name == "alpha" else alpha

    def difference_at(keys: Mapping[Letter, np.ndarray]) -> np.ndarray:
        """Return the difference in each cell. It broadcasts to the map's shape."""
        measures: list[np.ndarray] = []
        for letter in LETTERS:
            ends = np.array([scores_of[key][letter] for key in keys[letter].ravel()])
            at_0, at_1 = (of.reshape(keys[letter].shape) for of in ends.reshape(-1, 2).T)
            measures.append(at_0 + alpha * (at_1 - at_0))
        return _difference(measures[0], measures[1], criterion)

    equal_alarms = None
    if pairs is not None:
        present_x, present_y = (
            np.count_nonzero(of.matches.is_false_alarm) / len(result.dataset.frames)
            for _, of in result.sides
        )
        columns: dict[str, Any] = {str(name): of.to_numpy() for name, of in pairs.items()}
        equal_alarms = EqualAlarms(
            **columns, difference=difference_at(along), present_x=present_x, present_y=present_y
        )
    shape = tuple(len(axis) for axis in axes)
    difference = np.broadcast_to(difference_at(keys), shape).copy()
    winner = winners(difference)
    difference.flags.writeable = winner.flags.writeable = False
    return StabilityMap(
        *(plane, criterion, axes, difference, winner),
        present_difference=present_difference(result, criterion),
        is_moved_by=tuple(
            any(enters(axis.name, criterion, letter, result) for letter in LETTERS) for axis in axes
        ),
        equal_alarms=equal_alarms,
    )


def present_difference(result: Result, criterion: Criterion) -> float:
    """Return the criterion's difference as analysed. Positive: X is better, NaN: undefined."""
    measure = measure_of(MEASURE_OF[criterion])
    is_undefined = result.dataset.frames.empty or (
        criterion == "encounters" and not result.venn.n_near
    )
    if is_undefined or measure.of is None:
        return np.nan
    x, y = (np.array(measure.of(result, system)) for system in (result.x, result.y))
    return float(_difference(x, y, criterion))


def _difference(x: np.ndarray, y: np.ndarray, criterion: Criterion) -> np.ndarray:
    """Return the difference of the scores. Positive: X is better."""
    is_higher_better = measure_of(MEASURE_OF[criterion]).better == HIGHER
    difference: np.ndarray = x - y if is_higher_better else y - x
    return difference


def equal_alarm_thresholds(result: Result) -> pd.DataFrame:
    """Thresholds of X and Y with equally many false alarms per frame.

    Returns
    -------
    Columns ``alarms_per_frame``, ``threshold_x`` and ``threshold_y``, at most `N_RATES` rows. Rates
    increase from the least to the greatest of `nvcore.evidence.stability.axes.ALARMS_PLAUSIBLE`.
    Thresholds are the lowest that give at most the rate. Left out are rates that a system does not
    reach, and those at which the numbers differ, as when many detections have the same score. No
    rows without scores.
    """
    rates = np.geomspace(*ALARMS_PLAUSIBLE, N_RATES)
    columns: dict[str, np.ndarray] = {"alarms_per_frame": rates}
    n_alarms, is_known = [], np.ones(N_RATES, dtype=bool)
    for letter, system in (("x", result.x), ("y", result.y)):
        curve = false_alarm_curve(
            result.dataset, system.name, result.params, n_points=CURVE_POINTS
        ).sort_values("threshold")
        if curve.empty:
            return pd.DataFrame(
                columns=["alarms_per_frame", "threshold_x", "threshold_y"], dtype=float
            )
        per_frame = curve["false_alarms_per_frame"].to_numpy()
        is_within = per_frame[:, None] <= rates * (1 + 1e-9)
        first = is_within.argmax(axis=0)
        is_known &= is_within.any(axis=0) & (per_frame.max() >= rates * (1 - 1e-9))
        columns[f"threshold_{letter}"] = curve["threshold"].to_numpy()[first]
        n_alarms.append(curve["n_false_alarms"].to_numpy()[first])
    fewer, more = np.minimum(*n_alarms), np.maximum(*n_alarms)
    is_known &= (more > 0) & (more - fewer <= ALIKE * more)
    return pd.DataFrame(columns)[is_known].reset_index(drop=True)
