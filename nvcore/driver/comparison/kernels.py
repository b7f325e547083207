"""Compiled loop that finds how detectable each pedestrian is before the encounter counts."""

from __future__ import annotations

import numpy as np

from nvcore.metrics.kernels import compiled


@compiled
def driver_frames(
    lo,
    hi,
    offsets,
    order,
    frame_index,
    k,
    detectability,
    is_outside,
    threshold,
    highest,
    known,
    n_seen,
    n_outside,
    seen,
    confirmed,
    known_row,
):
    """Find the largest detectability of each encounter up to its first relevant frame.

    ``order[offsets[e]:offsets[e + 1]]`` are the truth rows of encounter e by frame, and
    `frame_index` has the frames of these rows in the same order. Writes, of the frames up to the
    first relevant one, the place in `order` of the first largest detectability (-1: none is known),
    in how many one is known, is at least `threshold`, and is one with `is_outside`, and the row of
    the first that is at least `threshold` (-1: in none). `confirmed` is that row of all frames,
    later ones too, and `known_row` that of the first in which it is known. Encounters without a
    relevant frame have -1, 0, 0, 0, -1, -1 and -1. Of the boxes of one frame (a track id given
    twice) the largest counts.
    """
    for e in range(lo, hi):
        highest[e], known[e], n_seen[e], n_outside[e] = -1, 0, 0, 0
        seen[e], confirmed[e], known_row[e] = -1, -1, -1
        first, last = offsets[e], offsets[e + 1]
        relevant = -1
        for i in range(first, last):
            if k[order[i]] >= 0.5:
                relevant = frame_index[i]
                break
        if relevant < 0:
            continue
        before, seen_before, outside_before = -1, -1, -1
        for i in range(first, last):
            value = detectability[order[i]]
            if np.isnan(value):
                continue
            if known_row[e] < 0:
                known_row[e] = frame_index[i]
            if value >= threshold and confirmed[e] < 0:
                confirmed[e] = frame_index[i]
            if frame_index[i] > relevant:
                if confirmed[e] >= 0:
                    break
                continue
            if frame_index[i] != before:
                known[e] += 1
                before = frame_index[i]
            if is_outside[order[i]] and frame_index[i] != outside_before:
                n_outside[e] += 1
                outside_before = frame_index[i]
            if highest[e] < 0 or value > detectability[order[highest[e]]]:
                highest[e] = i
            if value >= threshold and frame_index[i] != seen_before:
                seen_before = frame_index[i]
                n_seen[e] += 1
                if seen[e] < 0:
                    seen[e] = frame_index[i]
