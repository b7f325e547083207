"""Compiled loop that links boxes over frames by optimal assignment.

It uses plain loops instead of slices and ``np.full``, which would drag numba's string formatting
(for error messages) into the compilation and take seconds.
"""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled, intersection

MOST_UNSORTED = 24
"""Most boxes per frame for which every box is compared with every track without sorting first."""
N_BUCKETS = 64
"""Number of buckets into which the boxes of a frame are sorted by their left edges."""


@compiled
def assign(n, m, first, col, gain):
    """Assign rows to columns with the largest total gain, using only the listed pairs.

    Shortest augmenting paths with potentials (Jonker and Volgenant 1987; the method of
    ``scipy.optimize.linear_sum_assignment``, which compiled code cannot call), limited to the
    existing pairs. The time per row depends only on the pairs in its connected group.

    Parameters
    ----------
    n, m
        Numbers of rows and of columns.
    first
        The pairs of row i are ``first[i]:first[i + 1]``; int64, shape (n + 1,).
    col, gain
        Column and gain (more than 0) of each pair.

    Returns
    -------
    int64, shape (n,): column of each row, or -1.
    """
    column, owner = np.empty(n, np.int64), np.empty(m, np.int64)  # -1: none
    row_price, column_price = np.zeros(n), np.zeros(m)
    least, way = np.empty(m), np.empty(m, np.int64)  # of the paths to columns, and their last row
    state = np.zeros(m, np.int64)  # 0 not reached, 1 reached, 2 passed
    reached, passed = np.empty(m, np.int64), np.empty(m, np.int64)
    for j in range(m):
        owner[j] = -1
    for root in range(n):
        column[root] = -1
        if first[root] == first[root + 1]:
            continue
        n_reached, n_passed = 0, 0
        i, length = root, 0.0
        shortest, last, free = np.inf, root, -1  # path that leaves row `last` without a column
        while True:
            if length - row_price[i] < shortest:
                shortest, last = length - row_price[i], i
            for e in range(first[i], first[i + 1]):
                j = col[e]
                if state[j] == 2:
                    continue
                cost = length - gain[e] - row_price[i] - column_price[j]
                if state[j] == 0:
                    state[j], least[j] = 1, np.inf
                    reached[n_reached] = j
                    n_reached += 1
                if cost < least[j]:
                    least[j], way[j] = cost, i
            best = -1
            for k in range(n_reached):
                j = reached[k]
                if state[j] == 1 and (
                    best < 0 or least[j] < least[best] or (least[j] == least[best] and j < best)
                ):
                    best = j
            if best < 0 or least[best] >= shortest:
                break
            if owner[best] < 0:
                shortest, free = least[best], best
                break
            state[best] = 2
            passed[n_passed] = best
            n_passed += 1
            i, length = owner[best], least[best]
        row_price[root] += shortest
        for k in range(n_passed):
            j = passed[k]
            row_price[owner[j]] += shortest - least[j]
            column_price[j] -= shortest - least[j]
        for k in range(n_reached):
            state[reached[k]] = 0
        if free < 0:
            free, column[last] = column[last], -1
        while free >= 0:  # each row of the path takes the column after it
            i = way[free]
            owner[free], column[i], free = i, free, column[i]
    return column


@compiled
def bucket_of(value, low, per_bucket):
    """Return the bucket of a left edge. Edges out of range go into the outermost buckets."""
    return int(min(max((value - low) / per_bucket, 0.0), N_BUCKETS - 1.0))


@compiled
def grown(values, n):
    """Return a copy of the array with room for `n` values. The added ones are uninitialised."""
    copy = np.empty(n, values.dtype)
    for k in range(values.size):
        copy[k] = values[k]
    return copy


