"""Line through saliency over mean rank, and the clips that lie far from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.evidence.bootstrap import CONFIDENCE
from nvcore.subjects.ratings.validation import LEAST_CLIPS, SEED

N_RESAMPLES: Final = 2_000
N_POINTS: Final = 41
"""Number of points along the line at which its interval is given."""
OUTLIER_SPREADS: Final = 3.0
"""Least distance of an outlier from the line, in robust standard deviations."""
MAD_TO_SD: Final = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


@dataclass(frozen=True, eq=False)
class Trend:
    """Saliency as a straight line over mean rank (least squares).

    Attributes
    ----------
    slope_s, low_s, high_s
        Seconds of saliency per rank, with the 95 % interval.
    rank, saliency_s, least_s, most_s
        Positions along the line, the line there, and its 95 % interval; float64, shape (n_points,).
    residual_s
        Distance of each clip above the line; float64, shape (n_clips,).
    is_outlier
        Clips more than three robust standard deviations (1.4826 times the median distance from the
        line) away from it; bool, shape (n_clips,).
    """

    slope_s: float
    low_s: float
    high_s: float
    rank: np.ndarray
    saliency_s: np.ndarray
    least_s: np.ndarray
    most_s: np.ndarray
    residual_s: np.ndarray
    is_outlier: np.ndarray


def fit_trend(clips: pd.DataFrame) -> Trend | None:
    """Fit the line through the clips, None with fewer than five clips, or all of one rank.

    Parameters
    ----------
    clips
        Clips from `nvcore.subjects.ratings.validation.join_clips`.

    Notes
    -----
    Intervals are percentiles of 2,000 resamples of the recordings with a fixed seed. The clips of
    one recording, shown with two systems, are drawn together.
    """
    x, y = (clips[name].to_numpy(dtype=float) for name in ("mean_rank", "saliency_s"))
    if len(clips) < LEAST_CLIPS or np.ptp(x) == 0:
        return None
    middle = x.mean()
    terms = np.column_stack([np.ones(len(x)), x - middle, y, (x - middle) ** 2, (x - middle) * y])
    code, names = pd.factorize(clips["recording"])
    by_recording = np.zeros((len(names), terms.shape[1]))
    np.add.at(by_recording, code, terms)
    slope, height = _lines(by_recording.sum(axis=0))
    rng = np.random.default_rng(SEED)
    drawn = rng.multinomial(len(names), np.full(len(names), 1 / len(names)), size=N_RESAMPLES)
    slopes, heights = _lines(drawn @ by_recording)
    rank = np.linspace(x.min(), x.max(), N_POINTS)
    tails = 50 * (1 - CONFIDENCE), 50 * (1 + CONFIDENCE)
    is_line = np.isfinite(slopes)  # a resample may have only one rank
    lines = heights[is_line, None] + slopes[is_line, None] * (rank - middle)
    least_s, most_s = np.percentile(lines, tails, axis=0)
    low_s, high_s = np.percentile(slopes[is_line], tails)
    residual_s = y - (height + slope * (x - middle))
    spread_s = MAD_TO_SD * np.median(np.abs(residual_s))
    # rounding errors around a perfect line are no distance
    limit_s = max(OUTLIER_SPREADS * spread_s, 1e-9 * np.abs(y).max())
    return Trend(
        *(float(slope), float(low_s), float(high_s)),
        *(rank, height + slope * (rank - middle), least_s, most_s),
        *(residual_s, np.abs(residual_s) > limit_s),
    )


def _lines(sums: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return slope and value at 0 of the least-squares lines from the sums of 1, x, y, xx, xy."""
    n, x, y, xx, xy = np.moveaxis(sums, -1, 0)
    spread = n * xx - x * x
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.where(spread > 1e-9 * n * xx, (n * xy - x * y) / spread, np.nan)
    return slope, (y - slope * x) / n
