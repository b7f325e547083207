"""The compiled loop that links boxes over frames by optimal assignment.

Written with plain loops instead of slices and ``np.full``: those drag numba's string formatting
(of error messages) into the compilation, which takes seconds.
"""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled, intersection

MOST_AT_ONCE = 32
"""Tracks up to which all boxes of a frame are assigned at once: looking for parts saves nothing.

Of several assignments with exactly the same total, the two ways may take different ones.
"""


@compiled
def assign(gain):
    """Assignment of rows to columns with the largest total gain; pairs without gain stay apart.

    Shortest augmenting paths with potentials (Jonker and Volgenant 1987; the method of
    ``scipy.optimize.linear_sum_assignment``, which compiled code cannot call).

    Parameters
    ----------
    gain
        float64, shape (n, m) with m >= n, not negative; 0 means that the pair is not allowed.

    Returns
    -------
    int64, shape (n,): column of each row, or -1.
    """
    n, m = gain.shape
    row_price, column_price = np.zeros(n + 1), np.zeros(m + 1)
    owner = np.zeros(m + 1, np.int64)  # row (1-based) of each column, 0 free
    way = np.zeros(m + 1, np.int64)
    least = np.empty(m + 1)
    is_used = np.zeros(m + 1, np.bool_)
    for i in range(1, n + 1):
        owner[0] = i
        j0 = 0
        for j in range(m + 1):
            least[j] = np.inf
            is_used[j] = False
        while True:
            is_used[j0] = True
            i0, step, j1 = owner[j0], np.inf, 0
            for j in range(1, m + 1):
                if is_used[j]:
                    continue
                cost = -gain[i0 - 1, j - 1] - row_price[i0] - column_price[j]
                if cost < least[j]:
                    least[j] = cost
                    way[j] = j0
                if least[j] < step:
                    step, j1 = least[j], j
            for j in range(m + 1):
                if is_used[j]:
                    row_price[owner[j]] += step
                    column_price[j] -= step
                else:
                    least[j] -= step
            j0 = j1
            if owner[j0] == 0:
                break
        while j0 != 0:
            owner[j0] = owner[way[j0]]
            j0 = way[j0]
    column = np.empty(n, np.int64)
    for i in range(n):
        column[i] = -1
    for j in range(1, m + 1):
        if owner[j] > 0 and gain[owner[j] - 1, j - 1] > 0.0:
            column[owner[j] - 1] = j - 1
    return column


@compiled
def assign_in_parts(gain):
    """As `assign`, one part after the other: cubic in the largest part, not in all boxes.

    Two boxes are of one part if a chain of allowed pairs leads from one to the other: what is
    assigned in one part changes nothing in another.
    """
    n, m = gain.shape
    part = np.empty(m, np.int64)  # the first column of each column's part
    part_of_row = np.empty(n, np.int64)
    for j in range(m):
        part[j] = j
    for i in range(n):
        part_of_row[i] = -1
        for j in range(m):
            if gain[i, j] <= 0.0:
                continue
            a, b = j, part_of_row[i]
            while part[a] != a:
                a = part[a]
            if b < 0:
                b = a
            while part[b] != b:
                b = part[b]
            part[max(a, b)] = min(a, b)
            part_of_row[i] = min(a, b)
    for j in range(m):  # each column's part comes before it
        part[j] = part[part[j]]
    rows, columns, column = np.empty(n, np.int64), np.empty(m, np.int64), np.empty(n, np.int64)
    for i in range(n):
        column[i] = -1
        if part_of_row[i] >= 0:
            part_of_row[i] = part[part_of_row[i]]
    for p in range(m):
        if part[p] != p:
            continue
        n_rows, n_columns = 0, 0
        for i in range(n):
            if part_of_row[i] == p:
                rows[n_rows] = i
                n_rows += 1
        if n_rows == 0:
            continue
        for j in range(p, m):
            if part[j] == p:
                columns[n_columns] = j
                n_columns += 1
        small = np.zeros((n_rows, max(n_rows, n_columns)))
        for i in range(n_rows):
            for j in range(n_columns):
                small[i, j] = gain[rows[i], columns[j]]
        best = assign(small)
        for i in range(n_rows):
            if best[i] >= 0:
                column[rows[i]] = columns[best[i]]
    return column


@compiled
def link_rows(rows, frame_index, recording, x, y, w, h, min_iou, max_gap, track):
    """Number the track of every row, counting from 0 over all recordings.

    Boxes of successive listed frames are assigned to the tracks seen at most `max_gap` listed
    frames before, by the largest total IoU over pairs with ``IoU >= min_iou``; a box without a
    track starts one.

    Parameters
    ----------
    rows
        Rows of the box columns to link, sorted by frame, int64, shape (n,).
    frame_index, x, y, w, h
        Box columns.
    recording
        Recording of each frame.
    track
        int64, shape (n,); written.

    Returns
    -------
    Number of tracks.
    """
    n_tracks = 0
    live = np.empty(16, np.int64)  # positions (into rows) of each live track's last box
    n_live = 0
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
            gain = np.zeros((n_live, max(n_live, n_new)))
            per_new = np.zeros(n_new, np.int64)
            is_plain = True  # every box has at most one candidate
            for t in range(n_live):
                a = rows[live[t]]
                candidates = 0
                for j in range(n_new):
                    b = rows[i + j]
                    shared = intersection(x[a], y[a], w[a], h[a], x[b], y[b], w[b], h[b])
                    if shared <= 0.0:
                        continue
                    iou = shared / (w[a] * h[a] + w[b] * h[b] - shared)
                    if iou >= min_iou:
                        gain[t, j] = iou
                        column[t] = j
                        candidates += 1
                        per_new[j] += 1
                if candidates > 1:
                    is_plain = False
            for j in range(n_new):
                if per_new[j] > 1:
                    is_plain = False
            if not is_plain:
                whole = gain.shape[0] <= MOST_AT_ONCE
                column = assign(gain) if whole else assign_in_parts(gain)
        if n_live + n_new > live.size:
            grown = np.empty(2 * (n_live + n_new), np.int64)
            for t in range(n_live):
                grown[t] = live[t]
            live = grown
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
