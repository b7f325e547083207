"""Orders of what is shown, balanced over participants."""

from __future__ import annotations

import numpy as np


def counterbalanced_order(n_clips: int, participant: int) -> np.ndarray:
    """Clips in the order for one participant: a row of Williams' balanced Latin square (1949).

    Over `n_clips` participants (twice as many where that is odd) every clip stands in every place
    equally often, and follows every other clip equally often.

    Parameters
    ----------
    participant
        0-based number of the participant; beyond the square it starts again.

    Examples
    --------
    >>> counterbalanced_order(4, 0).tolist(), counterbalanced_order(4, 1).tolist()
    ([0, 1, 3, 2], [1, 2, 0, 3])
    """
    steps = np.arange(n_clips)
    zigzag = np.where(steps % 2 == 1, (steps + 1) // 2, (n_clips - steps // 2) % max(n_clips, 1))
    order: np.ndarray = (zigzag + participant) % max(n_clips, 1)
    is_mirrored = n_clips % 2 == 1 and participant // max(n_clips, 1) % 2 == 1
    return order[::-1] if is_mirrored else order
