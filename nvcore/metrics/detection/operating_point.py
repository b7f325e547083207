"""Operating points: the effect of a score threshold on a system, and fair thresholds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.dataset.schema import DetectionState
from nvcore.metrics.matching import Matches, match_system
from nvcore.metrics.venn import MIN_DISCORDANT
from nvcore.settings.params import Params

CURVE_POINTS: Final = 200
"""Most points of a false-alarm curve."""
MIXED_POINTS: Final = 25
"""Most points of a curve if some detections have no score, since each point is matched separately.
"""
LEAST_DECIMALS: Final = 2
"""Fewest decimals of a proposed threshold, equal to those of a slider's step."""
MAX_DECIMALS: Final = 6
"""Most decimals of a proposed threshold."""

UNEQUAL: Final = 1.5
"""Ratio above which two numbers of false alarms count as unequal."""
LEAST_MORE: Final = MIN_DISCORDANT
"""Least difference of unequal numbers. A smaller one may be chance, as with encounters."""

CURVE_COLUMNS: Final = (
    "threshold",
    "n_kept",
    "n_false_alarms",
    "false_alarms_per_frame",
    "false_alarms_per_minute",
)


@dataclass(frozen=True)
class OperatingPoint:
    """Detections and false alarms of one system at a threshold.

    Attributes
    ----------
    threshold
        Detections with a lower score are left out; None: every detection counts.
    n_kept
        Number of detections that pass it.
    n_false_alarms
        Number of passing detections that neither match nor are absorbed by an ignore region; 0 is
        best.
    false_alarms_per_frame, false_alarms_per_minute
        Rates by listed frames and by recording time; NaN without frames.
    """

    threshold: float | None
    n_kept: int
    n_false_alarms: int
    false_alarms_per_frame: float
    false_alarms_per_minute: float


@dataclass(frozen=True)
class SameOperatingPoint:
    """X at its own threshold, and Y at the threshold with the most similar false alarms."""

    x: OperatingPoint
    y: OperatingPoint

    @property
    def threshold_y(self) -> float | None:
        """Threshold for Y.

        None means that every detection counts and Y has no more false alarms than X.
        """
        return self.y.threshold


def are_unequal_alarms(n_one: int, n_other: int) -> bool:
    """Whether systems with these numbers of false alarms are at different operating points.

    Examples
    --------
    >>> are_unequal_alarms(590, 580), are_unequal_alarms(16, 10), are_unequal_alarms(5, 0)
    (False, True, False)
    """
    fewer, more = sorted((n_one, n_other))
    return more > UNEQUAL * fewer and more - fewer >= LEAST_MORE


def operating_point(
    dataset: Dataset, system: str, params: Params, *, threshold: float | None
) -> OperatingPoint:
    """Return the operating point of a system at a threshold.

    `params` define matching. Their thresholds are not used.

    Raises
    ------
    InputError
        If there is no such system.
    """
    return point_of_matches(dataset, match_system(dataset, system, threshold, params), threshold)


def point_of_matches(dataset: Dataset, matches: Matches, threshold: float | None) -> OperatingPoint:
    """Return the operating point of existing matches, without matching again."""
    n_kept = int(np.count_nonzero(matches.state != DetectionState.BELOW))
    n_alarms = int(np.count_nonzero(matches.is_false_alarm))
    per_frame, per_minute = _rates(dataset, np.array([n_alarms]))
    return OperatingPoint(threshold, n_kept, n_alarms, float(per_frame[0]), float(per_minute[0]))


def alarms_at_rate(dataset: Dataset, per_frame: float) -> int:
    """Convert false alarms per frame into a number of false alarms.

    Raises
    ------
    ValueError
        If it is negative or not finite.
    """
    if not 0 <= per_frame < np.inf:
        raise ValueError(f"false alarms per frame: expected 0 or more, got {per_frame:g}")
    return round(per_frame * len(dataset.frames))


