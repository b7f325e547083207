"""Loops over the boxes of encounters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nvcore.metrics.kernels import compiled


class EncounterArrays(NamedTuple):
    """Truth rows of encounters: ``order[offsets[e]:offsets[e + 1]]`` are those of e, by frame.

    `frame_index` has the frames of these rows in the same order.
    """

    offsets: np.ndarray
    order: np.ndarray
    frame_index: np.ndarray


class EncounterMeasures(NamedTuple):
    """One system's measures of each encounter, with `lag`, `longest_gap` and `tail` in frames.

    These three are NaN if the encounter is never matched.
    """

    n_relevant: np.ndarray
    n_matched: np.ndarray
    peak_k: np.ndarray
    lag: np.ndarray
    longest_gap: np.ndarray
    tail: np.ndarray

    @classmethod
    def empty(cls, n: int) -> EncounterMeasures:
        """Return uninitialised measures of n encounters."""
        return cls(np.empty(n, np.int64), np.empty(n, np.int64), *np.empty((4, n)))


@compiled
def encounter_frames(lo, hi, rows, frames, k, matched, measures):
    """Compute one system's measures for every encounter.

    Rows of the same frame (a track id given twice) count as one.
    """
    for e in range(lo, hi):
        n_rel, n_hit = 0, 0
        peak = 0.0
        first_relevant = -1
        run, longest, delay = 0.0, 0.0, np.nan
        i, stop = rows.offsets[e], rows.offsets[e + 1]
        while i < stop:
            f = rows.frame_index[i]
            is_relevant, is_matched = False, False
            while i < stop and rows.frame_index[i] == f:
                row = rows.order[i]
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
                    delay = float(frames.frame[f] - frames.frame[first_relevant])
                else:
                    longest = max(longest, run)
                n_hit += 1
                run = 0.0
            else:
                run += frames.gap[f]
        measures.n_relevant[e], measures.n_matched[e], measures.peak_k[e] = n_rel, n_hit, peak
        measures.lag[e] = delay
        measures.longest_gap[e] = longest if n_hit else np.nan
        measures.tail[e] = run if n_hit else np.nan


@compiled
def severity_frames(offsets, encounter_of, gap, k, cost, matched, severity, worst, worst_frame):
    """Compute the cost of each encounter's missed relevant frames for one system, in frames.

    Writes the sum of cost times time step, the largest cost and its first frame row (-1: nothing
    was missed). `severity` and `worst` must be 0 before. One pass over all frames, in memory order:
    an encounter's frame is only added when its next one comes, because a track id may be given
    twice in a frame. If a frame has several boxes of an encounter, the largest cost counts.
    """
    n = severity.size
    frame, lost = np.empty(n, np.int64), np.zeros(n)
    for e in range(n):
        frame[e] = worst_frame[e] = -1
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
    """Return the rows sorted by group, stable within each group (a counting sort)."""
    position = np.zeros(counts.size + 1, np.int64)
    for g in range(counts.size):
        position[g + 1] = position[g] + counts[g]
    order = np.empty(code.size, np.int64)
    for i in range(code.size):
        if code[i] >= 0:
            order[position[code[i]]] = i
            position[code[i]] += 1
    return order
