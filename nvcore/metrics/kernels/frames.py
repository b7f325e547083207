"""Loops over the boxes of frames: matching, distances between sets, cost of a miss."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from nvcore.dataset.schema import DetectionState
from nvcore.metrics.kernels import ABSORB_SHARE, border, centre, compiled, intersection


class MatchRule(NamedTuple):
    """Rule by which a detection matches a pedestrian.

    Attributes
    ----------
    threshold
        Least score of a detection.
    lateral
        Whether sideways position decides, by `tolerance`, in place of overlap, by `min_iou`.
    same_label
        Whether classes have to agree where the truth has one.
    """

    threshold: float
    lateral: bool
    min_iou: float
    tolerance: float
    same_label: bool


@compiled
def match_frames(lo, hi, truth, detections, rule, frames, state, det_truth, truth_det):
    """Match detections to pedestrians, frame by frame, best score first.

    Writes `state` (`DetectionState`, int8) and `det_truth` (row of the matched pedestrian or -1)
    of every detection and `truth_det` (row of the detection or -1) of every pedestrian. A missing
    score passes every threshold and comes after all others.
    """
    gx, gy, gw, gh = truth.x, truth.y, truth.w, truth.h
    dx, dy, dw, dh = detections.x, detections.y, detections.w, detections.h
    score = detections.score
    order = np.empty(16, np.int64)
    for f in range(lo, hi):
        d0, d1 = detections.offsets[f], detections.offsets[f + 1]
        g0, g1 = truth.offsets[f], truth.offsets[f + 1]
        if d1 - d0 > order.size:
            order = np.empty(2 * (d1 - d0), np.int64)
        n = 0
        for d in range(d0, d1):
            det_truth[d] = -1
            if score[d] < rule.threshold:
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
        W = frames.width[frames.recording[f]]
        for i in range(n):
            d = order[i]
            best = -1
            if rule.lateral:
                c = centre(dx[d], dw[d], W)
                least = np.inf
                for g in range(g0, g1):
                    if truth.ignore[g] or truth_det[g] >= 0:
                        continue
                    if rule.same_label and -1 < truth.label[g] != detections.label[d]:
                        continue
                    apart = abs(c - centre(gx[g], gw[g], W))
                    if apart <= max(rule.tolerance * W, 0.5 * gw[g]) and apart < least:
                        least, best = apart, g
            else:
                area = dw[d] * dh[d]
                most = 0.0
                for g in range(g0, g1):
                    if truth.ignore[g] or truth_det[g] >= 0:
                        continue
                    if rule.same_label and -1 < truth.label[g] != detections.label[d]:
                        continue
                    shared = intersection(dx[d], dy[d], dw[d], dh[d], gx[g], gy[g], gw[g], gh[g])
                    if shared <= 0.0:
                        continue
                    iou = shared / (area + gw[g] * gh[g] - shared)
                    if iou >= rule.min_iou and iou > most:
                        most, best = iou, g
            if best >= 0:
                state[d] = DetectionState.MATCHED
                det_truth[d] = best
                truth_det[best] = d
                continue
            area = dw[d] * dh[d]
            for g in range(g0, g1):
                if truth.ignore[g]:
                    shared = intersection(dx[d], dy[d], dw[d], dh[d], gx[g], gy[g], gw[g], gh[g])
                    if shared > 0.0 and shared >= ABSORB_SHARE * area:
                        state[d] = DetectionState.ABSORBED
                        break


@compiled
def nearest_frames(lo, hi, a, in_a, b, in_b, ground, frames, near_a, near_b):
    """Compute each box's distance to the nearest box of the other set, frame by frame, px.

    The distance is lateral, or between foot points if `ground`, and infinite if the other set is
    empty.
    """
    for f in range(lo, hi):
        W = frames.width[frames.recording[f]]
        for j in range(b.offsets[f], b.offsets[f + 1]):
            near_b[j] = np.inf
        for i in range(a.offsets[f], a.offsets[f + 1]):
            near_a[i] = np.inf
            if not in_a[i]:
                continue
            c = centre(a.x[i], a.w[i], W)
            foot = a.y[i] + a.h[i]
            for j in range(b.offsets[f], b.offsets[f + 1]):
                if not in_b[j]:
                    continue
                apart = abs(c - centre(b.x[j], b.w[j], W))
                if ground:
                    apart = math.hypot(apart, foot - (b.y[j] + b.h[j]))
                if apart < near_a[i]:
                    near_a[i] = apart
                if apart < near_b[j]:
                    near_b[j] = apart


@compiled
def maximin_frames(lo, hi, boxes, member, k, near, track, edge_weight, frames, d, argmax):
    """Compute the weighted MaxiMin distance D(A, B) of every frame and A's row that attains it.

    Ties go to the larger weight, then to the smaller track id. An empty A gives 0 and -1.
    """
    for f in range(lo, hi):
        W, rho = frames.width[frames.recording[f]], edge_weight[frames.recording[f]]
        most, best = 0.0, -1
        for i in range(boxes.offsets[f], boxes.offsets[f + 1]):
            if not member[i]:
                continue
            c = centre(boxes.x[i], boxes.w[i], W)
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
def maximum_frames(lo, hi, boxes, member, k, near, edge_weight, frames, d):
    """Compute D(A, B) like `maximin_frames`, but without the row.

    A plain maximum needs no branch and takes a third of the time.
    """
    for f in range(lo, hi):
        W, rho = frames.width[frames.recording[f]], edge_weight[frames.recording[f]]
        most = 0.0
        for i in range(boxes.offsets[f], boxes.offsets[f + 1]):
            c = centre(boxes.x[i], boxes.w[i], W)
            most = max(most, k[i] * min(border(c, W, rho), near[i]) if member[i] else 0.0)
        d[f] = most


@compiled
def cost_frames(lo, hi, boxes, k, edge_weight, frames, cost):
    """Compute the cost of missing each box: its weight times its border over half the width."""
    for f in range(lo, hi):
        W, rho = frames.width[frames.recording[f]], edge_weight[frames.recording[f]]
        for i in range(boxes.offsets[f], boxes.offsets[f + 1]):
            c = centre(boxes.x[i], boxes.w[i], W)
            cost[i] = k[i] * border(c, W, rho) / (0.5 * W)
