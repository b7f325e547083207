"""Results of simulated studies at equal false alarms, with thresholds chosen per study."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.evidence.companions import MOST_ERROR
from nvcore.evidence.measures import unit_measures
from nvcore.evidence.operating_points import (
    count_alarms,
    has_scores,
    threshold_for,
    with_thresholds,
)
from nvcore.evidence.units import Units
from nvcore.metrics.detection.operating_point import are_unequal_alarms

N_THRESHOLDS: Final = 24
REACH: Final = 8.0
"""Factor by which the tried thresholds reduce or increase the false alarms of X and Y at most."""

LARGEST_ERROR: Final = 100.0
"""Limit of the standard error of a logarithm, beyond any ratio of false alarms."""

ALARMS: Final = "false alarms"
Sums = Mapping[str, np.ndarray]
"""Sums of `ALARMS` and of each measure in every unit, by key; shape (n_units,)."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Results of one system in every recording at several thresholds, from strict to lax.

    Attributes
    ----------
    alarms, parts
        False alarms, and sums of the measure; float64, shape (n_thresholds, n_recordings).
    """

    alarms: np.ndarray
    parts: np.ndarray

    def at(self, drawn: np.ndarray, n_alarms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return alarms and parts of each study at the threshold that gives `n_alarms` in it.

        Between two thresholds they are interpolated linearly. Beyond the last threshold they are
        constant.

        Parameters
        ----------
        drawn
            How often each study has drawn each recording; shape (n_studies, n_recordings).
        n_alarms
            Shape (n_studies,).
        """
        totals = np.maximum.accumulate(drawn @ self.alarms.T, axis=1)
        after = np.count_nonzero(totals < n_alarms[:, np.newaxis], axis=1)
        after = np.clip(after, 1, len(self.alarms) - 1)
        study = np.arange(len(drawn))
        low, high = totals[study, after - 1], totals[study, after]
        share = np.clip((n_alarms - low) / np.maximum(high - low, 1e-9), 0, 1)[:, np.newaxis]
        alarms, parts = (
            (1 - share) * of[after - 1] + share * of[after] for of in (self.alarms, self.parts)
        )
        return alarms, parts

    def widened(self, factor: float) -> Curve:
        """Return a curve whose recordings vary more around their mean."""
        both = np.array([self.alarms, self.parts])
        mean = both.mean(axis=2, keepdims=True)
        return Curve(*(mean + factor * (both - mean)))

    def of_recordings(self, rows: np.ndarray) -> Curve:
        """Return the curve of these recordings (rows, with repetition)."""
        return Curve(self.alarms[:, rows], self.parts[:, rows])


@dataclass(frozen=True, eq=False)
class Thresholds:
    """X and Y of a pilot as set, and their results at other thresholds.

    Attributes
    ----------
    as_set
        Curves of X and Y with a single threshold, the one as set.
    curves
        Curves of X and Y; None for a system without scores.
    is_equalized
        Whether the pilot's difference is the one at equal false alarms.
    """

    as_set: tuple[Curve, Curve]
    curves: tuple[Curve | None, Curve | None]
    is_equalized: bool = False

    def change(self, of: Callable[[Curve], Curve]) -> Thresholds:
        """Change all curves."""
        x, y = self.as_set
        curve_x, curve_y = self.curves
        changed = (of(x), of(y)), (curve_x and of(curve_x), curve_y and of(curve_y))
        return Thresholds(*changed, self.is_equalized)


def vary_thresholds(result: Result, units: Units) -> dict[str, Thresholds]:
    """Compute the results of other thresholds in every unit, for each measure judged by units.

    Parameters
    ----------
    result
        The comparison as set, or at equal false alarms.
    """
    as_set = result.as_set or result
    n_of = {letter: count_alarms(system) for letter, system in as_set.sides}
    thresholds: dict[str, list[float | None]] = {}
    for letter in "xy":
        if has_scores(as_set, letter):
            ends = max(min(n_of.values()) / REACH, 1.0), max(REACH * max(n_of.values()), 2.0)
            numbers = np.unique(np.geomspace(*ends, N_THRESHOLDS).round().astype(int)).tolist()
            candidates = [threshold_for(as_set, letter, n, "round") for n in numbers]
            thresholds[letter] = [*dict.fromkeys(candidates)]  # from few alarms to many
    first, others = _sums_of(as_set, units), []
    for step in range(max(map(len, thresholds.values()), default=0)):
        changed = {
            f"threshold_{letter}": of[min(step, len(of) - 1)] for letter, of in thresholds.items()
        }
        others.append(_sums_of(with_thresholds(as_set, changed), units))

    def curve(key: str, letter: str, measured: Sequence[Mapping[str, Sums]]) -> Curve:
        alarms, parts = ([of[letter][name] for of in measured] for name in (ALARMS, key))
        return Curve(np.array(alarms), np.array(parts))

    def curves(key: str, letter: str) -> Curve | None:
        n = len(thresholds.get(letter, ()))
        return curve(key, letter, others[:n]) if n > 1 else None

    return {
        key: Thresholds(
            (curve(key, "x", [first]), curve(key, "y", [first])),
            (curves(key, "x"), curves(key, "y")),
            is_equalized=result.as_set is not None,
        )
        for key in first["x"]
        if key != ALARMS
    }


