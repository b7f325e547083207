"""Greedy suppression of boxes that overlap a more confident one; scores are kept."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import Detections


def sorted_detections(
    box: NDArray[np.float64], score: NDArray[np.float64], label: NDArray[np.object_] | None = None
) -> Detections:
    """Boxes as `Detections`, the most confident first; equal scores by place, so always alike.

    Parameters
    ----------
    box
        Left, top, width, height, px, shape (n, 4).
    score
        Shape (n,).
    label
        Shape (n,); None: of one kind.
    """
    x, y, w, h = box.T
    order = np.lexsort((h, w, y, x, -score))
    x, y, w, h = np.ascontiguousarray(box[order].T)
    return Detections(x, y, w, h, score[order], None if label is None else label[order])


def suppress(detections: Detections, overlap: float) -> Detections:
    """The detections without those whose IoU with a more confident one is above `overlap`.

    Boxes of different labels do not suppress each other.

    Parameters
    ----------
    overlap
        0: no two boxes that touch stay, 1: all stay.
    """
    return only(detections, staying(detections, overlap))


def staying(detections: Detections, overlap: float) -> NDArray[np.bool_]:
    """Which detections `suppress` leaves, bool, shape (n,)."""
    n = len(detections)
    is_open = np.ones(n, dtype=bool)
    if overlap >= 1 or n < 2:
        return is_open
    x, y = detections.x, detections.y
    right, bottom = x + detections.w, y + detections.h
    area = detections.w * detections.h
    label = np.zeros(n, dtype=np.int64)
    if detections.label is not None:
        label = np.unique(detections.label.astype(str), return_inverse=True)[1]
    for i in range(n):  # each depends on those before it; the boxes after it go at once
        if not is_open[i]:
            continue
        rest = i + 1 + np.flatnonzero(is_open[i + 1 :] & (label[i + 1 :] == label[i]))
        across = np.minimum(right[i], right[rest]) - np.maximum(x[i], x[rest])
        down = np.minimum(bottom[i], bottom[rest]) - np.maximum(y[i], y[rest])
        shared = np.maximum(across, 0) * np.maximum(down, 0)
        union = area[i] + area[rest] - shared
        is_open[rest[shared > overlap * union]] = False
    return is_open


def only(detections: Detections, is_kept: NDArray[np.bool_]) -> Detections:
    """The detections for which `is_kept` is true; bool, shape (n,)."""
    label = None if detections.label is None else detections.label[is_kept]
    x, y, w, h = (
        side[is_kept] for side in (detections.x, detections.y, detections.w, detections.h)
    )
    return Detections(x, y, w, h, detections.score[is_kept], label)
