"""Thresholds at which X and Y have equally many false alarms: the fair pairs among all thresholds.

A system at a lax threshold detects more than one at a strict threshold; that says nothing about the
systems. At these pairs it does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.detection.operating_point import false_alarm_curve
from nvcore.scoring import SystemResult
from nvcore.stability.axes import ALARMS_PLAUSIBLE
from nvcore.stability.flips import Winner, winners

N_RATES: Final = 41
"""Number of false-alarm rates, in equal ratios like those over which the miss rate is averaged."""
CURVE_POINTS: Final = 100_000
"""Most thresholds of a system that are tried."""
ALIKE: Final = 0.1
"""Numbers of false alarms count as equal if they differ by at most this share of the larger."""

COLUMNS: Final = ("alarms_per_frame", "threshold_x", "threshold_y")


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


def equal_alarm_thresholds(result: Result) -> pd.DataFrame:
    """Thresholds of X and Y with equally many false alarms per frame.

    Returns
    -------
    Columns `COLUMNS`, at most `N_RATES` rows, rates increasing from the least to the greatest of
    `nvcore.stability.axes.ALARMS_PLAUSIBLE`: the lowest thresholds that give at most the rate.
    Left out are rates that a system does not reach, and those at which the numbers differ, as when
    many detections have the same score. No rows without scores.
    """
    rates = np.geomspace(*ALARMS_PLAUSIBLE, N_RATES)
    columns: dict[str, np.ndarray] = {"alarms_per_frame": rates}
    n_alarms, is_known = [], np.ones(N_RATES, dtype=bool)
    for letter, system in (("x", result.x), ("y", result.y)):
        curve = false_alarm_curve(
            result.dataset, system.name, result.params, n_points=CURVE_POINTS
        ).sort_values("threshold")
        if curve.empty:
            return pd.DataFrame({name: np.empty(0) for name in COLUMNS})
        per_frame = curve["false_alarms_per_frame"].to_numpy()
        is_within = per_frame[:, None] <= rates * (1 + 1e-9)
        first = is_within.argmax(axis=0)
        is_known &= is_within.any(axis=0) & (per_frame.max() >= rates * (1 - 1e-9))
        columns[f"threshold_{letter}"] = curve["threshold"].to_numpy()[first]
        n_alarms.append(curve["n_false_alarms"].to_numpy()[first])
    fewer, more = np.minimum(*n_alarms), np.maximum(*n_alarms)
    is_known &= (more > 0) & (more - fewer <= ALIKE * more)
    return pd.DataFrame(columns)[is_known].reset_index(drop=True)


def alarms_per_frame(result: Result, system: SystemResult) -> float:
    """Return the false alarms per frame as analysed, or NaN without frames."""
    n_frames = len(result.dataset.frames)
    return np.count_nonzero(system.matches.is_false_alarm) / n_frames if n_frames else np.nan
