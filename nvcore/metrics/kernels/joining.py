"""Loop over frames that finds the same boxes in two tables."""

from __future__ import annotations

from nvcore.metrics.kernels import compiled


@compiled
def join_frames(lo, hi, boxes, other_offsets, other, other_track, tolerance, row_of):
    """Find the box at the same place as each row of the other table, in the same frame.

    Rows of frame f in the other table are ``other_offsets[f]:other_offsets[f + 1]``, and `other`
    is their x, y, w and h. No coordinate may differ by more than
    `tolerance`. If both tracks are known (0 or more), they must be equal. Each box is taken once,
    by the first row that fits. Writes the row of the box, or -1, into `row_of`, which must hold -1
    throughout.
    """
    x, y, w, h = other
    track = boxes.track
    for f in range(lo, hi):
        first, last = boxes.offsets[f], boxes.offsets[f + 1]
        for j in range(other_offsets[f], other_offsets[f + 1]):
            for i in range(first, last):
                if abs(boxes.x[i] - x[j]) > tolerance or abs(boxes.y[i] - y[j]) > tolerance:
                    continue
                if abs(boxes.w[i] - w[j]) > tolerance or abs(boxes.h[i] - h[j]) > tolerance:
                    continue
                if track[i] >= 0 and other_track[j] >= 0 and track[i] != other_track[j]:
                    continue
                is_free = True
                for other in range(other_offsets[f], j):
                    is_free = is_free and row_of[other] != i
                if is_free:
                    row_of[j] = i
                    break
