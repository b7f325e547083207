"""What frames lose of similarity: per minute, and in the worst window."""

from __future__ import annotations

from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from nvcore.columns import FrameColumns


def lost_per_minute(similarity: np.ndarray, step_s: np.ndarray) -> float:
    """Lost similarity: the sum of ``(1 - M) * time step``, seconds per minute of recording.

    0 is best, 60 a similarity of 0 throughout; NaN without frames.

    Parameters
    ----------
    similarity, step_s
        Of every frame, 0 to 1, and its time step, seconds; float64, shape (n_frames,).
    """
    if not len(similarity):
        return float("nan")
    return float(60 * ((1 - similarity) * step_s).sum() / step_s.sum())


class Window(NamedTuple):
    """Frames within half a window of one frame.

    Attributes
    ----------
    row
        The frame in the middle, a row of the frames table; -1: there is none.
    mean
        Mean similarity of its frames, 1 is best; NaN if there is none.
    lost_s
        Sum of ``(1 - M) * time step`` of its frames, seconds.
    """

    row: int
    mean: float
    lost_s: float


NO_WINDOW: Final = Window(-1, float("nan"), float("nan"))


def find_worst_windows(
    similarity: np.ndarray, moving_mean: np.ndarray, frames: FrameColumns, *, window: float = 1.0
) -> tuple[Window, ...]:
    """The window with the lowest moving mean of each recording, the first of equals.

    Parameters
    ----------
    similarity
        Of every frame, 0 to 1; float64, shape (n_frames,).
    moving_mean
        Of `smooth` with the same window; float64, shape (n_frames,).
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
