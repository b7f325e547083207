"""Matching of detections to pedestrians, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import DetectionState
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.frames import MatchRule, match_frames
from nvcore.settings.params import Params

Boxes = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""x, y, w, h of boxes, px."""


@dataclass(frozen=True)
class Matches:
    """Result of matching one system's detections to the ground truth.

    Attributes
    ----------
    state
        A `DetectionState` per detection; int8, (n_det,).
    det_truth
        Per detection: row of its pedestrian among the truth boxes, -1 none; int64, (n_det,).
    truth_det
        Per truth box: row of its detection among the system's boxes, -1 none; int64, (n_truth,).
    """

    state: np.ndarray
    det_truth: np.ndarray
    truth_det: np.ndarray

    @property
    def is_counted(self) -> np.ndarray:
        """Detections that belong to S (above the threshold, not absorbed), bool, (n_det,)."""
        in_s = (DetectionState.MATCHED, DetectionState.FALSE_ALARM)
        is_in_s: np.ndarray = np.isin(self.state, in_s)
        return is_in_s

    @property
    def is_false_alarm(self) -> np.ndarray:
        """Detections that match no pedestrian and are not absorbed, bool, (n_det,)."""
        alarms: np.ndarray = self.state == DetectionState.FALSE_ALARM
        return alarms

    @property
    def n_absorbed(self) -> int:
        """Number of detections above the threshold on people or regions that the truth ignores."""
        return int(np.count_nonzero(self.state == DetectionState.ABSORBED))

    @property
    def is_matched(self) -> np.ndarray:
        """Truth boxes that the system matched, bool, (n_truth,)."""
        has_detection: np.ndarray = self.truth_det >= 0
        return has_detection


def match_system(dataset: Dataset, name: str, threshold: float | None, params: Params) -> Matches:
    """Match all detections of a system with `match_boxes`.

    The dataset caches the latest result with a threshold and the latest without.
    """
    rule = (params.match, params.iou, params.lateral_tolerance, params.match_class)
    key = (threshold, *rule)
    place = ("matches", name, threshold is None)
    before = dataset.derived.get(place)
    matches: Matches | None = before[1] if before is not None and before[0] == key else None
    if matches is None:
        matches = match_boxes(
            dataset.truth, dataset.system(name), dataset.frame_columns, params, threshold=threshold
        )
        dataset.derived[place] = key, matches
    return matches


def match_boxes(
    truth: BoxColumns,
    detections: BoxColumns,
    frames: FrameColumns,
    params: Params,
    *,
    threshold: float | None = None,
) -> Matches:
    """Match detections to pedestrians.

    In each frame, detections in descending score order (file order on ties, those without a score
    last) each take the free pedestrian with the highest IoU, if it is at least `iou`. With
    ``match="lateral"`` they take the nearest free one with
    ``|c_a - c_b| <= max(lateral_tolerance * W, w_truth / 2)``. A remaining detection on an ignore
    region (intersection over own area >= 0.5) is absorbed. With ``match_class="same"``, a
    pedestrian with a class is only matched by detections of that class.

    Parameters
    ----------
    truth, detections
        Boxes, px, sorted by frame.
    frames
        The listed frames.
    params
        Only `match`, `iou`, `lateral_tolerance` and `match_class` are used.
    threshold
        Detections with a lower score are left out; None: all count. A detection without a score
        passes every threshold: its system has already decided.

    Notes
    -----
    No truth: every detection is a false alarm or absorbed. No detections: nothing is matched.

    References
    ----------
    ``docs/metrics.md``, matching.
    """
    state = np.zeros(len(detections), np.int8)
    det_truth = np.full(len(detections), -1, np.int64)
    truth_det = np.full(len(truth), -1, np.int64)
    rule = MatchRule(
        threshold=-np.inf if threshold is None else float(threshold),
        lateral=params.match == "lateral",
        min_iou=float(params.iou),
        tolerance=float(params.lateral_tolerance),
        same_label=params.match_class == "same",
    )
    boxes, outputs = (truth.arrays, detections.arrays), (state, det_truth, truth_det)
    over_ranges(match_frames, len(frames), *boxes, rule, frames.arrays, *outputs)
    return Matches(state, det_truth, truth_det)


def count_per_frame(boxes: BoxColumns, member: np.ndarray) -> np.ndarray:
    """Count the boxes with ``member`` in each frame, int64, shape (n_frames,)."""
    total = np.concatenate([[0], np.cumsum(member)])
    counts: np.ndarray = np.diff(total[boxes.offsets])
    return counts


def iou_of_pairs(a: Boxes, b: Boxes) -> np.ndarray:
    """Return the intersection over union of boxes at the same position in two sets of arrays.

    Arrays of different shapes are broadcast. The result is 0 for two boxes without area.
    """
    (ax, ay, aw, ah), (bx, by, bw, bh) = a, b
    across = np.minimum(ax + aw, bx + bw) - np.maximum(ax, bx)
    down = np.minimum(ay + ah, by + bh) - np.maximum(ay, by)
    shared = np.maximum(across, 0) * np.maximum(down, 0)
    union = aw * ah + bw * bh - shared
    iou: np.ndarray = np.divide(shared, union, out=np.zeros_like(union), where=union > 0)
    return iou
