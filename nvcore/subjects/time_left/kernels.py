"""Loops over the frames of encounters: time to contact, urgency, confirmation."""

from __future__ import annotations

import numpy as np

from nvcore.dataset.schema import EDGE_PX
from nvcore.metrics.kernels import compiled

LEAST_FRAMES = 5
"""Fewest frames for fitting a line to distances or inverse heights."""


@compiled
def contact_time(t, q, counts, start, stop, now):
    """Return the time to contact at `now` by the line through the counted frames ``start:stop``, s.

    Infinite if not closing, NaN with too few frames.
    """
    n, mean_t, mean_q = 0, 0.0, 0.0
    for j in range(start, stop):
        if counts[j]:
            n += 1
            mean_t += t[j] - now
            mean_q += q[j]
    if n < LEAST_FRAMES:
        return np.nan
    mean_t, mean_q = mean_t / n, mean_q / n
    spread, product, is_flat, first = 0.0, 0.0, True, np.nan
    for j in range(start, stop):
        if counts[j]:
            dt = t[j] - now - mean_t
            spread += dt * dt
            product += dt * (q[j] - mean_q)
            first = q[j] if np.isnan(first) else first
            is_flat = is_flat and q[j] == first
    if spread == 0.0:
        return np.nan
    slope = 0.0 if is_flat else product / spread
    if slope >= 0.0:
        return np.inf
    residuals = 0.0
    for j in range(start, stop):
        if counts[j]:
            rest = q[j] - mean_q - slope * (t[j] - now - mean_t)
            residuals += rest * rest
    if slope > -2.0 * np.sqrt(residuals / (n - 2) / spread):
        return np.inf
    return max(0.0, -(mean_q - slope * mean_t) / slope)


@compiled
def contact_frames(lo, hi, rows, recording, frames, boxes, window_s, is_judged, ttc):
    """Compute the time to contact of each truth row of the judged encounters, s.

    `rows` are `nvcore.metrics.kernels.encounters.EncounterArrays`. If a frame has several boxes of
    an encounter (a track id given twice), the nearest counts. The rows of other encounters are not
    changed.
    """
    order, frame_index, frame, fps = rows.order, rows.frame_index, frames.frame, frames.fps
    x, y, w, h, distance_m = boxes.x, boxes.y, boxes.w, boxes.h, boxes.distance_m
    for e in range(lo, hi):
        if not is_judged[e]:
            continue
        first, last = rows.offsets[e], rows.offsets[e + 1]
        has_distance = True
        for i in range(first, last):
            has_distance = has_distance and not np.isnan(distance_m[order[i]])
        r = recording[e]
        t, q = np.empty(last - first), np.empty(last - first)
        counts, start_of = np.empty(last - first, np.bool_), np.empty(last - first + 1, np.int64)
        n, i = 0, first
        while i < last:
            f = frame_index[i]
            start_of[n], t[n], q[n], counts[n] = i, frame[f] / fps[r], np.inf, False
            while i < last and frame_index[i] == f:
                k = order[i]
                is_inside = x[k] > EDGE_PX and x[k] + w[k] < frames.width[r] - EDGE_PX
                is_inside = (
                    is_inside and y[k] > EDGE_PX and y[k] + h[k] < frames.height[r] - EDGE_PX
                )
                nearness = distance_m[k] if has_distance else 1.0 / h[k]
                if is_inside and nearness < q[n]:
                    q[n], counts[n] = nearness, True
                i += 1
            n += 1
        start_of[n] = last
        reach = 0.5 * window_s * fps[r] * (1.0 + 1e-9)
        start, stop = 0, 0
        for j in range(n):
            now = frame[frame_index[start_of[j]]]
            while now - frame[frame_index[start_of[start]]] > reach:
                start += 1
            while stop < n and frame[frame_index[start_of[stop]]] - now <= reach:
                stop += 1
            at = contact_time(t, q, counts, start, stop, t[j])
            for i in range(start_of[j], start_of[j + 1]):
                ttc[order[i]] = at


@compiled
def urgent_frames(lo, hi, rows, ttc, needed, least, known, urgent):
    """Find every encounter's least time to contact, and where it is first known and first urgent.

    Writes seconds (NaN: never known) and positions in `order` (-1: nowhere). `needed` is indexed by
    frame row.
    """
    for e in range(lo, hi):
        least[e], known[e], urgent[e] = np.nan, -1, -1
        for i in range(rows.offsets[e], rows.offsets[e + 1]):
            at = ttc[rows.order[i]]
            if np.isnan(at):
                continue
            if known[e] < 0:
                known[e], least[e] = i, at
            least[e] = min(least[e], at)
            if urgent[e] < 0 and at < needed[rows.frame_index[i]]:
                urgent[e] = i


@compiled
def confirmed_frames(lo, hi, rows, matched, ttc, n, m, confirmed, ttc_at):
    """Find where `n` of the last `m` frames of each encounter are matched for the first time.

    Writes the frame row (-1: never) and the last known time to contact until then (NaN: none).
    """
    order, frame_index = rows.order, rows.frame_index
    for e in range(lo, hi):
        confirmed[e], ttc_at[e] = -1, np.nan
        first, last = rows.offsets[e], rows.offsets[e + 1]
        is_match = np.empty(last - first, np.bool_)
        n_frames, n_matched, i = 0, 0, first
        while i < last:
            f, is_match[n_frames] = frame_index[i], False
            while i < last and frame_index[i] == f:
                is_match[n_frames] = is_match[n_frames] or matched[order[i]]
                if not np.isnan(ttc[order[i]]):
                    ttc_at[e] = ttc[order[i]]
                i += 1
            n_matched += is_match[n_frames]
            if n_frames >= m:
                n_matched -= is_match[n_frames - m]
            n_frames += 1
            if n_matched >= n:
                confirmed[e] = f
                break
        if confirmed[e] < 0:
            ttc_at[e] = np.nan
