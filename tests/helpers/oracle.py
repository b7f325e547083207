"""The specification of the metrics, word by word, with plain loops: slow, and easy to believe.

Shares no code with the library. A scene is a list of `Place` and three lists of `Box`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from statistics import median
from typing import Any

import numpy as np
from builders import Box, Place
from scipy.optimize import linear_sum_assignment

from nvcore.settings.params import Params


def centre(box: Box, W: float) -> float:
    return min(max(box.x + box.w / 2, 0), W)


def iou_and_shared(a: Box, b: Box) -> tuple[float, float]:
    across = min(a.x + a.w, b.x + b.w) - max(a.x, b.x)
    down = min(a.y + a.h, b.y + b.h) - max(a.y, b.y)
    shared = across * down if across > 0 and down > 0 else 0.0
    return shared / (a.w * a.h + b.w * b.h - shared), shared


def weight(box: Box, place: Place, params: Params) -> float:
    midpoint = 0.10 * place.height if params.midpoint is None else params.midpoint
    spread = 0.02 * place.height if params.spread is None else params.spread
    horizon = place.horizon if params.horizon is None else params.horizon
    if params.proximity == "none":
        return 1.0
    if params.proximity == "distance" and not math.isnan(box.distance_m):
        exponent = (box.distance_m - params.midpoint_m) / params.spread_m
    elif params.proximity == "horizon":
        exponent = -((box.y + box.h - horizon) - midpoint) / spread
    else:
        exponent = -(box.h - midpoint) / spread
    return 0.0 if exponent > 700 else 1 / (1 + math.exp(exponent))


def apart(a: Box, b: Box, place: Place, params: Params) -> float:
    lateral = abs(centre(a, place.width) - centre(b, place.width))
    if params.distance == "lateral":
        return lateral
    return math.hypot(lateral, (a.y + a.h) - (b.y + b.h))


def rho_of(place: Place, params: Params) -> float:
    if params.edge_weight is not None:
        return params.edge_weight
    return 0.0 if math.isnan(place.context) else place.context


def border_of(box: Box, place: Place, params: Params) -> float:
    W, rho = place.width, rho_of(place, params)
    c = centre(box, W)
    return rho * W / 2 + (1 - rho) * min(c, W - c)


def terms(
    A: Sequence[Box], B: Sequence[Box], partners: Sequence[Box | None], place: Place,
    params: Params,
) -> list[float]:  # fmt: skip
    """Each a's own term of D(A, B); `partners` has the match of each."""
    values = []
    for a, partner in zip(A, partners, strict=True):
        others = B if params.pairing == "nearest" else [partner] if partner is not None else []
        border = border_of(a, place, params)
        nearest = min([border, *(apart(a, b, place, params) for b in others)])
        values.append(weight(a, place, params) * nearest)
    return values


def maximin(
    A: Sequence[Box], values: Sequence[float], place: Place, params: Params
) -> tuple[float, Box | None]:
    """Equation 1 and the member of A at which it stands."""
    if not A:
        return 0.0, None
    most = max(values)
    best = [a for a, value in zip(A, values, strict=True) if value == most]
    best.sort(key=lambda a: (-weight(a, place, params), a.track))
    return most, best[0]


def match(
    G: Sequence[Box], D: Sequence[Box], place: Place, params: Params, threshold: float | None
) -> tuple[dict[int, int], list[int]]:
    """Detections of one frame: {detection: pedestrian}, and the false alarms, by position."""
    passing = [
        d for d in range(len(D))
        if threshold is None or math.isnan(D[d].score) or D[d].score >= threshold
    ]  # fmt: skip
    passing.sort(key=lambda d: -math.inf if math.isnan(D[d].score) else D[d].score, reverse=True)
    pairs: dict[int, int] = {}
    alarms = []
    for d in passing:
        candidates = []
        for g, pedestrian in enumerate(G):
            if pedestrian.ignore or g in pairs.values():
                continue
            if params.match_class == "same" and pedestrian.label not in (-1, D[d].label):
                continue
            if params.match == "iou":
                iou, _ = iou_and_shared(D[d], pedestrian)
                if iou >= params.iou and iou > 0:
                    candidates.append((-iou, g))
            else:
                gap = abs(centre(D[d], place.width) - centre(pedestrian, place.width))
                if gap <= max(params.lateral_tolerance * place.width, pedestrian.w / 2):
                    candidates.append((gap, g))
        if candidates:
            pairs[d] = min(candidates)[1]
        elif not any(
            region.ignore and iou_and_shared(D[d], region)[1] >= 0.5 * D[d].w * D[d].h
            for region in G
        ):
            alarms.append(d)
    return pairs, alarms