def _sums_of(result: Result, units: Units) -> dict[str, Sums]:
    """Return false alarms and sums of every measure by unit, for X and Y."""
    measures = unit_measures(result, units)
    return {
        letter: {
            ALARMS: units.total(units.unit_of_frame, system.false_alarms),
            **{of.key: getattr(of, letter)[:, 0] for of in measures},
        }
        for letter, system in result.sides
    }


def parts_at_equal_alarms(
    thresholds: Thresholds, drawn: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compute the parts that simulated studies test at equal false alarms of X and Y.

    Like `nvcore.evidence.companions.shifts_at_equal_alarms` for a comparison, this takes each
    recording's part in the difference, minus the amount due to its part in the ratio of false
    alarms.

    Parameters
    ----------
    drawn
        How often each study has drawn each recording; shape (n_studies, n_recordings).

    Returns
    -------
    Three arrays. Parts, float64, shape (n_studies, n_recordings): NaN if no threshold equalises the
    two or, as in `nvcore.evidence.companions.judge_equal_alarms`, recordings say too little about
    it. Whether X and Y are set to unequal false alarms, by study. System with more false alarms as
    set, by study: 1 X, -1 Y, 0 neither.
    """
    x, y = thresholds.as_set
    n_x, n_y = (drawn @ of.alarms[0] for of in (x, y))
    is_unequal = _are_unequal(n_x, n_y)
    parts = np.full(drawn.shape, np.nan)
    x_moves = n_x > n_y
    if None in thresholds.curves:
        x_moves = np.full(len(drawn), thresholds.curves[0] is not None)
    for sign, moves in ((1, x_moves), (-1, ~x_moves)):
        curve, other_curve = thresholds.curves[::sign]
        other = thresholds.as_set[::sign][1]
        if curve is not None and moves.any():
            own_parts, error = _parts_of(curve, other_curve, other, drawn[moves])
            own_parts[is_unequal[moves] & (error > MOST_ERROR)] = np.nan
            parts[moves] = sign * own_parts
    return parts, is_unequal, np.sign(n_x - n_y)


def _parts_of(
    curve: Curve, other_curve: Curve | None, other: Curve, drawn: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the parts in the moved system's measure minus the other's, minus the alarms' share.

    The second result is the standard error of the logarithm of the ratio of false alarms, shape
    (n_studies,). Parts are NaN in studies in which no threshold gives equal false alarms.
    """
    n_other = drawn @ other.alarms[0]
    target = np.maximum(n_other, 1.0)
    alarms, moved = curve.at(drawn, target)
    parts, apart = moved - other.parts[0], alarms - other.alarms[0]
    error = np.minimum(np.sqrt((drawn * apart**2).sum(axis=1)) / target, LARGEST_ERROR)
    n_fewer = np.clip(target * np.exp(-error), 1, np.maximum(target - 1, 1))
    _, fewer = curve.at(drawn, n_fewer)
    if other_curve is None:
        _, more = curve.at(drawn, target * np.exp(error))
        against = more - other.parts[0]
    else:
        _, other_fewer = other_curve.at(drawn, n_fewer)
        against = moved - other_fewer
    change = (drawn * (fewer - other.parts[0] - against)).sum(axis=1)
    step = np.log(n_fewer / target) - (error if other_curve is None else np.log(target / n_fewer))
    slope = np.where(step < 0, change / np.minimum(step, -1e-9), 0.0)
    less: np.ndarray = parts - (slope / target)[:, np.newaxis] * apart
    less[_are_unequal((drawn * alarms).sum(axis=1), n_other)] = np.nan
    return less, error


def _are_unequal(n_one: np.ndarray, n_other: np.ndarray) -> np.ndarray:
    """Apply `are_unequal_alarms` to every study, bool, shape (n_studies,)."""
    pairs = zip(n_one, n_other, strict=True)
    return np.array([are_unequal_alarms(*pair) for pair in pairs], dtype=bool)
