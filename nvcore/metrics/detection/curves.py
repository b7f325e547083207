"""Detection curves: true and false positives of a system by score threshold."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import ParameterError
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import DetectionState
from nvcore.metrics.detection.filtered_truth import FilteredTruth, filter_detections, filter_truth
from nvcore.metrics.detection.operating_point import MIXED_POINTS, has_one_score, thinned
from nvcore.metrics.matching import Matches, match_boxes, match_system
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS, Protocol

CURVE_COLUMNS: Final = (
    "threshold",
    "tp",
    "fp",
    "fn",
    "precision",
    "recall",
    "miss_rate",
    "f1",
    "fppi",
    "fppw",
)
"""Columns of `curve_table`."""


@dataclass(frozen=True)
class CurvePoint:
    """One point of a detection curve.

    Attributes
    ----------
    threshold
        Lowest score that counts; inf if only detections without a score count.
    tp, fp, fn
        Numbers of matched pedestrians, detections that match nobody, missed pedestrians.
    precision, recall, f1
        1 is best; NaN where undefined (`DetectionCurve`).
    fppi
        False positives per image; 0 is best.
    """

    threshold: float
    tp: int
    fp: int
    fn: int
    precision: float
    recall: float
    f1: float
    fppi: float

    @property
    def miss_rate(self) -> float:
        """Share of the pedestrians that are missed. 0 is best."""
        return 1 - self.recall


@dataclass(frozen=True, eq=False)
class DetectionCurve:
    """Detections of one system at every score threshold.

    Attributes
    ----------
    system, protocol
        System of the curve, and protocol that selects the pedestrians.
    threshold
        The distinct scores, descending; float64, (n_points,). Equal scores are one point. The first
        is inf if there are detections without a score, which pass every threshold.
    tp, fp
        Numbers of matched pedestrians, and of detections that neither match nor are absorbed by an
        ignored box, at or above each threshold; int64, (n_points,).
    n_truth, n_images
        Numbers of pedestrian boxes and frames that count, the same for every system.
    is_ranked
        True if every detection has a score and the scores differ. Otherwise there are points (a
        single one if no score exists or all are equal) but no areas.
    absorbed_score
        Scores of the detections that ignored boxes absorb, NaN if they have none; float64,
        (n_absorbed,). Such detections are neither right nor wrong.

    Notes
    -----
    Without detections there are no points. Without pedestrians, recall, miss rate and F1 are NaN.
    """

    system: str
    protocol: Protocol
    threshold: np.ndarray
    tp: np.ndarray
    fp: np.ndarray
    n_truth: int
    n_images: int
    is_ranked: bool = True
    absorbed_score: np.ndarray = field(default_factory=lambda: np.empty(0))

    def __len__(self) -> int:
        return len(self.threshold)

    @property
    def recall(self) -> np.ndarray:
        """Share of the pedestrians that are detected (detection rate), 1 is best, (n_points,)."""
        return _ratio(self.tp, self.n_truth)

    @property
    def miss_rate(self) -> np.ndarray:
        """Share of the pedestrians that are missed, 0 is best, (n_points,)."""
        return _ratio(self.n_truth - self.tp, self.n_truth)

    @property
    def precision(self) -> np.ndarray:
        """Share of the detections that are right, 1 is best, NaN without any, (n_points,)."""
        return _ratio(self.tp, self.tp + self.fp)

    @property
    def f1(self) -> np.ndarray:
        """Harmonic mean of precision and recall, 1 is best, (n_points,)."""
        if not self.n_truth:
            return np.full(len(self), np.nan)
        return _ratio(2 * self.tp, self.tp + self.fp + self.n_truth)

    @property
    def fppi(self) -> np.ndarray:
        """False positives per image, including images without detections, (n_points,)."""
        return _ratio(self.fp, self.n_images)

    def fppw(self, windows_per_image: float) -> np.ndarray:
        """Compute the false positives per window, 0 is best, (n_points,).

        Parameters
        ----------
        windows_per_image
            Number of windows that the detector examines per image, the mean if images differ
            (`nvcore.metrics.detection.windows`).

        Raises
        ------
        ParameterError
            If it is not a positive number.
        """
        if not 0 < windows_per_image < np.inf:
            raise ParameterError(
                f"windows_per_image: expected a positive number, got {windows_per_image:g}"
            )
        return self.fppi / windows_per_image

    def at(self, threshold: float | None) -> CurvePoint:
        """Return the operating point at a threshold: the point of the lowest score that passes it.

        With None, every detection counts. Above all scores, nothing is detected.
        """
        limit = -np.inf if threshold is None else threshold
        i = int(np.searchsorted(-self.threshold, -limit, side="right")) - 1
        if i < 0:
            none = np.array([0])
            return replace(self, threshold=np.array([limit]), tp=none, fp=none).at(None)
        return CurvePoint(
            threshold=float(self.threshold[i]),
            tp=int(self.tp[i]),
            fp=int(self.fp[i]),
            fn=int(self.n_truth - self.tp[i]),
            precision=float(self.precision[i]),
            recall=float(self.recall[i]),
            f1=float(self.f1[i]),
            fppi=float(self.fppi[i]),
        )

    def n_absorbed(self, threshold: float | None) -> int:
        """Count the detections that ignored boxes absorb at a threshold (None: at any score)."""
        if threshold is None:
            return len(self.absorbed_score)
        return int(np.count_nonzero(~(self.absorbed_score < threshold)))

    @property
    def why_undefined(self) -> str | None:
        """Reason why areas and averages of the curve are undefined, or None."""
        if not self.n_truth:
            return "no box of the truth counts under this protocol"
        if self.is_ranked:
            return None
        if np.isinf(self.threshold).any():
            return "detections have no score: there are points, but no curve"
        return "no scores differ: there is a point, but no curve"


@dataclass(frozen=True, eq=False)
class Outcomes:
    """Outcome of each counted detection of one system, from which a curve is summed.

    Attributes
    ----------
    score
        Scores in descending order, missing ones (NaN) last; float64, (n,).
    is_match
        True for a match, False for a false positive; bool, (n,).
    frame_index
        Row of the frames table; int64, (n,).
    recording
        Row of the recordings table; int32, (n,).
    n_truth, n_images
        Pedestrian boxes and frames that count; int64, (n_recordings,).
    truth
        The ground truth under the protocol.
    absorbed_score
        Scores of the detections that are left out because ignored boxes absorb them; float64, in
        the order of the frames.
    """

    score: np.ndarray
    is_match: np.ndarray
    frame_index: np.ndarray
    recording: np.ndarray
    n_truth: np.ndarray
    n_images: np.ndarray
    truth: FilteredTruth
    absorbed_score: np.ndarray


def detection_curve(
    dataset: Dataset,
    system: str,
    params: Params,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    recordings: np.ndarray | None = None,
) -> DetectionCurve:
    """Compute the curve of one system over all score thresholds.

    Parameters
    ----------
    params
        Settings for matching. Its thresholds are not used.
    protocol
        Protocol that selects the pedestrians.
    recordings
        Recordings that may count, in addition to the protocol's tags; bool, (n_recordings,); None:
        all.

    Raises
    ------
    InputError
        If there is no such system, or no recording is left.

    Notes
    -----
    Detections are matched in descending score order, so one matching gives all points. Detections
    without a score come last and may take pedestrians that a higher threshold leaves unmatched. A
    system with both kinds is therefore matched again at each of at most `MIXED_POINTS` thresholds.
    """
    truth = filter_truth(dataset, protocol, recordings=recordings)
    detections = _taking_part(dataset, system, protocol)
    score = detections.score[truth.is_counted[detections.frame_index]]
    is_scored = ~np.isnan(score)
    if is_scored.all():
        outcomes = _outcomes(dataset, truth, detections, params)
        is_last = np.ones(len(outcomes.score), dtype=bool)  # of its equals
        is_last[:-1] = outcomes.score[1:] != outcomes.score[:-1]
        threshold = outcomes.score[is_last]
        tp = np.cumsum(outcomes.is_match)[is_last]
        fp = np.cumsum(~outcomes.is_match)[is_last]
    else:
        scores = thinned(np.unique(score[is_scored])[::-1], MIXED_POINTS - 1)
        threshold = np.concatenate([[np.inf], scores])
        points = []
        for t in threshold:
            outcomes = _outcomes(dataset, truth, detections, params, threshold=t)
            points.append(outcomes.is_match)
        tp = np.array([np.count_nonzero(is_match) for is_match in points])
        fp = np.array([len(is_match) for is_match in points]) - tp
    return DetectionCurve(
        system=system,
        protocol=protocol,
        threshold=threshold,
        tp=tp.astype(np.int64),
        fp=fp.astype(np.int64),
        n_truth=truth.n_truth,
        n_images=truth.n_images,
        is_ranked=bool(is_scored.all()) and not has_one_score(dataset, system),
        absorbed_score=outcomes.absorbed_score,
    )


def detection_outcomes(
    dataset: Dataset, system: str, params: Params, protocol: Protocol = PROTOCOLS["all"]
) -> Outcomes:
    """Return the outcome of each detection at the lowest threshold, for resampling recordings.

    Parameters and errors are those of `detection_curve`. Detections absorbed by ignored boxes are
    left out.
    """
    truth = filter_truth(dataset, protocol)
    detections = _taking_part(dataset, system, protocol)
    matches = None
    all_of_them = dataset.system(system)
    if detections is all_of_them and np.array_equal(truth.truth.ignore, dataset.truth.ignore):
        matches = match_system(dataset, system, None, params)
    return _outcomes(dataset, truth, detections, params, matches=matches)


def curve_table(curve: DetectionCurve, *, windows_per_image: float | None = None) -> pd.DataFrame:
    """Tabulate a curve: `CURVE_COLUMNS`, one row per point, thresholds descending.

    The column fppw needs `windows_per_image`. The ROC is `recall` (detection rate) over `fppi` or
    `fppw`.
    """
    no_fppw = np.full(len(curve), np.nan)
    return pd.DataFrame(
        {
            "threshold": curve.threshold,
            "tp": curve.tp,
            "fp": curve.fp,
            "fn": curve.n_truth - curve.tp,
            "precision": curve.precision,
            "recall": curve.recall,
            "miss_rate": curve.miss_rate,
            "f1": curve.f1,
            "fppi": curve.fppi,
            "fppw": no_fppw if windows_per_image is None else curve.fppw(windows_per_image),
        },
        columns=list(CURVE_COLUMNS),
    )


def _outcomes(
    dataset: Dataset,
    truth: FilteredTruth,
    detections: BoxColumns,
    params: Params,
    *,
    threshold: float | None = None,
    matches: Matches | None = None,
) -> Outcomes:
    frames = dataset.frame_columns
    if matches is None:
        matches = match_boxes(truth.truth, detections, frames, params, threshold=threshold)
    is_here = truth.is_counted[detections.frame_index]
    rows = np.flatnonzero(is_here & matches.is_counted)
    rows = rows[np.argsort(-detections.score[rows], kind="stable")]
    n_recordings = len(dataset.recordings)
    truth_in = frames.recording[truth.truth.frame_index[truth.counts]]
    return Outcomes(
        score=detections.score[rows],
        is_match=matches.state[rows] == DetectionState.MATCHED,
        frame_index=detections.frame_index[rows],
        recording=frames.recording[detections.frame_index[rows]],
        n_truth=np.bincount(truth_in, minlength=n_recordings),
        n_images=np.bincount(frames.recording[truth.is_counted], minlength=n_recordings),
        truth=truth,
        absorbed_score=detections.score[is_here & (matches.state == DetectionState.ABSORBED)],
    )


def _taking_part(dataset: Dataset, system: str, protocol: Protocol) -> BoxColumns:
    """Return the detections of a system that take part in the protocol."""
    detections = dataset.system(system)
    takes_part = filter_detections(detections, protocol)
    return detections if takes_part.all() else detections.only(takes_part)


def _ratio(part: np.ndarray, whole: np.ndarray | int) -> np.ndarray:
    """Divide elementwise, giving NaN if the whole is 0."""
    divisor = np.broadcast_to(np.asarray(whole, dtype=float), part.shape)
    quotient = np.full(part.shape, np.nan)
    np.divide(part, divisor, out=quotient, where=divisor > 0)
    return quotient