def link(frames_of_boxes: Sequence[Sequence[Box]]) -> list[list[int]]:
    """Track number of every box of one recording, frame by frame in order of listing."""
    tracks: list[tuple[int, Box]] = []  # position in the list, box, of each track's last box
    answer = []
    for position, boxes in enumerate(frames_of_boxes):
        live = [n for n, (seen, _) in enumerate(tracks) if position - seen <= 3]
        gain = np.zeros((len(live), len(boxes)))
        for i, n in enumerate(live):
            for j, box in enumerate(boxes):
                iou = iou_and_shared(tracks[n][1], box)[0]
                gain[i, j] = iou if iou >= 0.3 else 0
        numbers = [-1] * len(boxes)
        for i, j in zip(*linear_sum_assignment(gain, maximize=True), strict=True):
            if gain[i, j] > 0:
                numbers[j] = live[i]
        for j, box in enumerate(boxes):
            if numbers[j] < 0:
                numbers[j] = len(tracks)
                tracks.append((position, box))
            tracks[numbers[j]] = (position, box)
        answer.append(numbers)
    return answer


def steps(place: Place) -> list[float]:
    """Time step of every listed frame, seconds."""
    gaps = [b - a for a, b in zip(place.frames, place.frames[1:], strict=False)]
    return [gap / place.fps for gap in [*gaps, median(gaps) if gaps else 1]]


@dataclass
class Trace:
    """Everything about one system in one recording."""

    d_miss: list[float] = field(default_factory=list)
    d_false: list[float] = field(default_factory=list)
    similarity: list[float] = field(default_factory=list)
    salient: list[int] = field(default_factory=list)  # track, or -1
    worst_alarm: list[Box | None] = field(default_factory=list)  # at which D(S, G) stands
    n_det: list[int] = field(default_factory=list)
    matched: list[int] = field(default_factory=list)
    false_alarms: list[list[Box]] = field(default_factory=list)
    matched_boxes: list[list[bool]] = field(default_factory=list)  # of all truth boxes
    terms: list[dict[int, float]] = field(default_factory=list)  # by track, px
    events: list[tuple[int, int, int, float, float]] = field(default_factory=list)


def score(
    place: Place, truth: Sequence[Sequence[Box]], system: Sequence[Sequence[Box]],
    params: Params, threshold: float | None,
) -> Trace:  # fmt: skip
    """One system of one recording; `truth` and `system` by listed frame."""
    trace = Trace()
    for in_truth, detections in zip(truth, system, strict=True):
        G = [box for box in in_truth if not box.ignore]
        pairs, alarms = match(in_truth, detections, place, params, threshold)
        counted = sorted([*pairs, *alarms])
        S = [detections[d] for d in counted]
        seen_by = {g: detections[d] for d, g in pairs.items()}
        of_truth = [seen_by.get(g) for g, box in enumerate(in_truth) if not box.ignore]
        of_system = [in_truth[pairs[d]] if d in pairs else None for d in counted]
        own = terms(G, S, of_truth, place, params)
        d_miss, at = maximin(G, own, place, params)
        d_false, worst_alarm = maximin(S, terms(S, G, of_system, place, params), place, params)
        largest: dict[int, float] = {}
        for box, value in zip(G, own, strict=True):
            largest[box.track] = max(value, largest.get(box.track, 0.0))
        trace.terms.append(largest)
        effect = params.alpha * d_miss + (1 - params.alpha) * d_false
        trace.d_miss.append(d_miss)
        trace.d_false.append(d_false)
        trace.worst_alarm.append(worst_alarm)
        trace.similarity.append(1 - effect / (place.width / 2))
        qualifies = at is not None and d_miss > params.tolerance * place.width / 2
        trace.salient.append(at.track if at is not None and qualifies else -1)
        trace.n_det.append(len(S))
        trace.matched.append(len(pairs))
        trace.false_alarms.append([detections[d] for d in sorted(alarms)])
        trace.matched_boxes.append([g in pairs.values() for g in range(len(in_truth))])
    half = place.width / 2
    if params.saliency_of == "each":
        qualify = [
            {track: value / half for track, value in of_frame.items()
             if value > params.tolerance * half}
            for of_frame in trace.terms
        ]  # fmt: skip
    else:
        qualify = [
            {track: d / half} if track >= 0 else {}
            for track, d in zip(trace.salient, trace.d_miss, strict=True)
        ]
    for track in {track for of_frame in qualify for track in of_frame}:
        trace.events += events(place, truth, track, [q.get(track) for q in qualify], params)
    trace.events.sort(key=lambda event: (event[1], event[0]))
    return trace


