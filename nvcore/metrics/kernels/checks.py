"""Loops of the audit that measure the overlap of the truth with shifted or scaled detections."""

from __future__ import annotations

from nvcore.metrics.kernels import compiled


@compiled
def best_overlaps(frame, truth, lo, hi, detections, scale, offset, best, which):
    """Find the best IoU of any detection with each truth box, and that detection's row.

    Without any, they are 0 and -1. Box g is in frame ``frame[g]``, whose detections are the rows
    ``lo`` to ``hi`` of that frame. Boxes are x, y, w and h. Detections are scaled, then shifted.
    Of equal overlaps the last one counts.
    """
    gx, gy, gw, gh = truth
    x, y, w, h = detections
    (sx, sy), (ox, oy) = scale, offset
    for g in range(frame.size):
        best[g], which[g] = 0.0, -1
        g_right, g_bottom = gx[g] + gw[g], gy[g] + gh[g]
        for d in range(lo[frame[g]], hi[frame[g]]):
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
                best[g], which[g] = iou, d
