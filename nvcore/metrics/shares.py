"""Shares of a count, with their interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Share:
    """So many right ones of so many.

    Attributes
    ----------
    n_right, n
        How many are right, and how many there are.
    share
        Of those the right ones; NaN without any.
    low, high
        Wilson's 95 % interval of the share, which takes them as independent; NaN without any.
    """

    n_right: int
    n: int
    share: float
    low: float
    high: float


def share_of(n_right: int, n: int) -> Share:
    """So many right ones of so many, with the interval.

    References
    ----------
    Wilson, Probable inference, the law of succession, and statistical inference, JASA 22 (1927).

    Examples
    --------
    >>> share_of(3, 4).share, round(share_of(3, 4).low, 3)
    (0.75, 0.301)
    """
    if not n:
        return Share(0, 0, np.nan, np.nan, np.nan)
    ends = scipy.stats.binomtest(n_right, n).proportion_ci(CONFIDENCE, method="wilson")
    return Share(n_right, n, n_right / n, float(ends.low), float(ends.high))