def events(
    place: Place, truth: Sequence[Sequence[Box]], track: int, effect: list[float | None],
    params: Params,
) -> list[tuple[int, int, int, float, float]]:  # fmt: skip
    """Events of one pedestrian: track, position of first and last frame, duration, saliency."""
    step = steps(place)
    rows = []
    i = 0
    while i < len(effect):
        j = i
        while j + 1 < len(effect) and (effect[j + 1] is None) == (effect[i] is None):
            j += 1
        if effect[i] is not None:
            first, last = 0, len(effect) - 1
            if params.saliency_scope == "encounter":
                seen = [
                    p for p, boxes in enumerate(truth)
                    if any(b.track == track and not b.ignore for b in boxes)
                ]  # fmt: skip
                first, last = seen[0], seen[-1]
            if params.recency_unit == "seconds":
                rest = sum(step[j + 1 : last + 1])
                z = (params.recency_midpoint_s - rest) / params.recency_spread_s
            else:
                tau = sum(step[first : j + 1]) / sum(step[first : last + 1])
                z = (tau - params.recency_midpoint) / params.recency_spread
            recency = 1 / (1 + math.exp(-z))
            duration = weighs = sum(step[i : j + 1])
            if params.saliency_weight == "risk":
                weighs = sum((effect[p] or 0.0) * step[p] for p in range(i, j + 1))
            rows.append((track, i, j, duration, weighs * recency))
        i = j + 1
    return rows


def severity(
    place: Place, truth: Sequence[Sequence[Box]], trace: Trace, track: int, params: Params
) -> tuple[float, float]:
    """Severity of one encounter in seconds, and its peak cost."""
    total = peak = 0.0
    for p, (boxes, step) in enumerate(zip(truth, steps(place), strict=True)):
        relevant = [
            (weight(b, place, params) * border_of(b, place, params) / (place.width / 2), hit)
            for b, hit in zip(boxes, trace.matched_boxes[p], strict=True)
            if b.track == track and not b.ignore and weight(b, place, params) >= 0.5
        ]
        if relevant and not any(hit for _, hit in relevant):
            cost = max(cost for cost, _ in relevant)
            total, peak = total + cost * step, max(peak, cost)
    return total, peak


INTERVAL = ["first_row", "last_row", "duration_s", "depth_s", "min_similarity", "worst_row"]


def intervals(place: Place, similarity: list[float], low: float) -> list[tuple[float, ...]]:
    """Low-similarity intervals, as `INTERVAL` says; rows are positions of frames."""
    step = steps(place)
    runs: list[list[int]] = []
    for i, value in enumerate(similarity):
        if value < low:
            if runs and runs[-1][-1] == i - 1:
                runs[-1].append(i)
            else:
                runs.append([i])
    answer = []
    for run in runs:
        least = min(similarity[i] for i in run)
        severity = sum((low - similarity[i]) * step[i] for i in run)
        worst = next(i for i in run if similarity[i] == least)
        answer.append((run[0], run[-1], sum(step[i] for i in run), severity, least, worst))
    return answer


