"""Loops over the boxes of frames: matching, distances between sets, cost of a miss."""

from __future__ import annotations

import math

import numpy as np

from nvcore.dataset.schema import DetectionState
from nvcore.metrics.kernels import ABSORB_SHARE, border, centre, compiled, intersection


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
    g_label,
    d_label,
    same_label,
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
                    if same_label and g_label[g] >= 0 and g_label[g] != d_label[d]:
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
                    if same_label and g_label[g] >= 0 and g_label[g] != d_label[d]:
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
    """Compute each box's distance to the nearest box of the other set, frame by frame, px.

    The distance is lateral, or between foot points if `ground`, and infinite if the other set is
    empty.
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
    """Compute the weighted MaxiMin distance D(A, B) of every frame and A's row that attains it.

    Ties go to the larger weight, then to the smaller track id. An empty A gives 0 and -1.
    """
    for f in range(lo, hi):
        W, rho = width[recording[f]], edge_weight[recording[f]]
        most, best = 0.0, -1
        for i in range(offsets[f], offsets[f + 1]):
            if not member[i]:
                continue
            c = centre(x[i], w[i], W)
            value = k[i] * min(border(c, W, rho), near[i])
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
    """Compute D(A, B) like `maximin_frames`, but without the row.

    A plain maximum needs no branch and takes a third of the time.
    """
    for f in range(lo, hi):
        W, rho = width[recording[f]], edge_weight[recording[f]]
        most = 0.0
        for i in range(offsets[f], offsets[f + 1]):
            c = centre(x[i], w[i], W)
            most = max(most, k[i] * min(border(c, W, rho), near[i]) if member[i] else 0.0)
        d[f] = most


@compiled
def cost_frames(lo, hi, offsets, x, w, k, edge_weight, recording, width, cost):
    """Compute the cost of missing each box: its weight times its border over half the width."""
    for f in range(lo, hi):
        W, rho = width[recording[f]], edge_weight[recording[f]]
        for i in range(offsets[f], offsets[f + 1]):
            c = centre(x[i], w[i], W)
            cost[i] = k[i] * border(c, W, rho) / (0.5 * W)
