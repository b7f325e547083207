"""Whether the verdict depends on the analyst: the difference X - Y over settings of the analysis.

>>> with ThreadPoolExecutor() as pool:  # doctest: +SKIP
...     found = map_stability(result, "alpha-midpoint", "similarity", executor=pool)
>>> found.share_held, found.overturn  # doctest: +SKIP
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Final, get_args

import numpy as np

from nvcore.comparison import Result
from nvcore.errors import ParameterError
from nvcore.progress import Progress, no_progress, run_steps
from nvcore.stability.axes import Axis, Plane, axes_of
from nvcore.stability.equal_alarms import (
    EqualAlarms,
    alarms_per_frame,
    equal_alarm_thresholds,
    keys_along,
)
from nvcore.stability.scores import (
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
from nvcore.stability.turns import (
    Field,
    Stretch,
    Turn,
    Winner,
    find_plausible_turn,
    find_stretch,
    find_turns,
    outer,
    winners,
)

N_POINTS: Final = 41
"""Points of an axis, and one more where the analysed setting lies between them."""
MAPS: Final = "stability maps"
"""What `Progress` is told."""
CONTINUOUS: Final = ("alpha", "edge_weight", "midpoint", "midpoint_m")
"""Settings in which mean similarity makes no steps; in thresholds and IoU it does."""


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
    equal_alarms
        Over both thresholds: where X and Y have equally many false alarms; else None.
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
        return outer([axis.weights for axis in self.axes], np.multiply)

    @cached_property
    def end(self) -> Turn | None:
        """The nearest setting on the map at which the verdict does not hold: a tie is enough."""
        is_other = (self.winner != self.verdict) & (self.winner != "undefined")
        found = (
            () if self.verdict == "undefined" else find_turns(self.field, self.verdict, is_other)
        )
        return found[0] if found else None

    @cached_property
    def overturns(self) -> tuple[Turn, ...]:
        """The nearest setting in each separate part of the map in which the other system is better.

        The nearest part first. With a tie at present: in which one of them is better.
        """
        if self.verdict == "undefined":
            return ()
        return find_turns(self.field, self.verdict, self._is_overturned)

    @property
    def overturn(self) -> Turn | None:
        """The nearest setting on the map that overturns the verdict; None: nowhere."""
        return self.overturns[0] if self.overturns else None

    @cached_property
    def plausible_overturn(self) -> Turn | None:
        """The nearest setting that overturns the verdict and is plausible; None: nowhere."""
        if self.verdict == "undefined":
            return None
        return find_plausible_turn(self.field, self.verdict, self._is_overturned)

    @property
    def _is_overturned(self) -> np.ndarray:
        if self.verdict == "even":
            is_better: np.ndarray = (self.winner == "x") | (self.winner == "y")
        else:
            is_better = self.winner == ("y" if self.verdict == "x" else "x")
        return is_better

    @cached_property
    def field(self) -> Field:
        """The cells, for the search of turns."""
        is_continuous = tuple(
            self.criterion == "similarity" and axis.name in CONTINUOUS for axis in self.axes
        )
        return Field(self.axes, self.difference, self.winner, is_continuous)

    @cached_property
    def stretches(self) -> tuple[Stretch, ...]:
        """For each numeric axis that matters, how far the verdict holds along it alone.

        Empty where the verdict is undefined or the analysed setting is no one point of the map.
        """
        at = [axis.present_index for axis in self.axes]
        known = [i for i in at if i is not None]
        if self.verdict == "undefined" or len(known) < len(at):
            return ()
        return tuple(
            find_stretch(self.field, self.verdict, i, known)
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
    """Who is better at other settings: every cell is what `compare` would give there.

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
        Called from this thread before and between steps.

    Raises
    ------
    ParameterError
        If there is no such plane or criterion, or there are fewer than 3 points.
    InputError
        If no axis is left.

    Notes
    -----
    Undefined cells: no frames; for encounters, none near enough to count at that setting.
    """
    if criterion not in get_args(Criterion):
        raise ParameterError(
            f"criterion: expected one of {', '.join(get_args(Criterion))}, got {criterion!r}"
        )
    axes = axes_of(result, plane, n_points=n_points)
    progress(0.0, MAPS)
    keys = {letter: keys_of(result, criterion, letter, axes) for letter in LETTERS}
    wanted: dict[Key, list[Letter]] = {}
    for letter in LETTERS:
        for key in dict.fromkeys(keys[letter].ravel()):
            wanted.setdefault(key, []).append(letter)
    is_by_alarms = plane == "thresholds" and len(axes) == len(LETTERS)
    pairs = equal_alarm_thresholds(result) if is_by_alarms else None
    along = {} if pairs is None else keys_along(pairs)
    for letter, keys_there in along.items():
        for key in keys_there:
            if letter not in wanted.setdefault(key, []):
                wanted[key].append(letter)
    full = match_fully(result, [axis.name for axis in axes])
    jobs = [
        partial(score_setting, result, criterion, key, letters, full)
        for key, letters in wanted.items()
    ]
    found = dict(zip(wanted, run_steps(jobs, executor, progress, MAPS), strict=True))
    alpha = result.params.alpha
    scores = {letter: _score_grid(keys[letter], found, letter, axes, alpha) for letter in LETTERS}
    difference = _difference(scores, criterion)
    equal_alarms = None
    if pairs is not None:
        there = {letter: _score_grid(of, found, letter, (), alpha) for letter, of in along.items()}
        equal_alarms = EqualAlarms(
            alarms_per_frame=pairs["alarms_per_frame"].to_numpy(),
            threshold_x=pairs["threshold_x"].to_numpy(),
            threshold_y=pairs["threshold_y"].to_numpy(),
            difference=_difference(there, criterion),
            present_x=alarms_per_frame(result, result.x),
            present_y=alarms_per_frame(result, result.y),
        )
    shape = tuple(len(axis) for axis in axes)
    difference = np.broadcast_to(difference, shape).copy()
    winner = winners(difference)
    difference.flags.writeable = winner.flags.writeable = False
    moved = tuple(
        any(enters(axis.name, criterion, letter, result) for letter in LETTERS) for axis in axes
    )
    return StabilityMap(
        plane, criterion, axes, difference, winner, present_difference(result, criterion), moved,
        equal_alarms,
    )  # fmt: skip


def present_difference(result: Result, criterion: Criterion) -> float:
    """Difference of the criterion as analysed; positive: X is better; NaN undefined."""
    if result.dataset.frames.empty:
        return np.nan
    if criterion == "similarity":
        return result.x.summary.mean - result.y.summary.mean
    if criterion == "saliency":
        return result.y.saliency_s - result.x.saliency_s
    return float(result.venn.x_only - result.venn.y_only) if result.venn.n_near else np.nan


def _difference(scores: Mapping[Letter, np.ndarray], criterion: Criterion) -> np.ndarray:
    """Positive: X is better."""
    difference: np.ndarray = scores["x"] - scores["y"]
    return 0.0 - difference if criterion == "saliency" else difference  # no negative zeros


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
