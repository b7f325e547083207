"""Greedy non-maximum suppression. Scores are kept."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from nvcore.metrics.kernels import compiled, intersection
from nvcore.subjects.detectors.base import Detections

OverlapOf = Literal["union", "smaller"]
"""Reference area of an overlap: the union of both boxes, or the smaller box."""


def sorted_detections(
    box: NDArray[np.float64], score: NDArray[np.float64], label: NDArray[np.object_] | None = None
) -> Detections:
    """Return boxes as `Detections` in descending order of confidence. Ties are sorted by place.

    Parameters
    ----------
    box
        Left, top, width, height, px, shape (n, 4).
    score
        Shape (n,).
    label
        Shape (n,). None: one kind of object.
    """
    x, y, w, h = box.T
    order = np.lexsort((h, w, y, x, -score))
    x, y, w, h = np.ascontiguousarray(box[order].T)
    return Detections(x, y, w, h, score[order], None if label is None else label[order])


def suppress(detections: Detections, overlap: float, overlap_of: OverlapOf = "union") -> Detections:
    """Drop detections that overlap a more confident one by more than `overlap`.

    Boxes of different labels do not suppress each other.

    Parameters
    ----------
    overlap
        0 keeps no two boxes that share an area, 1 keeps all.
    """
    return only(detections, staying(detections, overlap, overlap_of))


def staying(
    detections: Detections, overlap: float, overlap_of: OverlapOf = "union"
) -> NDArray[np.bool_]:
    """Return a mask of the detections that `suppress` keeps, bool, shape (n,)."""
    box = np.stack([detections.x, detections.y, detections.w, detections.h])
    if detections.label is None:
        return staying_boxes(box, overlap, overlap_of)
    label = np.unique(detections.label.astype(str), return_inverse=True)[1]
    return staying_boxes(box, overlap, overlap_of, label=label)


def staying_boxes(
    box: NDArray[np.float64],
    overlap: float,
    overlap_of: OverlapOf = "union",
    *,
    label: NDArray[np.int64] | None = None,
) -> NDArray[np.bool_]:
    """Return a mask of the boxes that `suppress` keeps, bool, shape (n,).

    Parameters
    ----------
    box
        Left, top, width, height, in descending order of confidence, shape (4, n).
    label
        Only boxes with the same label suppress each other, shape (n,). None: one label.
    """
    n = box.shape[1]
    stays = np.ones(n, dtype=np.bool_)
    if overlap < 1 and n > 1:  # at 1, rounding errors would decide about duplicates
        label = np.zeros(n, dtype=np.int64) if label is None else label.astype(np.int64)
        x, y, w, h = np.ascontiguousarray(box, dtype=np.float64)
        _mark(x, y, w, h, label, float(overlap), overlap_of == "smaller", stays)
    return stays


@compiled
def _mark(x, y, w, h, label, overlap, of_smaller, stays):  # type: ignore[no-untyped-def]
    """Mark the boxes that stay. Each result depends on the boxes before it."""
    for i in range(x.size):
        for j in range(i):
            if not stays[j] or label[j] != label[i]:
                continue
            shared = intersection(x[i], y[i], w[i], h[i], x[j], y[j], w[j], h[j])
            a, b = w[i] * h[i], w[j] * h[j]
            whole = min(a, b) if of_smaller else a + b - shared
            if shared > overlap * whole:
                stays[i] = False
                break


def only(detections: Detections, is_kept: NDArray[np.bool_]) -> Detections:
    """Return the detections selected by a mask, bool, shape (n,)."""
    label = None if detections.label is None else detections.label[is_kept]
    x, y, w, h = (
        side[is_kept] for side in (detections.x, detections.y, detections.w, detections.h)
    )
    return Detections(x, y, w, h, detections.score[is_kept], label)
