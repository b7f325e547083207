"""The compiled loops over frames, boxes and encounters.

All kernels work on columns sorted by frame, with ``offsets[f]:offsets[f + 1]`` the rows of frame
f, and write into arrays that the caller made. They take a range of frames (``lo``, ``hi``) and
release the interpreter lock, so that `over_ranges` can run them in threads; that avoids numba's
own parallel mode, which takes seconds to compile. Sets are small (a handful of boxes a frame), so
all pairs are tried: below about 48 boxes a side that beats sorting.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Final

import numpy as np
from numba import njit

from nvcore.schema import DetectionState

ABSORB_SHARE: Final = 0.5
"""Share of a detection's own area inside an ignore region that makes it count for nothing."""

compiled = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True)
"""Compile on first use, keep the machine code on disk, run without the interpreter lock."""

MIN_PER_THREAD: Final = 20_000
"""Smallest number of frames that is worth a thread of its own."""


def over_ranges(kernel: Callable[..., Any], n: int, *arguments: Any) -> list[Any]:
    """Run ``kernel(lo, hi, *arguments)`` over 0..n in as many threads as there are cores."""
    n_threads = min(os.cpu_count() or 1, n // MIN_PER_THREAD)
    if n_threads < 2:
        return [kernel(0, n, *arguments)]
    edges = np.linspace(0, n, n_threads + 1).astype(np.int64)
    with ThreadPoolExecutor(n_threads) as pool:
        jobs = [pool.submit(kernel, int(lo), int(hi), *arguments) for lo, hi in pairwise(edges)]
        return [job.result() for job in jobs]


@compiled
def centre(x: float, w: float, width: float) -> float:
    """Lateral position of a box: its centre, clipped to the picture."""
    return min(max(x + 0.5 * w, 0.0), width)


@compiled
def intersection(
    ax: float, ay: float, aw: float, ah: float, bx: float, by: float, bw: float, bh: float
) -> float:
    """Area that two boxes share, continuous pixels; 0 where they do not touch."""
    across = min(ax + aw, bx + bw) - max(ax, bx)
    down = min(ay + ah, by + bh) - max(ay, by)
    if across <= 0.0 or down <= 0.0:
        return 0.0
    return across * down


@compiled
def match_frames(
    lo,
    hi,
    g_offsets,
    gx,
    gy,
    gw,
    gh,
    g_ignore,
    d_offsets,
    dx,
    dy,
    dw,
    dh,
    score,
    threshold,
    min_iou,
    lateral,
    tolerance,
    recording,
    width,
    state,
    det_truth,
    truth_det,
):
    """Match detections to pedestrians, frame by frame, best score first.

    Writes `state` (`DetectionState`, int8) and `det_truth` (row of the matched pedestrian or -1)
    of every detection and `truth_det` (row of the detection or -1) of every pedestrian. A missing
    score passes every threshold and comes after all others.
    """
    order = np.empty(16, np.int64)
    for f in range(lo, hi):
        d0, d1 = d_offsets[f], d_offsets[f + 1]
        g0, g1 = g_offsets[f], g_offsets[f + 1]
        if d1 - d0 > order.size:
            order = np.empty(2 * (d1 - d0), np.int64)
        n = 0
        for d in range(d0, d1):
            det_truth[d] = -1
            if score[d] < threshold:
                state[d] = DetectionState.BELOW
                continue
            state[d] = DetectionState.FALSE_ALARM
            rank = -np.inf if np.isnan(score[d]) else score[d]
            slot = n  # insertion sort: file order among equals
            while slot > 0:
                before = score[order[slot - 1]]
                if rank <= before or (np.isnan(before) and rank == -np.inf):
                    break
                order[slot] = order[slot - 1]
                slot -= 1
            order[slot] = d
            n += 1
        for g in range(g0, g1):
            truth_det[g] = -1
        W = width[recording[f]]
        for i in range(n):
            d = order[i]
            best = -1
            if lateral:
                c = centre(dx[d], dw[d], W)
                least = np.inf
                for g in range(g0, g1):
                    if g_ignore[g] or truth_det[g] >= 0:
                        continue
                    apart = abs(c - centre(gx[g], gw[g], W))
                    if apart <= max(tolerance * W, 0.5 * gw[g]) and apart < least:
                        least, best = apart, g
            else:
                area = dw[d] * dh[d]
                most = 0.0
                for g in range(g0, g1):
                    if g_ignore[g] or truth_det[g] >= 0:
                        continue
                    shared = intersection(dx[d], dy[d], dw[d], dh[d], gx[g], gy[g], gw[g], gh[g])
                    if shared <= 0.0:
                        continue
                    iou = shared / (area + gw[g] * gh[g] - shared)
                    if iou >= min_iou and iou > most:
                        most, best = iou, g
            if best >= 0:
                state[d] = DetectionState.MATCHED
                det_truth[d] = best
                truth_det[best] = d
                continue
            area = dw[d] * dh[d]
            for g in range(g0, g1):
                if g_ignore[g]:
                    shared = intersection(dx[d], dy[d], dw[d], dh[d], gx[g], gy[g], gw[g], gh[g])
                    if shared > 0.0 and shared >= ABSORB_SHARE * area:
                        state[d] = DetectionState.ABSORBED
                        break


@compiled
def nearest_frames(
    lo,
    hi,
    a_offsets,
    ax,
    ay,
    aw,
    ah,
    a_in,
    b_offsets,
    bx,
    by,
    bw,
    bh,
    b_in,
    ground,
    recording,
    width,
    near_a,
    near_b,
):
    """Distance of each member of A to its nearest member of B and back, frame by frame, px.

    Lateral, or between foot points if `ground`. Infinite where the other set is empty.
    """
    for f in range(lo, hi):
        a0, a1 = a_offsets[f], a_offsets[f + 1]
        b0, b1 = b_offsets[f], b_offsets[f + 1]
        W = width[recording[f]]
        for b in range(b0, b1):
            near_b[b] = np.inf
        for a in range(a0, a1):
            near_a[a] = np.inf
            if not a_in[a]:
                continue
            c = centre(ax[a], aw[a], W)
            foot = ay[a] + ah[a]
            for b in range(b0, b1):
                if not b_in[b]:
                    continue
                apart = abs(c - centre(bx[b], bw[b], W))
                if ground:
                    apart = math.hypot(apart, foot - (by[b] + bh[b]))
                if apart < near_a[a]:
                    near_a[a] = apart
                if apart < near_b[b]:
                    near_b[b] = apart


@compiled
def maximin_frames(
    lo, hi, offsets, x, w, k, near, member, track, edge_weight, recording, width, d, argmax
):
    """Weighted MaxiMin distance D(A, B) of every frame and the row of A that attains it.

    Ties go to the larger weight, then to the smaller track id. An empty A gives 0 and -1.
    """
    for f in range(lo, hi):
        W, rho = width[recording[f]], edge_weight[recording[f]]
        most, best = 0.0, -1
        for i in range(offsets[f], offsets[f + 1]):
            if not member[i]:
                continue
            c = centre(x[i], w[i], W)
            border = rho * 0.5 * W + (1.0 - rho) * min(c, W - c)
            value = k[i] * min(border, near[i])
            if (
                best < 0
                or value > most
                or (
                    value == most
                    and (k[i] > k[best] or (k[i] == k[best] and track[i] < track[best]))
                )
            ):
                most, best = value, i
        d[f] = most
        argmax[f] = best


@compiled
def maximum_frames(lo, hi, offsets, x, w, k, near, member, edge_weight, recording, width, d):
    """As `maximin_frames`, without the row: a bare maximum needs no branch, a third of the time."""
    for f in range(lo, hi):
        W, rho = width[recording[f]], edge_weight[recording[f]]
        most = 0.0
        for i in range(offsets[f], offsets[f + 1]):
            c = centre(x[i], w[i], W)
            border = rho * 0.5 * W + (1.0 - rho) * min(c, W - c)
            most = max(most, k[i] * min(border, near[i]) if member[i] else 0.0)
        d[f] = most


@compiled
def cost_frames(lo, hi, offsets, x, w, k, edge_weight, recording, width, cost):
    """What missing each box would cost: its weight times its border over half the width."""
    for f in range(lo, hi):
        W, rho = width[recording[f]], edge_weight[recording[f]]
        for i in range(offsets[f], offsets[f + 1]):
            c = centre(x[i], w[i], W)
            cost[i] = k[i] * (rho * 0.5 * W + (1.0 - rho) * min(c, W - c)) / (0.5 * W)


@compiled
def encounter_frames(
    lo,
    hi,
    offsets,
    order,
    frame_index,
    frame,
    gap,
    k,
    matched,
    n_relevant,
    n_matched,
    peak_k,
    lag,
    longest_gap,
    tail,
):
    """Measures of one system for every encounter; lag, gap and tail in frames.

    ``order[offsets[e]:offsets[e + 1]]`` are the truth rows of encounter e by frame, and
    `frame_index` has the frames of these rows in the same order. Rows of one
    frame (a track id given twice) count as one. Never matched: lag, gap and tail are NaN.
    """
    for e in range(lo, hi):
        n_rel, n_hit = 0, 0
        peak = 0.0
        first_relevant = -1
        run, longest, delay = 0.0, 0.0, np.nan
        i, stop = offsets[e], offsets[e + 1]
        while i < stop:
            f = frame_index[i]
            is_relevant, is_matched = False, False
            while i < stop and frame_index[i] == f:
                row = order[i]
                peak = max(peak, k[row])
                if k[row] >= 0.5:
                    is_relevant = True
                    is_matched = is_matched or matched[row]
                i += 1
            if not is_relevant:
                continue
            n_rel += 1
            if first_relevant < 0:
                first_relevant = f
            if is_matched:
                if n_hit == 0:
                    delay = float(frame[f] - frame[first_relevant])
                else:
                    longest = max(longest, run)
                n_hit += 1
                run = 0.0
            else:
                run += gap[f]
        n_relevant[e], n_matched[e], peak_k[e] = n_rel, n_hit, peak
        lag[e] = delay
        longest_gap[e] = longest if n_hit else np.nan
        tail[e] = run if n_hit else np.nan


@compiled
def severity_frames(offsets, encounter_of, gap, k, cost, matched, severity, worst, worst_frame):
    """What each encounter's missed relevant frames cost one system, in frames.

    Writes the sum of cost and time step, the largest cost and its first frame row (-1: nothing was
    missed); `severity` and `worst` are 0 before. All frames in one pass, in order of memory: an
    encounter's frame is added when its next one comes, since a track id may be given twice in a
    frame. Of the boxes of one frame the largest cost counts.
    """
    n = severity.size
    frame, lost = np.full(n, -1, np.int64), np.zeros(n)
    for e in range(n):
        worst_frame[e] = -1
    for f in range(offsets.size - 1):
        for i in range(offsets[f], offsets[f + 1]):
            e = encounter_of[i]
            if e < 0 or k[i] < 0.5:
                continue
            paid = -1.0 if matched[i] else cost[i]  # -1: matched by one of the boxes
            if frame[e] == f:
                lost[e] = -1.0 if min(paid, lost[e]) < 0.0 else max(paid, lost[e])
                continue
            if lost[e] > 0.0:
                severity[e] += lost[e] * gap[frame[e]]
                if lost[e] > worst[e]:
                    worst[e], worst_frame[e] = lost[e], frame[e]
            frame[e], lost[e] = f, paid
    for e in range(n):
        if lost[e] > 0.0:
            severity[e] += lost[e] * gap[frame[e]]
            if lost[e] > worst[e]:
                worst[e], worst_frame[e] = lost[e], frame[e]


@compiled
def group_rows(code, counts):
    """Rows in the order of their group, the order inside a group kept (a counting sort)."""
    position = np.zeros(counts.size + 1, np.int64)
    for g in range(counts.size):
        position[g + 1] = position[g] + counts[g]
    order = np.empty(code.size, np.int64)
    for i in range(code.size):
        if code[i] >= 0:
            order[position[code[i]]] = i
            position[code[i]] += 1
    return order


@compiled
def best_free(x, y, w, h, b0, b1, bx, by, bw, bh, b_in, is_taken, min_iou):
    """Largest IoU of a box with a free B of its frame, and that B's row; 0 and -1 for none."""
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
    """Pair the boxes of two systems, greedily by descending IoU; writes each A's B row or -1.

    Each A keeps its best free B and looks again only when that is taken: trying all pairs
    again after every pair would be cubic, minutes for frames of hundreds of boxes.
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
