"""Strips of time for all recordings: the loss of the worse system, and its worst frames."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.values import lost_per_minute_by_recording

N_BINS: Final = 240
MOST_RECORDINGS: Final = 60


@dataclass(frozen=True, eq=False)
class LossStrip:
    """Recordings, worst first, cut into bins of equal length.

    Attributes
    ----------
    recording
        Row in the table of recordings for each strip; int64, shape (n_strips,).
    lost_s_per_min
        Similarity lost by the worse of the two systems, seconds per minute, 0 is best; float64,
        shape (n_strips,), descending.
    loss
        Largest ``1 - M`` of either system in each bin, 0 is best; NaN after the recording's end;
        float64, shape (n_strips, n_bins).
    row
        Frame with that loss (the first on a tie), a row of the frames table, -1 after the end;
        int64, shape (n_strips, n_bins).
    bin_s
        Length of a bin, seconds.
    n_recordings
        Number of recordings with frames, including those left out.
    """

    recording: np.ndarray
    lost_s_per_min: np.ndarray
    loss: np.ndarray
    row: np.ndarray
    bin_s: float
    n_recordings: int


def loss_strip(result: Result, *, n_bins: int = N_BINS, most: int = MOST_RECORDINGS) -> LossStrip:
    """Compute the largest loss of the worse system in each time bin of the recordings.

    The maximum is used so that no bad moment is lost, however long the recordings are. A frame
    lasts until the next listed one. Recordings without frames have no strip.

    Parameters
    ----------
    n_bins
        Largest number of bins of the longest recording. No bin is shorter than the shortest frame.
    most
        Largest number of strips. Those that lose most are kept.
    """
    frames = result.dataset.frame_columns
    similarity = np.minimum(result.x.similarity, result.y.similarity)
    with_frames = np.flatnonzero(np.diff(frames.first))
    lost_x, lost_y = (lost_per_minute_by_recording(result, system) for _, system in result.sides)
    lost = np.maximum(lost_x, lost_y)[with_frames]
    time_s, last = result.dataset.frames["time_s"].to_numpy(), frames.first[with_frames + 1] - 1
    end_s = time_s[last] + frames.step_s[last]
    order = np.argsort(-lost, kind="stable")[:most]
    longest_s = float(end_s[order].max(initial=0))
    frame_s = float(frames.step_s.min(initial=longest_s))
    n_bins = min(n_bins, int(longest_s / frame_s + 1e-9)) if frame_s else n_bins
    bin_s = longest_s / n_bins or 1.0
    loss = np.full((len(order), n_bins), np.nan)
    worst_rows = np.full((len(order), n_bins), -1, dtype=np.int64)
    for place, index in enumerate(order.tolist()):
        rows = frames.rows_of(int(with_frames[index]))
        # rounded: a frame at a bin's edge belongs to the bin that begins there
        bins = np.floor(time_s[rows] / bin_s + 1e-9).astype(np.int64).clip(0, n_bins - 1)
        n_covered = int(np.ceil(end_s[index] / bin_s - 1e-9).clip(bins[-1] + 1, n_bins))
        least = _least_of_each(similarity[rows], bins, n_covered)
        worst_rows[place, :n_covered] = rows.start + least
        loss[place, :n_covered] = 1 - similarity[rows.start + least]
    return LossStrip(
        recording=with_frames[order],
        lost_s_per_min=lost[order],
        loss=loss,
        row=worst_rows,
        bin_s=bin_s,
        n_recordings=len(with_frames),
    )


def _least_of_each(values: np.ndarray, bins: np.ndarray, n_bins: int) -> np.ndarray:
    """Return the index of the least value of each bin, the first on a tie.

    An empty bin has the last index of the previous bin.

    Parameters
    ----------
    bins
        Bin of each value, rising from 0, shape (n,).
    """
    starts = np.flatnonzero(np.diff(bins, prepend=-1))
    least = np.minimum.reduceat(values, starts)
    hits = np.flatnonzero(values == np.repeat(least, np.diff(np.append(starts, len(values)))))
    # the last frame before an empty bin holds until the next one, not the worst before it
    index: np.ndarray = np.searchsorted(bins, np.arange(n_bins), side="right") - 1
    index[bins[starts]] = hits[np.searchsorted(hits, starts)]
    return index