def false_alarm_curve(
    dataset: Dataset, system: str, params: Params, *, n_points: int = CURVE_POINTS
) -> pd.DataFrame:
    """Count kept detections and false alarms at thresholds from the lowest to the highest score.

    Returns
    -------
    Columns `CURVE_COLUMNS`, at most `n_points` rows, thresholds increasing. A system whose scores
    do not differ has no rows, because a threshold keeps all of its detections or none.

    Notes
    -----
    Detections are matched in descending score order, so a threshold changes nothing for those above
    it, and one matching gives all points. Detections without a score come last and may take
    pedestrians that a higher threshold leaves unmatched. A system with both kinds is therefore
    matched again at each of at most `MIXED_POINTS` points.

    Raises
    ------
    InputError
        If there is no such system.
    """
    score = dataset.system(system).score
    is_scored = ~np.isnan(score)
    thresholds = np.unique(score[is_scored])
    thresholds = thresholds if len(thresholds) > 1 else thresholds[:0]
    thresholds = thinned(thresholds, n_points if is_scored.all() else min(n_points, MIXED_POINTS))
    if is_scored.all():
        matches = match_system(dataset, system, None, params)
        n_kept = _count_from(score, thresholds)
        n_alarms = _count_from(score[matches.is_false_alarm], thresholds)
    else:
        points = [operating_point(dataset, system, params, threshold=t) for t in thresholds]
        n_kept = np.array([point.n_kept for point in points], np.int64)
        n_alarms = np.array([point.n_false_alarms for point in points], np.int64)
    columns = (thresholds, n_kept, n_alarms, *_rates(dataset, n_alarms))
    return pd.DataFrame(dict(zip(CURVE_COLUMNS, columns, strict=True)))


def thinned(values: np.ndarray, most: int) -> np.ndarray:
    """Return at most `most` of the values, evenly spaced, including the first and the last."""
    if len(values) <= most:
        return values
    return values[np.linspace(0, len(values) - 1, most).round().astype(np.int64)]


def same_operating_point(dataset: Dataset, params: Params, x: str, y: str) -> SameOperatingPoint:
    """Find the threshold at which Y has as many false alarms per frame as X at its own threshold.

    X uses ``params.threshold_x``. Y gets the number of false alarms closest to X's that a threshold
    can give (the lower one on a tie). Of the thresholds that give it, the lowest round one is
    chosen, so that no match is lost needlessly.

    Raises
    ------
    InputError
        If there is no such system.
    """
    at_x = operating_point(dataset, x, params, threshold=params.threshold_x)
    threshold = threshold_with_alarms(dataset, y, params, at_x.n_false_alarms)
    return SameOperatingPoint(at_x, operating_point(dataset, y, params, threshold=threshold))


def choose_moved(
    has_scores: Sequence[bool], n_alarms: Sequence[int], n_kept: Sequence[int]
) -> int | None:
    """Choose the system whose threshold changes so that all have equally many false alarms.

    This is the system with the most false alarms among those with scores (with more detections on a
    tie). Raising a threshold is always possible, while lowering it reaches no further than the
    scores.

    Parameters
    ----------
    has_scores, n_alarms, n_kept
        For each system: whether a threshold can change it, its false alarms, its detections.

    Returns
    -------
    Index of the system, the first one on a tie; None if no system has scores.

    Examples
    --------
    >>> choose_moved([True, True], [3, 5], [100, 90])
    1
    """
    movable = [index for index, has in enumerate(has_scores) if has]
    return max(movable, key=lambda index: (n_alarms[index], n_kept[index]), default=None)


