"""Pairing of two systems' boxes, and detection of duplicate boxes."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled, intersection


@compiled
def best_free(a, i, b, in_b, start, stop, is_taken, min_iou):
    """Return the largest IoU of box i with a free B of its frame and the row of that B.

    Without any, they are 0 and -1. The frame's B are the rows ``start:stop``.
    """
    most, best = 0.0, -1
    for j in range(start, stop):
        if not in_b[j] or is_taken[j - start]:
            continue
        shared = intersection(a.x[i], a.y[i], a.w[i], a.h[i], b.x[j], b.y[j], b.w[j], b.h[j])
        if shared <= 0.0:
            continue
        iou = shared / (a.w[i] * a.h[i] + b.w[j] * b.h[j] - shared)
        if iou >= min_iou and iou > most:
            most, best = iou, j
    return most, best


@compiled
def pair_frames(lo, hi, a, in_a, b, in_b, min_iou, partner):
    """Pair the boxes of two systems greedily by descending IoU.

    Writes the row of each A's partner in B, or -1. Each A keeps its best free B and searches again
    only if that one is taken. Trying all pairs again after every pair would be cubic and take
    minutes for frames with hundreds of boxes.
    """
    is_taken = np.zeros(16, np.bool_)
    best, overlap = np.empty(16, np.int64), np.empty(16)
    for f in range(lo, hi):
        a0, a1 = a.offsets[f], a.offsets[f + 1]
        b0, b1 = b.offsets[f], b.offsets[f + 1]
        if b1 - b0 > is_taken.size:
            is_taken = np.zeros(2 * (b1 - b0), np.bool_)
        if a1 - a0 > best.size:
            best, overlap = np.empty(2 * (a1 - a0), np.int64), np.empty(2 * (a1 - a0))
        for j in range(b1 - b0):
            is_taken[j] = False
        for i in range(a0, a1):
            partner[i] = -1
            overlap[i - a0] = 0.0
            if in_a[i]:
                overlap[i - a0], best[i - a0] = best_free(a, i, b, in_b, b0, b1, is_taken, min_iou)
        while True:
            most, leader = 0.0, -1
            for i in range(a0, a1):
                if overlap[i - a0] > most:
                    most, leader = overlap[i - a0], i
            if leader < 0:
                break
            j, place = best[leader - a0], leader - a0
            if is_taken[j - b0]:
                overlap[place], best[place] = best_free(
                    a, leader, b, in_b, b0, b1, is_taken, min_iou
                )
                continue
            partner[leader] = j
            is_taken[j - b0] = True
            overlap[place] = 0.0


@compiled
def mark_repeats(lo, hi, boxes, is_repeat):
    """Mark boxes that are equal to an earlier one of the same frame."""
    x, y, w, h = boxes.x, boxes.y, boxes.w, boxes.h
    for f in range(lo, hi):
        for a in range(boxes.offsets[f] + 1, boxes.offsets[f + 1]):
            for b in range(boxes.offsets[f], a):
                if x[a] == x[b] and y[a] == y[b] and w[a] == w[b] and h[a] == h[b]:
                    is_repeat[a] = True
                    break
