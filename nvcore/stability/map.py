"""Dependence of the verdict on the analyst: the difference X - Y over settings of the analysis.

>>> with ThreadPoolExecutor() as pool:  # doctest: +SKIP
...     stability = map_stability(result, "alpha-midpoint", "similarity", executor=pool)
>>> stability.share_held, stability.overturn  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Final, get_args

import numpy as np

from nvcore.comparison import Result
from nvcore.errors import ParameterError
from nvcore.measures.entry import HIGHER
from nvcore.measures.table import measure_of
from nvcore.progress import Progress, no_progress, run_steps
from nvcore.stability.axes import Axis, Plane, axes_of
from nvcore.stability.equal_alarms import (
    COLUMNS,
    EqualAlarms,
    alarms_per_frame,
    equal_alarm_thresholds,
)
from nvcore.stability.flips import (
    Flip,
    FlipInterval,
    Winner,
    combine_axes,
    find_flips,
    find_interval,
    winners,
)
from nvcore.stability.scores import (
    LETTERS,
    MEASURE_OF,
    Criterion,
    Key,
    Letter,
    Score,
    enters,
    keys_of,
    match_fully,
    score_setting,
)

N_POINTS: Final = 41
"""Points of an axis, plus one if the analysed setting lies between them."""
MAPS: Final = "stability maps"
"""Description of this work for `Progress`."""
CONTINUOUS: Final = ("alpha", "edge_weight", "midpoint", "midpoint_m")
"""Settings in which mean similarity changes without steps; not so thresholds and IoU."""


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
        return combine_axes([axis.weights for axis in self.axes], np.multiply)

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

    def difference_at(keys: Mapping[Letter, np.ndarray], axes: Sequence[Axis]) -> np.ndarray:
        alpha = result.params.alpha
        x, y = (_score_grid(keys[letter], scores_of, letter, axes, alpha) for letter in LETTERS)
        return _difference(x, y, criterion)

    equal_alarms = None
    if pairs is not None:
        columns: dict[str, Any] = {name: pairs[name].to_numpy() for name in COLUMNS}
        equal_alarms = EqualAlarms(
            **columns,
            difference=difference_at(along, ()),
            present_x=alarms_per_frame(result, result.x),
            present_y=alarms_per_frame(result, result.y),
        )
    shape = tuple(len(axis) for axis in axes)
    difference = np.broadcast_to(difference_at(keys, axes), shape).copy()
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


def _score_grid(
    keys: np.ndarray,
    scores_of: Mapping[Key, Mapping[Letter, Score]],
    letter: Letter,
    axes: Sequence[Axis],
    present_alpha: float,
) -> np.ndarray:
    """Return a system's measure in each cell, float64. It broadcasts to the map's shape."""
    scores = [scores_of[key][letter] for key in keys.ravel()]
    at_0 = np.array([score.at_0 for score in scores]).reshape(keys.shape)
    at_1 = np.array([score.at_1 for score in scores]).reshape(keys.shape)
    alpha: np.ndarray = np.array(present_alpha)
    for place, axis in enumerate(axes):
        if axis.name == "alpha":
            alpha = axis.values.reshape([-1 if i == place else 1 for i in range(len(axes))])
    grid: np.ndarray = at_0 + alpha * (at_1 - at_0)
    return grid
