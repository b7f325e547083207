"""Similarity lost by frames: per minute, and in the worst window."""

from __future__ import annotations

from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from nvcore.dataset.columns import FrameColumns


def lost_per_minute(similarity: np.ndarray, step_s: np.ndarray) -> float:
    """Compute the lost similarity in seconds per minute of recording.

    This is the sum of ``(1 - M) * time step``. 0 is best, 60 means a similarity of 0 throughout,
    NaN means no frames.

    Parameters
    ----------
    similarity, step_s
        Similarity (0 to 1) and time step (seconds) of every frame; float64, shape (n_frames,).
    """
    if not len(similarity):
        return float("nan")
    return float(60 * ((1 - similarity) * step_s).sum() / step_s.sum())


class Window(NamedTuple):
    """Frames within half a window of a frame.

    Attributes
    ----------
    row
        Middle frame, a row of the frames table; -1 if there is no window.
    mean
        Mean similarity of the frames, 1 is best; NaN if there is no window.
    lost_s
        Sum of ``(1 - M) * time step`` over the frames, seconds.
    """

    row: int
    mean: float
    lost_s: float


NO_WINDOW: Final = Window(-1, float("nan"), float("nan"))


def find_worst_windows(
    similarity: np.ndarray, moving_mean: np.ndarray, frames: FrameColumns, *, window: float = 1.0
) -> tuple[Window, ...]:
    """Find the window with the lowest moving mean in each recording, the first one on a tie.

    Parameters
    ----------
    similarity
        Similarity of every frame, 0 to 1; float64, shape (n_frames,).
    moving_mean
        Result of `smooth` for the same window; float64, shape (n_frames,).
    """
    start, stop = frames.within(window)
    lost_s = frames.sums((1 - similarity) * frames.step_s, start, stop)
    windows = []
    for first, end in pairwise(frames.first):  # a loop over recordings
        if first == end:
            windows.append(NO_WINDOW)
            continue
        row = int(first + moving_mean[first:end].argmin())
        windows.append(Window(row, float(moving_mean[row]), float(lost_s[row])))
    return tuple(windows)
