"""Exact tests of groups: all ways to divide the values, or to exchange them within persons.

The statistic is what parts the groups: the sum of squares between them. Whatever else F and H
consist of is the same in every way, so p is that of F (of values) and of H and Friedman's chi2 (of
their ranks, ties averaged). For two groups it is two-sided, of the difference of the means and of
the rank sum.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import combinations, permutations
from math import factorial, prod
from typing import Final, NamedTuple

import numpy as np

from nvcore.evidence.bootstrap import ROUNDING, ROWS_AT_ONCE, SEED

MOST_LISTED: Final = 200_000
"""Up to so many ways, all are tried."""
N_RANDOM: Final = 10_000
"""Random ways where there are more."""


class Permuted(NamedTuple):
    """How many ways part the groups as far as the values do.

    Attributes
    ----------
    p
        NaN where there is a single way, or all values are equal.
    n_reached, n_ways
        Ways that part the groups at least as far, and that were tried.
    is_exact
        Whether these are all.
    """

    p: float
    n_reached: int
    n_ways: int
    is_exact: bool


NOT_PERMUTED: Final = Permuted(np.nan, 0, 0, False)


def n_partitions(sizes: Sequence[int]) -> int:
    """Number of ways to divide persons into groups of these sizes, which have no names.

    Examples
    --------
    >>> n_partitions([3, 3, 3, 3]), n_partitions([9, 3])
    (15400, 220)
    """
    named = factorial(sum(sizes)) // prod(map(factorial, sizes))
    return named // prod(factorial(n) for n in Counter(sizes).values())


def permute_between(groups: Sequence[np.ndarray]) -> Permuted:
    """Whether chance would part independent groups as far.

    Groups of one size may be exchanged without changing how far they are apart, so each way to
    divide the values is listed once; where there are more than `MOST_LISTED`, `N_RANDOM` random
    ones are drawn.

    Parameters
    ----------
    groups
        Values of each, float64; for a test of ranks those of all values together.

    References
    ----------
    Fisher (1935), The design of experiments; Pitman (1938), Significance tests which may be applied
    to samples from any populations III, Biometrika 29:322 (F); Phipson and Smyth (2010) on the
    p-value of random ways.

    Examples
    --------
    >>> permute_between([np.array([1.0, 2, 3]), np.array([7.0, 8, 9])])
    Permuted(p=0.1, n_reached=1, n_ways=10, is_exact=True)
    """
    in_order = sorted(groups, key=len)
    given = np.concatenate(in_order)
    sizes = [len(group) for group in in_order]
    values = given - given.mean()
    if len(sizes) < 2 or len(sizes) == len(given) or _is_flat(values, given):
        return NOT_PERMUTED
    starts = np.cumsum([0, *sizes[:-1]])

    def apart(ways: np.ndarray) -> np.ndarray:
        sums = np.add.reduceat(ways, starts, axis=1)
        squares: np.ndarray = (sums**2 / sizes).sum(axis=1)
        return squares

    seen = apart(values[np.newaxis])[0]
    if n_partitions(sizes) <= MOST_LISTED:
        return _counted(apart(values[_partitions(sizes)]), seen, is_exact=True)
    rng = np.random.default_rng(SEED)
    batch = max(1, ROWS_AT_ONCE // len(values))
    drawn = [
        apart(rng.permuted(np.tile(values, (min(batch, N_RANDOM - start), 1)), axis=1))
        for start in range(0, N_RANDOM, batch)
    ]
    return _counted(np.concatenate(drawn), seen, is_exact=False)


def _partitions(sizes: Sequence[int]) -> np.ndarray:
    """Every way to divide persons into groups of ascending sizes; int64, shape (n_ways, n).

    A row has the members of the first group, then those of the second, ...; groups of one size
    stand in the order of their first members.
    """
    n_ways, n = 1, sum(sizes)
    taken = np.empty((1, 0), dtype=np.int64)
    left = np.arange(n)[np.newaxis]
    previous = 0
    for size in sizes:
        n_left = left.shape[1]
        chosen = np.array([*combinations(range(n_left), size)])
        is_chosen = np.zeros((len(chosen), n_left), dtype=bool)
        is_chosen[np.arange(len(chosen))[:, np.newaxis], chosen] = True
        members = left[:, chosen].reshape(-1, size)
        rest = np.broadcast_to(left[:, np.newaxis], (n_ways, len(chosen), n_left))
        rest = rest[:, ~is_chosen].reshape(n_ways * len(chosen), n_left - size)
        before = np.repeat(taken, len(chosen), axis=0)
        if size == previous:
            is_first = members[:, 0] > before[:, -size]
            members, rest, before = members[is_first], rest[is_first], before[is_first]
        taken, left = np.concatenate([before, members], axis=1), rest
        n_ways, previous = len(taken), size
    return taken


def n_exchanges(n: int, k: int) -> int:
    """Number of ways to exchange k values within each of n persons, those of the first staying.

    Examples
    --------
    >>> n_exchanges(5, 3), n_exchanges(6, 2)
    (1296, 32)
    """
    n_ways: int = factorial(k) ** (n - 1)
    return n_ways


def permute_within(values: np.ndarray) -> Permuted:
    """Whether chance would part the conditions as far, had each person's values been exchanged.

    Parameters
    ----------
    values
        Shape (n_persons, k); for a test of ranks those within each person.

    References
    ----------
    Fisher (1935), section 21 (two conditions); Pitman (1938), as above; Friedman (1937), The use of
    ranks to avoid the assumption of normality.
    """
    n, k = values.shape
    centred = values - values.mean(axis=1, keepdims=True)
    if n < 2 or k < 2 or _is_flat(centred, values):
        return NOT_PERMUTED
    seen = float((centred.sum(axis=0) ** 2).sum())
    if n_exchanges(n, k) <= MOST_LISTED:
        sums = centred[:1]  # the first person stays: only how the others stand to it matters
        for own in centred[1:]:
            ways = np.array([*permutations(own)])
            sums = (sums[:, np.newaxis] + ways).reshape(-1, k)
        return _counted((sums**2).sum(axis=1), seen, is_exact=True)
    rng = np.random.default_rng(SEED)
    sums = np.zeros((N_RANDOM, k))
    for own in centred:
        sums += rng.permuted(np.tile(own, (N_RANDOM, 1)), axis=1)
    return _counted((sums**2).sum(axis=1), seen, is_exact=False)


def _counted(apart: np.ndarray, seen: float, *, is_exact: bool) -> Permuted:
    """The result of how far each way, and the one that was seen, parts the groups."""
    grain = ROUNDING * float(apart.max(initial=seen))  # sums in another order differ by rounding
    n_reached = int(np.count_nonzero(apart >= seen - grain))
    n_ways = len(apart)
    p = n_reached / n_ways if is_exact else (n_reached + 1) / (n_ways + 1)
    return Permuted(p, n_reached, n_ways, is_exact)


def _is_flat(centred: np.ndarray, values: np.ndarray) -> bool:
    """Whether values are equal to their mean but for rounding."""
    return bool(np.abs(centred).max() <= ROUNDING * np.abs(values).max())
