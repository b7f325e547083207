"""Loop over frames that finds the same boxes in two tables."""

from __future__ import annotations

from nvcore.metrics.kernels import compiled


@compiled
def join_frames(
    lo,
    hi,
    offsets,
    x,
    y,
    w,
    h,
    track,
    other_offsets,
    other_x,
    other_y,
    other_w,
    other_h,
    other_track,
    tolerance,
    row_of,
):
    """Find the box at the same place as each row of the other table, in the same frame.

    Rows of frame f are ``offsets[f]:offsets[f + 1]``. No coordinate may differ by more than
    `tolerance`. If both tracks are known (0 or more), they must be equal. Each box is taken once,
    by the first row that fits. Writes the row of the box, or -1, into `row_of`, which must hold -1
    throughout.
    """
    for f in range(lo, hi):
        first, last = offsets[f], offsets[f + 1]
        for j in range(other_offsets[f], other_offsets[f + 1]):
            for i in range(first, last):
                if abs(x[i] - other_x[j]) > tolerance or abs(y[i] - other_y[j]) > tolerance:
                    continue
                if abs(w[i] - other_w[j]) > tolerance or abs(h[i] - other_h[j]) > tolerance:
                    continue
                if track[i] >= 0 and other_track[j] >= 0 and track[i] != other_track[j]:
                    continue
                is_free = True
                for other in range(other_offsets[f], j):
                    is_free = is_free and row_of[other] != i
                if is_free:
                    row_of[j] = i
                    break
