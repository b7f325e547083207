"""Pairing of two systems' boxes, and detection of duplicate boxes."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled, intersection


@compiled
def best_free(x, y, w, h, b0, b1, bx, by, bw, bh, b_in, is_taken, min_iou):
    """Return a box's largest IoU with a free B of its frame and the row of that B, or 0 and -1."""
    most, best = 0.0, -1
    for b in range(b0, b1):
        if not b_in[b] or is_taken[b - b0]:
            continue
        shared = intersection(x, y, w, h, bx[b], by[b], bw[b], bh[b])
        if shared <= 0.0:
            continue
        iou = shared / (w * h + bw[b] * bh[b] - shared)
        if iou >= min_iou and iou > most:
            most, best = iou, b
    return most, best


@compiled
def pair_frames(
    lo, hi, a_offsets, ax, ay, aw, ah, a_in, b_offsets, bx, by, bw, bh, b_in, min_iou, partner
):
    """Pair the boxes of two systems greedily by descending IoU.

    Writes the row of each A's partner in B, or -1. Each A keeps its best free B and searches again
    only if that one is taken. Trying all pairs again after every pair would be cubic and take
    minutes for frames with hundreds of boxes.
    """
    is_taken = np.zeros(16, np.bool_)
    best, overlap = np.empty(16, np.int64), np.empty(16)
    for f in range(lo, hi):
        a0, a1 = a_offsets[f], a_offsets[f + 1]
        b0, b1 = b_offsets[f], b_offsets[f + 1]
        if b1 - b0 > is_taken.size:
            is_taken = np.zeros(2 * (b1 - b0), np.bool_)
        if a1 - a0 > best.size:
            best, overlap = np.empty(2 * (a1 - a0), np.int64), np.empty(2 * (a1 - a0))
        for b in range(b1 - b0):
            is_taken[b] = False
        for a in range(a0, a1):
            partner[a] = -1
            overlap[a - a0] = 0.0
            if a_in[a]:
                overlap[a - a0], best[a - a0] = best_free(
                    ax[a], ay[a], aw[a], ah[a], b0, b1, bx, by, bw, bh, b_in, is_taken, min_iou
                )
        while True:
            most, leader = 0.0, -1
            for a in range(a0, a1):
                if overlap[a - a0] > most:
                    most, leader = overlap[a - a0], a
            if leader < 0:
                break
            b = best[leader - a0]
            if is_taken[b - b0]:
                overlap[leader - a0], best[leader - a0] = best_free(
                    ax[leader],
                    ay[leader],
                    aw[leader],
                    ah[leader],
                    b0,
                    b1,
                    bx,
                    by,
                    bw,
                    bh,
                    b_in,
                    is_taken,
                    min_iou,
                )
                continue
            partner[leader] = b
            is_taken[b - b0] = True
            overlap[leader - a0] = 0.0


@compiled
def mark_repeats(lo, hi, offsets, x, y, w, h, is_repeat):
    """Mark boxes that are equal to an earlier one of the same frame."""
    for f in range(lo, hi):
        for a in range(offsets[f] + 1, offsets[f + 1]):
            for b in range(offsets[f], a):
                if x[a] == x[b] and y[a] == y[b] and w[a] == w[b] and h[a] == h[b]:
                    is_repeat[a] = True
                    break
