"""Shares of a count with their confidence interval."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Share:
    """Share of correct items with its confidence interval.

    Attributes
    ----------
    n_right, n
        Number of correct items and of all items.
    share
        Share of correct items; NaN without any.
    low, high
        Wilson's 95 % interval of the share, assuming independent items; NaN without any.
    """

    n_right: int
    n: int
    share: float
    low: float
    high: float


def share_of(n_right: int, n: int) -> Share:
    """Return the share of correct items with its confidence interval.

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
    z2 = scipy.special.ndtri((1 + CONFIDENCE) / 2) ** 2
    middle, half = n_right + z2 / 2, np.sqrt(z2 * (n_right * (n - n_right) / n + z2 / 4))
    low = (middle - half) / (n + z2) if n_right else 0.0
    high = (middle + half) / (n + z2) if n_right < n else 1.0
    return Share(n_right, n, n_right / n, float(low), float(high))
