"""How well detections overlap the truth once they are moved in time, in the picture, or scaled.

Only samples are compared: a correction that holds for the whole recording shows in them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.metrics.kernels.checks import best_overlaps

MAX_PAIRS: Final = 100_000
"""Pairs of a pedestrian and a detection that one look at the overlaps may cost."""
MAX_SHIFT: Final = 5
"""Largest time offset that is tried, in listed frames."""


def rows_in_ranges(start: np.ndarray, n: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows of ranges that begin at `start` and have `n` rows: number of the range, and row."""
    end = np.cumsum(n)
    number = np.repeat(np.arange(len(n)), n)
    return number, np.arange(n.sum()) - np.repeat(end - n - start, n)


@dataclass(frozen=True)
class Correction:
    """What is done to the detections: scaled, then moved in the picture, then in time.

    Attributes
    ----------
    scale
        By which x and w, y and h are multiplied.
    offset_px
        Added to x, y.
    offset_frames
        Added to the frame number.
    """

    scale: tuple[float, float] = (1.0, 1.0)
    offset_px: tuple[float, float] = (0.0, 0.0)
    offset_frames: int = 0


@dataclass(frozen=True)
class Overlaps:
    """Best detection of each sampled pedestrian.

    Attributes
    ----------
    iou
        Best IoU of any detection of the frame, 0 none; shape (n_sample,).
    dx, dy
        Centre of the pedestrian minus that of its best detection, px; NaN where none overlaps.
    ratio_w, ratio_h
        Width and height of the pedestrian over those of its best detection; NaN where none.
    has_frame
        Whether the detections' frame is a listed one of the recording; elsewhere nothing is known.
    """

    iou: np.ndarray
    dx: np.ndarray
    dy: np.ndarray
    ratio_w: np.ndarray
    ratio_h: np.ndarray
    has_frame: np.ndarray

    @property
    def mean(self) -> float:
        """Mean best IoU of the pedestrians whose frame is listed, 0..1; NaN where there is none."""
        return float(self.iou[self.has_frame].mean()) if self.has_frame.any() else np.nan


@dataclass(frozen=True)
class Sample:
    """Pedestrians of evenly spread frames, and the detections that they are held against.

    Attributes
    ----------
    dataset
        What they are from.
    rows
        Rows of the truth, int64, shape (n_sample,).
    detections
        All detections that count, sorted by frame.
    step
        1: every frame with pedestrians is compared; n: every n-th.
    """

    dataset: Dataset
    rows: np.ndarray
    detections: BoxColumns
    step: int

    def overlaps(self, correction: Correction) -> Overlaps:
        """The best overlaps after a correction of the detections."""
        det, frames = self.detections, self.dataset.frame_columns
        n = len(self.rows)
        best, dx, dy, ratio_w, ratio_h = np.empty((5, n))
        has_frame = np.empty(n, np.bool_)
        best_overlaps(
            *self._pedestrians,
            *(frames.recording, frames.frame, frames.first),
            *(det.offsets, det.x, det.y, det.w, det.h),
            *map(float, (*correction.scale, *correction.offset_px)),
            -correction.offset_frames,
            *(best, dx, dy, ratio_w, ratio_h, has_frame),
        )
        return Overlaps(best, dx, dy, ratio_w, ratio_h, has_frame)

    @cached_property
    def _pedestrians(self) -> tuple[np.ndarray, ...]:
        """frame_index, x, y, w, h of the rows, side by side in memory: they are read many times."""
        truth = self.dataset.truth
        columns = (truth.frame_index, truth.x, truth.y, truth.w, truth.h)
        return tuple(column[self.rows] for column in columns)

    @cached_property
    def pairs_by_order(self) -> tuple[np.ndarray, np.ndarray]:
        """Truth rows and detections that have the same place in the order from left to right.

        Only frames with as many pedestrians as detections; empty where there is none. Needs no
        overlap, so it works for boxes far off.
        """
        truth, det, rows = self.dataset.truth, self.detections, self.rows
        in_frame, n_truth = np.unique(truth.frame_index[rows], return_counts=True)
        n_det = det.offsets[in_frame + 1] - det.offsets[in_frame]
        is_equal = n_truth == n_det
        g = rows[np.repeat(is_equal, n_truth)]
        d = rows_in_ranges(det.offsets[in_frame[is_equal]], n_det[is_equal])[1]
        return (
            g[np.lexsort((truth.x[g] + truth.w[g] / 2, truth.frame_index[g]))],
            d[np.lexsort((det.x[d] + det.w[d] / 2, det.frame_index[d]))],
        )

    def frame_step(self) -> int:
        """Smallest usual step between listed frames: what a time offset is a multiple of."""
        frames = self.dataset.frame_columns
        lengths = np.diff(frames.first)
        last = frames.first[1:][lengths > 1] - 1  # a last frame's gap is its recording's median
        return max(1, round(float(frames.gap[last].min()))) if len(last) else 1


def take_sample(dataset: Dataset, detections: BoxColumns) -> Sample:
    """Pedestrians of evenly spread frames, as many as are quick to look at."""
    truth = dataset.truth
    n_truth = np.diff(truth.offsets)
    if truth.ignore.any():
        n_truth = np.bincount(truth.frame_index[~truth.ignore], minlength=len(n_truth))
    n_pairs = int((n_truth * np.diff(detections.offsets)).sum())
    step = -(-n_pairs // MAX_PAIRS) if n_pairs else 1
    # frames are numbered among those with pedestrians, so that a sampling step of the annotation
    # cannot fall in with this one
    chosen = np.flatnonzero(n_truth)[::step]
    start = truth.offsets[chosen]
    rows = rows_in_ranges(start, truth.offsets[chosen + 1] - start)[1]
    return Sample(dataset, rows[~truth.ignore[rows]], detections, step)


def above_threshold(boxes: BoxColumns, threshold: float | None) -> BoxColumns:
    """The detections that pass a threshold; those without a score always do."""
    return boxes if threshold is None else boxes.only(~(boxes.score < threshold))