@compiled
def link_rows(rows, boxes, recording, min_iou, max_gap, track):
    """Number the track of every row, counting from 0 over all recordings.

    Boxes of successive listed frames are assigned to the tracks seen at most `max_gap` listed
    frames before, by the largest total IoU over pairs with ``IoU >= min_iou``. A box without a
    track starts a new one.

    Parameters
    ----------
    rows
        Rows of the box columns to link, sorted by frame, int64, shape (n,).
    boxes
        `nvcore.dataset.columns.BoxArrays`.
    recording
        Recording of each frame.
    min_iou
        More than 0, at most 1.
    track
        int64, shape (n,); written.

    Returns
    -------
    Number of tracks.
    """
    frame_index, x, y, w, h = boxes.frame_index, boxes.x, boxes.y, boxes.w, boxes.h
    n_tracks = 0
    live = np.empty(16, np.int64)  # positions (into rows) of each live track's last box
    n_live = 0
    # of a frame's boxes
    order, near = np.empty(16, np.int64), np.empty(17, np.int64)
    start = np.empty(N_BUCKETS + 2, np.int64)  # of each bucket
    left, top, right, bottom = np.empty(16), np.empty(16), np.empty(16), np.empty(16)
    # boxes of the frame that each live track may be linked to, and their IoU
    of_box, gain_of = np.empty(64, np.int64), np.empty(64)
    least_share = 0.99 * min_iou  # of the area, and so of the wider one's width
    i = 0
    while i < rows.size:
        f = frame_index[rows[i]]
        stop = i
        while stop < rows.size and frame_index[rows[stop]] == f:
            stop += 1
        n_kept = 0
        for t in range(n_live):
            last = frame_index[rows[live[t]]]
            if recording[last] == recording[f] and f - last <= max_gap + 1:
                live[n_kept] = live[t]
                n_kept += 1
        n_live = n_kept
        n_new = stop - i
        column = np.empty(n_live, np.int64)
        for t in range(n_live):
            column[t] = -1
        if n_live > 0:
            if n_new > order.size:
                order, near = np.empty(2 * n_new, np.int64), np.empty(2 * n_new + 1, np.int64)
                left, top = np.empty(2 * n_new), np.empty(2 * n_new)
                right, bottom = np.empty(2 * n_new), np.empty(2 * n_new)
            low, high, widest = np.inf, -np.inf, 0.0
            for k in range(i, stop):
                b = rows[k]
                low, high, widest = min(low, x[b]), max(high, x[b]), max(widest, w[b])
            per_bucket = (high - low) / N_BUCKETS
            is_sorted = n_new > MOST_UNSORTED and per_bucket > 0.0
            if is_sorted:
                for k in range(N_BUCKETS + 2):
                    start[k] = 0
                for k in range(i, stop):
                    start[bucket_of(x[rows[k]], low, per_bucket) + 2] += 1
                for k in range(2, N_BUCKETS + 2):
                    start[k] += start[k - 1]
            for j in range(n_new):
                b, k = rows[i + j], j
                if is_sorted:
                    bucket = bucket_of(x[b], low, per_bucket) + 1
                    k = start[bucket]
                    start[bucket] += 1
                order[k] = j
                left[k], right[k], top[k], bottom[k] = x[b], x[b] + w[b], y[b], y[b] + h[b]
            is_wanted = np.zeros(n_new, np.bool_)
            is_plain = True  # every box has at most one candidate
            n_pairs = 0
            first_pair = np.zeros(n_live + 1, np.int64)
            for t in range(n_live):
                a = rows[live[t]]
                x0, x1, y0, y1 = x[a], x[a] + w[a], y[a], y[a] + h[a]
                first, end = 0, n_new
                if is_sorted:
                    reach = (1 - least_share) * min(w[a] / least_share, widest)
                    first = start[bucket_of(x0 - reach, low, per_bucket)]
                    end = start[bucket_of(x0 + (1 - least_share) * w[a], low, per_bucket) + 1]
                n_near = 0
                area = w[a] * h[a]
                for k in range(np.uint64(first), np.uint64(end)):  # without branches
                    across = max(min(x1, right[k]) - max(x0, left[k]), 0.0)
                    shared = across * max(min(y1, bottom[k]) - max(y0, top[k]), 0.0)
                    both = area + (right[k] - left[k]) * (bottom[k] - top[k]) - shared
                    near[n_near] = k
                    n_near += shared >= least_share * both
                for k in range(n_near):
                    j = order[near[k]]
                    b = rows[i + j]
                    shared = intersection(x[a], y[a], w[a], h[a], x[b], y[b], w[b], h[b])
                    iou = shared / (w[a] * h[a] + w[b] * h[b] - shared)
                    if shared > 0.0 and iou >= min_iou:
                        if n_pairs == gain_of.size:
                            of_box = grown(of_box, 2 * n_pairs)
                            gain_of = grown(gain_of, 2 * n_pairs)
                        of_box[n_pairs], gain_of[n_pairs] = j, iou
                        n_pairs += 1
                        is_plain = is_plain and column[t] < 0 and not is_wanted[j]
                        column[t], is_wanted[j] = j, True
                first_pair[t + 1] = n_pairs
            if not is_plain:
                # size, not n_live: numba would compile for the constant 0, too
                column = assign(column.size, n_new, first_pair, of_box, gain_of)
        if n_live + n_new > live.size:
            live = grown(live, 2 * (n_live + n_new))
        for j in range(n_new):
            track[i + j] = -1
        for t in range(n_live):
            if column[t] >= 0:  # never a padding column: those have no gain
                position = i + column[t]
                track[position] = track[live[t]]
                live[t] = position
        for j in range(n_new):
            if track[i + j] < 0:
                track[i + j] = n_tracks
                n_tracks += 1
                live[n_live] = i + j
                n_live += 1
        i = stop
    return n_tracks