def within(place: Place, position: int, window: float) -> list[int]:
    """Positions of the frames at most half a window from one."""
    half = window / 2 * place.fps + 1e-6  # in frames; a frame exactly at the border counts
    return [
        p for p, frame in enumerate(place.frames) if abs(frame - place.frames[position]) <= half
    ]


def moving_mean(place: Place, values: list[float], window: float) -> list[float]:
    windows = [within(place, p, window) for p in range(len(values))]
    return [sum(values[p] for p in near) / len(near) for near in windows]


def encounters(
    place: Place, truth: Sequence[Sequence[Box]], trace: Trace, params: Params
) -> dict[int, dict[str, Any]]:
    """Figures of one system for every encounter of one recording, by track."""
    step = steps(place)
    answer = {}
    for track in sorted({b.track for boxes in truth for b in boxes if not b.ignore}):
        r = []  # position and whether matched, of the relevant frames
        peak = 0.0
        for p, boxes in enumerate(truth):
            rows = [
                (weight(b, place, params), hit)
                for b, hit in zip(boxes, trace.matched_boxes[p], strict=True)
                if b.track == track and not b.ignore
            ]
            peak = max([peak, *(k for k, _ in rows)])
            if any(k >= 0.5 for k, _ in rows):
                r.append((p, any(hit for k, hit in rows if k >= 0.5)))
        hits = [i for i, (_, hit) in enumerate(r) if hit]
        figures: dict[str, Any] = {"n_relevant": len(r), "matched": len(hits), "peak_k": peak}
        coverage = len(hits) / len(r) if r else math.nan
        lag = gap = tail = math.nan
        if hits:
            lag = (place.frames[r[hits[0]][0]] - place.frames[r[0][0]]) / place.fps
            gap = max(
                (sum(step[p] for p, _ in r[a + 1 : b]) for a, b in pairwise(hits)),
                default=0.0,
            )  # fmt: skip
            tail = sum(step[p] for p, _ in r[hits[-1] + 1 :])
        small = 1e-9  # sums of time steps that equal a limit do not exceed it
        if not r:
            kind = None
        elif not hits:
            kind = "never"
        elif lag > params.lag_s + small:
            kind = "late"
        elif gap > params.gap_s + small:
            kind = "dropout"
        elif tail > params.gap_s + small:
            kind = "lost_early"
        elif coverage < params.coverage:
            kind = "brief"
        else:
            kind = "none"
        detected = bool(hits) and coverage >= params.coverage
        answer[track] = figures | {
            "coverage": coverage, "is_detected": detected, "lag_s": lag, "gap_s": gap,
            "tail_s": tail, "miss_class": kind,
        }  # fmt: skip
    return answer


def pair(X: Sequence[Box], Y: Sequence[Box], iou: float) -> list[tuple[int, int]]:
    """Pairs of detections of one frame, greedily by descending IoU."""
    candidates = sorted(
        (-iou_and_shared(a, b)[0], i, j)
        for i, a in enumerate(X) for j, b in enumerate(Y)
        if iou_and_shared(a, b)[0] >= iou
    )  # fmt: skip
    pairs: list[tuple[int, int]] = []
    for _, i, j in candidates:
        if all(i != p and j != q for p, q in pairs):
            pairs.append((i, j))
    return pairs


def fuse(X: Sequence[Box], Y: Sequence[Box], iou: float) -> tuple[list[Box], list[Box]]:
    """`X or Y` and `X and Y` of one frame; X and Y hold what passes the thresholds."""
    pairs = pair(X, Y, iou)
    paired_x, paired_y = {i for i, _ in pairs}, {j for _, j in pairs}
    either = [*X, *(b for j, b in enumerate(Y) if j not in paired_y)]
    both = [b for i, b in enumerate(X) if i in paired_x]
    return (
        [b._replace(score=math.nan) for b in either],
        [b._replace(score=math.nan) for b in both],
    )
