"""Boxes between the keyframes of a track."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Filled:
    """Rows of all tracks, sorted by track and frame, with those between keyframes filled in.

    Attributes
    ----------
    left, right
        Rows of the input between which each row lies, int64, shape (m,); equal for input rows.
    share
        Way from left to right in 0..1, float64, shape (m,); 0 for input rows.
    frame
        Frame of each row, int64, shape (m,).
    gaps
        Rows of the input after which frames are missing that were not filled because the boxes
        around them are not both keyframes, int64.
    """

    left: np.ndarray
    right: np.ndarray
    share: np.ndarray
    frame: np.ndarray
    gaps: np.ndarray

    def __len__(self) -> int:
        return len(self.left)

    def between(self, values: np.ndarray) -> np.ndarray:
        """Values of the input rows, linear between them; shape (m, ...)."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        with np.errstate(invalid="ignore", over="ignore"):
            moved = values[self.left] + share * (values[self.right] - values[self.left])
        return np.asarray(np.where(share == 0, values[self.left], moved))

    def angle_between(self, degrees: np.ndarray) -> np.ndarray:
        """Angles of the input rows, linear between them the shorter way round; shape (m,)."""
        with np.errstate(invalid="ignore"):
            turn = (degrees[self.right] - degrees[self.left] + 180) % 360 - 180
            moved = degrees[self.left] + self.share * turn
        return np.asarray(np.where(self.share == 0, degrees[self.left], moved))


class TooManyFramesError(ValueError):
    """More boxes would be filled in than anyone annotates; `row` is where the longest gap is."""

    def __init__(self, row: int):
        super().__init__(row)
        self.row = row


def fill_between_keyframes(
    track: np.ndarray,
    frame: np.ndarray,
    outside: np.ndarray,
    keyframe: np.ndarray,
    step: np.ndarray,
    *,
    limit: int,
) -> Filled:
    """Fill the frames between two keyframes of a track, from the first unless it is outside.

    Parameters
    ----------
    track, frame
        Number of the track and of the frame of each row, int64, shape (n,).
    outside
        Whether the object has left the picture at this row, bool, shape (n,).
    keyframe
        Whether an annotator drew the box, bool, shape (n,). Nothing is filled in beside a box
        that is no keyframe: the file then has all frames that it means to have.
    step
        Distance of neighbouring frames, int64 >= 1, shape (n,).
    limit
        Most rows to fill in.

    Raises
    ------
    TooManyFramesError
        If more than `limit` rows would be filled in.
    """
    order = np.lexsort((frame, track))
    left, right = order[:-1], order[1:]
    missing = np.maximum((frame[right] - frame[left] - 1) // step[left], 0)
    missing = np.where((track[left] == track[right]) & ~outside[left], missing, 0)
    fills = keyframe[left] & keyframe[right]
    n_filled = np.where(fills, missing, 0)
    if n_filled.sum(dtype=float) > limit:
        raise TooManyFramesError(int(left[np.argmax(n_filled)]))
    n_rows = np.append(n_filled, 0)[: len(order)] + 1
    at = np.repeat(np.arange(len(order)), n_rows)
    # position of each row behind its keyframe: 0 is the keyframe itself
    position = np.arange(len(at)) - np.repeat(np.cumsum(n_rows) - n_rows, n_rows)
    start = order[at]
    end = np.where(position > 0, order[np.minimum(at + 1, len(order) - 1)], start)
    frames = frame[start] + position * step[start]
    length = np.maximum(frame[end] - frame[start], 1)
    return Filled(
        left=start,
        right=end,
        share=(frames - frame[start]) / length,
        frame=frames,
        gaps=left[(missing > 0) & ~fills],
    )
