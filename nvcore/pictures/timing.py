"""What the times of a video's pictures say: its rate, gaps, and whether they are even."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.pictures.notes import MOST_PLACES, PictureNote, PictureTrait

NOT_WHOLE: Final = 0.25
"""Steps by which a time may lie beside a whole number of them."""
_UNEVEN: Final = 0.1
"""Share of steps from which on times that are not whole steps make the rate uneven."""
_SAME_RATE: Final = 1e-3


def usual_step(times: NDArray[np.int64]) -> float:
    """The commonest step between times, not the mean: gaps do not lengthen it; 0: there is none.

    The mean of the steps near the median: containers round each of them.
    """
    steps = np.sort(np.diff(times.astype(np.float64)))  # damaged files state times of 63 bit
    median = steps[(len(steps) - 1) // 2] if len(steps) else 0
    if median <= 0:
        return 0.0
    return float(steps[np.abs(steps - median) <= NOT_WHOLE * median].mean())


def time_notes(times: NDArray[np.int64]) -> tuple[PictureNote, ...]:
    """Whether pictures are missing by the times, or the rate varies; not where times go back."""
    step, steps = usual_step(times), np.diff(times.astype(np.float64))
    if not step or (steps <= 0).any():
        return ()
    passed = steps / step
    whole = np.rint(passed)
    n_beside = int(np.count_nonzero((np.abs(passed - whole) > NOT_WHOLE) | (whole < 1)))
    if n_beside > _UNEVEN * len(passed):
        return (PictureNote(PictureTrait.UNEVEN, n_beside, len(passed)),)
    after = np.flatnonzero(whole > 1)
    if not len(after):
        return ()
    n_missing = int(whole[after].sum()) - len(after)
    places = tuple(int(place) + 1 for place in after[:MOST_PLACES])
    return (PictureNote(PictureTrait.GAP, n_missing, len(times) + n_missing, places),)


def frame_rate(step_s: float, stated: float | None) -> float | None:
    """The rate by the commonest step; the stated one where it agrees, or no step is known (0)."""
    if not step_s:
        return stated
    rate = 1 / step_s
    if stated and abs(stated / rate - 1) < _SAME_RATE:
        return stated
    # times are rounded in a container: rates are whole, or those of colour television
    near = [usual for usual in (round(rate), round(rate * 1.001) / 1.001) if usual]
    nearest = min(near, key=lambda usual: abs(usual - rate), default=rate)
    return float(nearest) if abs(nearest / rate - 1) < _SAME_RATE / 2 else rate
