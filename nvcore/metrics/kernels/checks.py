"""Loops of the audit: how well the truth is overlapped by detections that were moved."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled


@compiled
def frame_at(f, number, frame, lo, hi):
    """Row of a frame number among rows lo..hi of a recording, -1 if it has no such frame.

    Looked for from row f on, since most often all frame numbers are listed.
    """
    row = f + (number - frame[f])
    if lo <= row < hi and frame[row] == number:
        return row
    stop = hi
    while lo < stop:
        row = (lo + stop) // 2
        if frame[row] < number:
            lo = row + 1
        else:
            stop = row
    return lo if lo < hi and frame[lo] == number else -1


@compiled
def best_overlaps(
    frame_index,
    gx,
    gy,
    gw,
    gh,
    recording,
    frame,
    first,
    offsets,
    x,
    y,
    w,
    h,
    sx,
    sy,
    ox,
    oy,
    later,
    best,
    dx,
    dy,
    ratio_w,
    ratio_h,
    has_frame,
):
    """Best detection of each of some pedestrians after a correction of the detections.

    Writes the columns of `nvcore.auditing.overlaps.Overlaps`. The detections are scaled by sx and
    sy, then moved by ox and oy; they are taken from the frame `later` frame numbers after the
    pedestrian's own. Of equal overlaps the last one counts.
    """
    for g in range(frame_index.size):
        f = frame_index[g]
        if later != 0:
            r = recording[f]
            f = frame_at(f, frame[f] + later, frame, first[r], first[r + 1])
        best[g] = 0.0
        dx[g] = dy[g] = ratio_w[g] = ratio_h[g] = np.nan
        has_frame[g] = f >= 0
        if f < 0:
            continue
        g_right, g_bottom = gx[g] + gw[g], gy[g] + gh[g]
        for d in range(offsets[f], offsets[f + 1]):
            left = x[d] * sx + ox
            if left >= g_right:
                continue
            width = w[d] * sx
            across = min(g_right, left + width) - max(gx[g], left)
            if across <= 0.0:
                continue
            top, height = y[d] * sy + oy, h[d] * sy
            down = min(g_bottom, top + height) - max(gy[g], top)
            if down <= 0.0:
                continue
            shared = across * down
            iou = shared / (gw[g] * gh[g] + width * height - shared)
            if iou > 0.0 and iou >= best[g]:
                best[g] = iou
                dx[g] = gx[g] + gw[g] / 2 - left - width / 2
                dy[g] = gy[g] + gh[g] / 2 - top - height / 2
                ratio_w[g] = gw[g] / width
                ratio_h[g] = gh[g] / height
