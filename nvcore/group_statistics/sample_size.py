"""Number of persons that a further study needs."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from typing import Final

import numpy as np
import scipy

MOST_PERSONS: Final = 100_000
"""More is no study."""
LARGEST_EFFECT: Final = 20.0
"""Two persons show a larger one; noncentral distributions are not computed there."""


def power_of_t(d: float, n: int, level: float, *, is_paired: bool) -> float:
    """Share of studies whose two-sided t test shows a difference.

    Parameters
    ----------
    d
        Difference over the SD, or in pairs over the SD of the differences.
    n
        Persons in each of two groups, or pairs.

    References
    ----------
    Cohen (1988), Statistical power analysis for the behavioral sciences, chapter 2; by the
    noncentral t distribution.

    Examples
    --------
    >>> round(power_of_t(0.5, 64, 0.05, is_paired=False), 3)
    0.801
    """
    df = n - 1 if is_paired else 2 * (n - 1)
    shift = abs(d) * np.sqrt(n if is_paired else n / 2)
    limit = scipy.stats.t.isf(level / 2, df)
    # the lower tail by the upper one of the other sign: SciPy's nct.cdf is NaN where it is tiny
    return float(scipy.stats.nct.sf(limit, df, [shift, -shift]).sum())


def power_of_anova(f: float, n: int, k: int, level: float) -> float:
    """Share of studies whose one-way analysis of variance shows a difference.

    Parameters
    ----------
    f
        Cohen's: SD of the groups' means over the SD within groups.
    n, k
        Persons in each group, and groups.

    References
    ----------
    Cohen (1988), chapter 8, by the noncentral F distribution.

    Examples
    --------
    >>> round(power_of_anova(0.25, 53, 3, 0.05), 3)
    0.805
    """
    df = k * (n - 1)
    limit = scipy.stats.f.isf(level, k - 1, df)
    return float(scipy.stats.ncf.sf(limit, k - 1, df, f**2 * n * k))


def persons_for(power: float, effect: float, power_of: Callable[[int], float]) -> float:
    """Return the least n with this power, 2 or more. NaN where it is beyond `MOST_PERSONS`.

    Parameters
    ----------
    effect
        That `power_of` is about; NaN or 0: there is no such n.
    power_of
        Power of n persons, which grows with n.
    """
    if not abs(effect) > 0:
        return np.nan
    if abs(effect) >= LARGEST_EFFECT:
        return 2.0
    high = 2
    while power_of(high) < power:
        if high >= MOST_PERSONS:
            return np.nan
        high = min(2 * high, MOST_PERSONS)
    return float(bisect_left(range(high), power, lo=high // 2 + 1, key=power_of))
