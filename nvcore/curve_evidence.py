"""The log-average miss rate from sums over units, so that its difference can be tested."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.analysis import Result
from nvcore.curves import Outcomes, detection_outcomes
from nvcore.miss_rate import FPPI_REFERENCES
from nvcore.protocols import PROTOCOLS, Protocol
from nvcore.significance import LOWER, UnitFigure
from nvcore.tables import sides
from nvcore.units import Units

N_POINTS: Final = 200
"""Operating points besides the references: a resample finds its own among them."""
POINT_RANGE: Final = (0.002, 4.0)
"""False positives per image of these points; the references are 0.01 to 1."""


def log_average_miss_rate_figure(
    result: Result, units: Units, protocol: Protocol = PROTOCOLS["all"]
) -> UnitFigure | None:
    """The log-average miss rate for `nvcore.significance.significance_table`.

    Each system is counted at the same 200 levels of false positives per image, the nine
    references among them; a resample or exchange looks up the references among these levels. Over
    all units the figure is exactly `nvcore.miss_rate.log_average_miss_rate`.

    Returns
    -------
    None if a system has detections without a score, or no pedestrian counts.

    References
    ----------
    ``docs/detection.md``, log-average miss rate.
    """
    made = []
    for _, system in sides(result):
        outcomes = detection_outcomes(result.dataset, system.name, result.params, protocol)
        if np.isnan(outcomes.score).any() or not outcomes.truth.n_truth:
            return None
        made.append(_sums(outcomes, units))
    name = "" if protocol.name == "all" else f", {protocol.name}"
    return UnitFigure(
        "log_average_miss_rate", f"log-average miss rate{name}", LOWER, made[0], made[1],
        statistic=_log_average,
    )  # fmt: skip


def _levels() -> np.ndarray:
    """False positives per image at which systems are counted, increasing."""
    between = np.geomspace(*POINT_RANGE, N_POINTS)
    return np.union1d(between, FPPI_REFERENCES)


def _sums(outcomes: Outcomes, units: Units) -> np.ndarray:
    """Images, pedestrians, and false and true positives at each level, by unit.

    Shape (n_units, 1 + 1 + 2 * n_levels).
    """
    n = len(units)
    unit = units.unit_of_frame
    truth = outcomes.truth
    n_images = np.bincount(unit[truth.is_counted], minlength=n)
    n_truth = np.bincount(unit[truth.truth.frame_index[truth.counts]], minlength=n)
    # how many detections, from the highest score, pass at each level: equal scores together
    fp = np.cumsum(~outcomes.is_match)
    is_last = np.ones(len(fp), dtype=bool)
    is_last[:-1] = outcomes.score[1:] != outcomes.score[:-1]
    ends = np.flatnonzero(is_last)
    fppi = fp[ends] / max(truth.n_images, 1)
    last = np.searchsorted(fppi, _levels(), side="right") - 1
    n_passing = np.where(last < 0, 0, ends[np.maximum(last, 0)] + 1) if len(ends) else 0 * last
    level = np.searchsorted(n_passing, np.arange(len(fp)), side="right")  # the first to count it
    of_unit = unit[outcomes.frame_index]
    counts = []
    for is_it in (~outcomes.is_match, outcomes.is_match):
        first = np.zeros((n, len(n_passing) + 1))
        np.add.at(first, (of_unit[is_it], level[is_it]), 1)
        counts.append(np.cumsum(first[:, :-1], axis=1))
    return np.column_stack([n_images, n_truth, *counts])


def _log_average(sums: np.ndarray) -> np.ndarray:
    """LAMR from such sums, shape (..., columns) to (...); NaN without pedestrians."""
    n_levels = (sums.shape[-1] - 2) // 2
    with np.errstate(invalid="ignore", divide="ignore"):
        fppi = sums[..., 2 : 2 + n_levels] / sums[..., :1]
        miss_rate = 1 - sums[..., 2 + n_levels :] / sums[..., 1:2]
    # both are monotone along the levels: the last point below a reference has the least miss rate
    rates = np.stack(
        [np.min(np.where(fppi <= one * (1 + 1e-12), miss_rate, 1.0), axis=-1)
         for one in FPPI_REFERENCES], axis=-1,
    )  # fmt: skip
    with np.errstate(divide="ignore"):
        lamr: np.ndarray = np.exp(np.log(np.maximum(rates, 0)).mean(axis=-1))
    return np.where(np.isnan(miss_rate).any(axis=-1), np.nan, lamr)