def threshold_with_alarms(
    dataset: Dataset,
    system: str,
    params: Params,
    n_target: int,
    *,
    end: Literal["round", "lowest", "highest"] = "round",
) -> float | None:
    """Return the threshold whose number of false alarms is closest to `n_target`, None for all.

    The thresholds of `params` are not used. At least one counted detection is kept, because a
    threshold that switches the system off is no operating point.

    Parameters
    ----------
    end
        Choice among equivalent thresholds: the lowest with few decimals, the lowest, or the
        highest.
    """
    score = dataset.system(system).score
    matches = match_system(dataset, system, None, params)
    is_scored = ~np.isnan(score)
    if span_of_scores(dataset, system) is None or not matches.is_false_alarm.any():
        return None
    if not is_scored.all():
        curve = false_alarm_curve(dataset, system, params)
        n_alarms = curve["n_false_alarms"].to_numpy()[::-1]
        distance = np.abs(n_alarms - n_target)
        rows = np.flatnonzero(distance == distance.min())
        return float(curve["threshold"].to_numpy()[::-1][rows[0]])
    alarms = np.sort(score[matches.is_false_alarm])[::-1]
    # equal scores stay or go together
    possible = np.concatenate([[0], np.flatnonzero(np.diff(alarms)) + 1, [len(alarms)]])
    highest = float(score[matches.is_counted].max())
    possible = possible[int(highest == alarms[0]) :]  # no false alarm would be no detection
    n_left = int(possible[np.argmin(np.abs(possible - n_target))])
    score_in = float(alarms[n_left - 1]) if n_left else highest
    if end == "highest":
        return score_in
    if n_left == len(alarms):
        return None
    score_out = float(alarms[n_left])
    if end == "lowest":
        return float(np.nextafter(score_out, np.inf))
    threshold = round_between(score_out, score_in)
    return score_in if threshold is None else threshold


def threshold_for(scores: np.ndarray, n_scores: int) -> float | None:
    """Return a round threshold that `n_scores` scores pass, or None.

    None means that there is no such threshold, or that all scores or none would pass.

    Parameters
    ----------
    scores
        Scores in descending order, shape (n,).
    """
    if not 0 < n_scores < len(scores):
        return None
    return round_between(float(scores[n_scores]), float(scores[n_scores - 1]))


def round_between(score_out: float, score_in: float) -> float | None:
    """Return the lowest round threshold with ``score_out < threshold <= score_in``, or None.

    The lowest one is used because scores between the two false alarms belong to matches, which
    should stay.
    """
    for decimals in range(LEAST_DECIMALS, MAX_DECIMALS + 1):  # a loop over a few decimals
        scale = 10**decimals
        step = np.floor(score_out * scale) + 1
        for candidate in (float(step / scale), float((step + 1) / scale)):  # the product rounds
            if score_out < candidate <= score_in:
                return candidate
    return None


def score_histogram(dataset: Dataset, system: str, bins: int = 60) -> pd.DataFrame:
    """Count a system's detections by score in equally wide bins from `low` to `high`.

    Returns
    -------
    Columns low, high, n; the last bin includes its upper end. Detections without a finite score
    are not counted. Without any finite score there are no rows.

    Raises
    ------
    InputError
        If there is no such system.
    """
    score = dataset.system(system).score
    score = score[np.isfinite(score)]
    n, edges = np.histogram(score, bins=bins) if len(score) else (np.empty(0, np.int64), [0.0])
    return pd.DataFrame({"low": edges[:-1], "high": edges[1:], "n": n}).astype(
        {"low": "float64", "high": "float64", "n": "int64"}
    )


def _count_from(score: np.ndarray, thresholds: np.ndarray) -> np.ndarray:
    """Count the scores at or above each threshold, int64."""
    n_from: np.ndarray = len(score) - np.searchsorted(np.sort(score), thresholds, side="left")
    return n_from.astype(np.int64)


def _rates(dataset: Dataset, n_alarms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return false alarms per frame and per minute."""
    n_frames, duration_s = len(dataset.frames), dataset.frame_columns.duration_s
    undefined = np.full(len(n_alarms), np.nan)
    return (
        n_alarms / n_frames if n_frames else undefined,
        n_alarms / duration_s * 60 if duration_s else undefined,
    )


def has_one_score(dataset: Dataset, system: str) -> bool:
    """Whether there are several detections with one and the same score, which cannot rank them."""
    score = dataset.system(system).score
    return len(score) > 1 and bool(score.min() == score.max())


def span_of_scores(dataset: Dataset, system: str) -> tuple[float, float] | None:
    """Return the lowest and highest score of a system, or None if no two finite scores differ."""
    score = dataset.system(system).score
    score = score[np.isfinite(score)]
    if not len(score) or score.min() == score.max():
        return None
    return float(score.min()), float(score.max())
