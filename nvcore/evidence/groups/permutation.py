"""Permutation tests that divide values into groups, or exchange them within persons, in all ways.

Groups of values are compared by Welch's F, which does not assume equal variances. Ranks, and values
within persons, are compared by the sum of squares between the groups. The other terms of F, H and
Friedman's chi2 are the same in every permutation, so their p is the same.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations, permutations
from math import factorial, prod
from typing import Final

import numpy as np

from nvcore.evidence.bootstrap import ROUNDING, ROWS_AT_ONCE, SEED
from nvcore.evidence.groups.analyses import Test, welch_f

MOST_LISTED: Final = 200_000
"""Maximum number of ways that are all tried."""
MOST_VALUES: Final = 100
"""Maximum number of values whose ways are all tried."""
N_RANDOM: Final = 10_000
"""Number of random ways if there are more."""
TIED: Final = 1e-9
"""Relative difference up to which statistics are equal except for rounding."""
NOTHING: Final = Test("permutation", reason="there is nothing to exchange")
NO_VARIANCE: Final = Test("permutation", reason="a group has one value alone")
"""Tests without a p-value, with the reason."""


def n_partitions(sizes: Sequence[int]) -> int:
    """Return the number of ways to divide persons into nameless groups of these sizes.

    Examples
    --------
    >>> n_partitions([3, 3, 3, 3]), n_partitions([9, 3])
    (15400, 220)
    """
    named = factorial(sum(sizes)) // prod(map(factorial, sizes))
    return named // prod(factorial(n) for n in Counter(sizes).values())


def permute_between(groups: Sequence[np.ndarray], *, has_welch: bool = True) -> Test:
    """Test whether independent groups differ by more than chance. See `Test` for the counted ways.

    Exchanging groups of one size does not change the statistic, so each way to divide the values is
    listed once. More than `MOST_LISTED` ways, or ways to divide more than `MOST_VALUES` values, are
    represented by `N_RANDOM` random ones.

    In some ways a group has equal values, and thus no variance. Its variance then counts as
    `ROUNDING` times the square of the largest deviation from the mean of all values: Welch's F is
    the limit for small variances, and larger than any other if two such groups differ.

    Parameters
    ----------
    groups
        Values of each group, float64; or their ranks among all values.
    has_welch
        Compare by Welch's F. Otherwise by the sum of squares between the groups, which only tests
        whether the groups are exchangeable: it takes unequal variances for a difference, too.

    References
    ----------
    Pitman (1938), Significance tests which may be applied to samples from any populations III,
    Biometrika 29:322; Janssen (1997), Studentized permutation tests for non-i.i.d. hypotheses,
    Statistics & Probability Letters 36:9; Chung and Romano (2013), Exact and asymptotically robust
    permutation tests, Annals of Statistics 41:484; Phipson and Smyth (2010) on the p-value of
    random ways.

    Examples
    --------
    >>> test = permute_between([np.array([1.0, 2, 3]), np.array([7.0, 8, 9])])
    >>> test.p, test.n_reached, test.n_ways, test.is_exact
    (0.1, 1, 10, True)
    """
    in_order = sorted(groups, key=len)
    sizes = np.array([len(group) for group in in_order])
    values = _deviations(np.concatenate(in_order))
    if len(sizes) < 2 or len(sizes) == len(values) or not values.any():
        return NOTHING
    if has_welch and sizes[0] < 2:
        return NO_VARIANCE

    def statistic(ways: np.ndarray) -> np.ndarray:
        parts = np.split(ways, np.cumsum(sizes)[:-1], axis=1)
        mean = np.stack([part.mean(axis=1) for part in parts], axis=1)
        if not has_welch:
            between: np.ndarray = (sizes * mean**2).sum(axis=1)
            return between
        variance = np.stack([part.var(axis=1, ddof=1) for part in parts], axis=1)
        return welch_f(sizes, mean, np.maximum(variance, ROUNDING))[0]

    seen = statistic(values[np.newaxis])[0]
    if len(values) <= MOST_VALUES and n_partitions(sizes.tolist()) <= MOST_LISTED:
        return _counted(statistic(values[_partitions(tuple(sizes))]), seen, is_exact=True)
    rng = np.random.default_rng(SEED)
    batch = max(1, ROWS_AT_ONCE // len(values))
    drawn = [
        statistic(rng.permuted(np.tile(values, (min(batch, N_RANDOM - start), 1)), axis=1))
        for start in range(0, N_RANDOM, batch)
    ]
    return _counted(np.concatenate(drawn), seen, is_exact=False)


@lru_cache(maxsize=2)
def _partitions(sizes: tuple[int, ...]) -> np.ndarray:
    """List all ways to divide persons into groups of ascending sizes, int8, shape (n_ways, n).

    A row has the members of the first group, then those of the second, and so on. Groups of one
    size are in the order of their first members.
    """
    n, done, previous = sum(sizes), 0, 0
    ways = np.arange(n, dtype=np.int8)[np.newaxis]
    for size in sizes:
        # the complements of combinations are those of the other size in reverse order
        left = range(n - done)
        chosen, rest = (
            np.array([*combinations(left, m)], np.int8) for m in (size, len(left) - size)
        )
        orders = np.hstack([chosen, rest[::-1]])
        before = np.repeat(ways[:, :done], len(orders), axis=0)
        ways = np.hstack([before, ways[:, done:][:, orders].reshape(-1, len(left))])
        if size == previous:
            ways = ways[ways[:, done] > ways[:, done - size]]
        done, previous = done + size, size
    return ways


def permute_within(values: np.ndarray) -> Test:
    """Test whether conditions differ by more than chance, exchanging values within each person.

    Parameters
    ----------
    values
        Shape (n_persons, k); or ranks within each person.

    References
    ----------
    Fisher (1935), The design of experiments, section 21 (two conditions); Pitman (1938), as above;
    Friedman (1937), The use of ranks to avoid the assumption of normality.
    """
    n, k = values.shape
    centred = _deviations(values)
    if n < 2 or k < 2 or not centred.any():
        return NOTHING
    is_exact = factorial(k) ** (n - 1) <= MOST_LISTED
    if is_exact:
        sums = centred[:1]  # only the order relative to the first person matters
        for own in centred[1:]:
            sums = (sums[:, np.newaxis] + [*permutations(own)]).reshape(-1, k)
    else:
        rng = np.random.default_rng(SEED)
        sums = np.zeros((N_RANDOM, k))
        for own in centred:
            sums += rng.permuted(np.tile(own, (N_RANDOM, 1)), axis=1)
    seen = float((centred.sum(axis=0) ** 2).sum())
    return _counted((sums**2).sum(axis=1), seen, is_exact=is_exact)


def _counted(of_ways: np.ndarray, seen: float, *, is_exact: bool) -> Test:
    n_reached = int(np.count_nonzero(of_ways >= seen - TIED * seen - ROUNDING))
    n_ways, n_added = len(of_ways), int(not is_exact)
    p = (n_reached + n_added) / (n_ways + n_added)
    return Test("permutation", p=p, n_reached=n_reached, n_ways=n_ways, is_exact=is_exact)


def _deviations(values: np.ndarray) -> np.ndarray:
    """Return deviations from the last axis' mean over the largest, all 0 if they are rounding."""
    centred = values - values.mean(axis=-1, keepdims=True)
    largest = np.abs(centred).max()
    is_rounding = largest <= ROUNDING * np.abs(values).max()
    return np.zeros_like(centred) if is_rounding else centred / largest
