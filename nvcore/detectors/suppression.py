"""Greedy suppression of boxes that overlap a more confident one; scores are kept."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import Detections
from nvcore.metrics.kernels import compiled, intersection

OverlapOf = Literal["union", "smaller"]
"""What an overlap is a share of: both boxes together, or the smaller one."""


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


def suppress(detections: Detections, overlap: float, overlap_of: OverlapOf = "union") -> Detections:
    """The detections without those that overlap a more confident one by more than `overlap`.

    Boxes of different labels do not suppress each other.

    Parameters
    ----------
    overlap
        0: no two boxes that share an area stay, 1: all stay.
    """
    return only(detections, staying(detections, overlap, overlap_of))


def staying(
    detections: Detections, overlap: float, overlap_of: OverlapOf = "union"
) -> NDArray[np.bool_]:
    """Which detections `suppress` leaves, bool, shape (n,)."""
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
    """Which boxes `suppress` leaves, bool, shape (n,).

    Parameters
    ----------
    box
        Left, top, width, height, the most confident first, shape (4, n).
    label
        Only boxes of one label suppress each other, shape (n,); None: all have one.
    """
    n = box.shape[1]
    stays = np.ones(n, dtype=np.bool_)
    if overlap < 1 and n > 1:  # from 1 on a rounding error would decide about doubles
        label = np.zeros(n, dtype=np.int64) if label is None else label.astype(np.int64)
        x, y, w, h = np.ascontiguousarray(box, dtype=np.float64)
        _mark(x, y, w, h, label, float(overlap), overlap_of == "smaller", stays)
    return stays


@compiled
def _mark(x, y, w, h, label, overlap, of_smaller, stays):  # type: ignore[no-untyped-def]
    """Mark the boxes that stay: each depends on those before it."""
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
    """The detections for which `is_kept` is true; bool, shape (n,)."""
    label = None if detections.label is None else detections.label[is_kept]
    x, y, w, h = (
        side[is_kept] for side in (detections.x, detections.y, detections.w, detections.h)
    )
    return Detections(x, y, w, h, detections.score[is_kept], label)
