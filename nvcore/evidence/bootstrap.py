"""Bootstrap intervals for the difference of two systems on the same recordings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import numpy as np
import scipy

SEED: Final = 110360
"""Seed of every resampling, so that the same input gives the same numbers."""
N_RESAMPLES: Final = 10_000
CONFIDENCE: Final = 0.95
"""Nominal share of intervals that contain the true difference."""
MIN_UNITS: Final = 8
"""Fewest units for an interval. In 1,500 simulations, the 95 % interval of 8 draws contained the
true mean in 93 % of cases for normal and in 87 % for lognormal values (sigma 1). With 6 draws these
were 94 and 85 %, and the ends depended on a few of only 462 distinct resamples."""
MIN_DIFFERING: Final = 6
"""Fewest units in which X and Y differ for an interval, as for a p-value. If X is better in four of
ten and equal in the others, resamples hardly ever favour Y."""
INTERVAL_RULE: Final = (
    "An interval need not have the difference in its middle: it reaches further to the side of the "
    "recordings that differ most, which a resample may have twice or three times, and its ends are "
    "moved outwards the more, the fewer recordings there are."
)
"""Explanation of the position of an interval for curious readers."""
ROWS_AT_ONCE: Final = 100_000
"""Number of drawn units held in memory at a time; fastest if they fit the cache."""
LEAST_SPREAD: Final = 0.3
"""Least spread of a draw in the studentised bootstrap, as a share of the parts' spread. Draws of
few distinct parts have almost none: ten recordings that favour X and one that favours neither would
be no evidence. In simulations of skewed parts the level is the same as with 0; 0.5 is too much."""
ROUNDING: Final = 1e-12
"""Differences smaller than this share of the values count as rounding."""

KEPT_BYTES: Final = 65_536
"""Largest size of units whose interval is cached."""
KEPT_COUNTS: Final = 4_000_000
"""Largest number of counts, resamples times units, that is cached (32 MB)."""
Statistic = Callable[[np.ndarray], np.ndarray]
"""Function that computes a measure from sums over units: shape (..., *columns) to shape (...)."""


@dataclass(frozen=True)
class BootstrapDifference:
    """Difference X - Y of a measure, with its interval.

    Attributes
    ----------
    x, y, difference
        The measure of both systems over all units, and ``x - y``; NaN if undefined.
    low, high
        Ends of the interval; NaN if there is none (see `reason`).
    n_units
        Number of recordings or blocks of time that were resampled.
    n_resamples, seed
        Number of resamples; seed of the generator.
    method
        Kind of interval in words; empty without an interval.
    reason
        Reason for the lack of an interval; empty if there is one.
    """

    x: float
    y: float
    difference: float
    low: float
    high: float
    n_units: int
    n_resamples: int
    seed: int
    method: str
    reason: str


def ratio(sums: np.ndarray) -> np.ndarray:
    """Divide the first column by the second, shape (..., 2) to (...), giving NaN for 0 / 0."""
    with np.errstate(invalid="ignore", divide="ignore"):
        quotient: np.ndarray = sums[..., 0] / sums[..., 1]
    return quotient


def bootstrap_difference(
    x: np.ndarray,
    y: np.ndarray,
    statistic: Statistic = ratio,
    *,
    shift: np.ndarray | None = None,
    n_resamples: int = N_RESAMPLES,
    seed: int = SEED,
    units: str = "units",
) -> BootstrapDifference:
    """Compute an interval for the difference X - Y by resampling units (recordings) in pairs.

    Whole units are drawn with replacement, the same ones for X and Y, and the measure is computed
    from their sums. Frames of one recording may therefore depend on each other in any way. The
    interval is BCa (bias-corrected and accelerated). Its ends are moved outwards by Student's t to
    allow for few units: the level is ``1 - 2 * Phi(-sqrt(n / (n - 1)) * t)``, where t is the
    quantile of n - 1 degrees of freedom.

    Parameters
    ----------
    x, y
        Sums of each unit, shape (n_units, *columns): for a rate two columns, numerator and
        denominator, with `ratio`; for a curve its counts at every threshold.
    statistic
        Function that computes the measure from such sums, vectorised over leading axes.
    shift
        Amount to subtract from each unit's part in the difference, float64, shape (n_units,). The
        interval is then for the difference minus the mean shift. None: nothing.
    n_resamples
        0: no interval.
    units
        Name of the units in `reason`, such as ``recordings``.

    Returns
    -------
    The interval, or the reason for its lack: fewer than `MIN_UNITS` units, an undefined measure, or
    identical units.

    References
    ----------
    Efron (1987), Better bootstrap confidence intervals; Hesterberg (2015), What teachers should
    know about the bootstrap, The American Statistician 69:371, on the expansion for few units.

    Examples
    --------
    >>> x = np.array([[9, 10], [8, 10], [7, 10], [9, 10]] * 2)
    >>> y = np.array([[8, 10], [8, 10], [5, 10], [7, 10]] * 2)
    >>> interval = bootstrap_difference(x, y)
    >>> round(interval.difference, 3), interval.low > 0
    (0.125, True)
    """
    arrays = (x, y) if shift is None else (x, y, shift)
    choices = (statistic, n_resamples, seed, units)
    if sum(array.nbytes for array in arrays) > KEPT_BYTES:
        return _resample(arrays, *choices)
    return _remembered(tuple((of.tobytes(), of.dtype.str, of.shape) for of in arrays), *choices)


@lru_cache(maxsize=256)
def _remembered(
    packed: tuple[tuple[bytes, str, tuple[int, ...]], ...], *choices: Any
) -> BootstrapDifference:
    """Call `_resample` with a cache by units, since most settings change only some measures."""
    return _resample(
        [np.frombuffer(of, kind).reshape(shape) for of, kind, shape in packed], *choices
    )


def _resample(
    arrays: Sequence[np.ndarray], statistic: Statistic, n_resamples: int, seed: int, units: str
) -> BootstrapDifference:
    """Compute `bootstrap_difference` for `x`, `y` and, if not None, `shift`."""
    x, y, *shifts = arrays
    shift = shifts[0] if shifts else None
    n = len(x)
    shape = x.shape[1:]
    value_x, value_y = float(statistic(x.sum(axis=0))), float(statistic(y.sum(axis=0)))
    difference = value_x - value_y
    values: dict[str, Any] = {"x": value_x, "y": value_y, "difference": difference, "n_units": n}
    choices: dict[str, Any] = {"n_resamples": n_resamples, "seed": seed}

    def without(reason: str) -> BootstrapDifference:
        return BootstrapDifference(
            **values, **choices, low=np.nan, high=np.nan, method="", reason=reason
        )

    if not np.isfinite(difference):
        return without("the measure is undefined")
    if not n_resamples:
        return without("")
    if n < MIN_UNITS:
        return without(f"too few {units} for an interval: {n}, at least {MIN_UNITS} are needed")
    n_differing = int(np.count_nonzero((x != y).reshape(n, -1).any(axis=1)))
    if n_differing < MIN_DIFFERING:
        few = f"X and Y differ in too few {units} for a test: {n_differing}, at least"
        same = f"X and Y are the same in all {units}"
        return without(f"{few} {MIN_DIFFERING} are needed" if n_differing else same)

    sums_of_units = np.concatenate([x.reshape(n, -1), y.reshape(n, -1)], axis=1).astype(float)
    taken_off = np.zeros(n) if shift is None else shift / n
    grain = ROUNDING * max(abs(value_x), abs(value_y))

    def of_counts(counts: np.ndarray) -> np.ndarray:
        sums = counts @ sums_of_units
        sums_x, sums_y = (half.reshape(len(half), *shape) for half in np.split(sums, 2, axis=1))
        apart = statistic(sums_x) - statistic(sums_y)
        # BCa counts draws below the difference found, so draws equal to it must be equal everywhere
        rounded: np.ndarray = grain * np.round((apart - counts @ taken_off) / grain)
        return rounded

    with np.errstate(invalid="ignore", divide="ignore"):
        draws = np.concatenate(list(map(of_counts, draw_counts(n, n_resamples, seed))))
    if not np.isfinite(draws).all():
        return without(
            "the measure is undefined in some resamples: too few units have a part in it"
        )
    if np.ptp(draws) <= ROUNDING * max(abs(value_x), abs(value_y)):
        return without(f"X and Y differ by the same in all {units}: there is nothing to resample")
    tails = expanded_tail(n) * np.array([1, -1]) + [0, 1]
    left_out = np.concatenate([of_counts(rows) for rows in _leave_one_out(n)])
    levels, method = _bca(draws, of_counts(np.ones((1, n)))[0], left_out, tails), "BCa bootstrap"
    if not np.isfinite(levels).all():
        levels, method = tails, "percentile bootstrap"
    low, high = np.quantile(draws, levels).tolist()
    return BootstrapDifference(**values, **choices, low=low, high=high, method=method, reason="")


def _bca(draws: np.ndarray, found: float, left_out: np.ndarray, tails: np.ndarray) -> np.ndarray:
    """Return the levels of the draws at which a BCa interval ends, NaN if there are none.

    Parameters
    ----------
    draws
        The measure in each resample.
    found, left_out
        The measure of all units, and without each of them.
    tails
        Levels of a percentile interval.

    References
    ----------
    Efron and Tibshirani (1993), An introduction to the bootstrap, equations 14.9 to 14.15.
    """
    n = len(left_out)
    bias = scipy.special.ndtri(((draws < found).mean() + (draws <= found).mean()) / 2)
    apart = (n - 1) * (left_out.mean() - left_out)
    with np.errstate(invalid="ignore", divide="ignore"):
        acceleration = (apart**3).sum() / (apart**2).sum() ** 1.5 / 6
        from_bias = bias + scipy.special.ndtri(tails)
        levels: np.ndarray = scipy.special.ndtr(bias + from_bias / (1 - acceleration * from_bias))
    return levels


def _leave_one_out(n: int) -> Iterator[np.ndarray]:
    """Yield rows of counts that lack one unit each, as many as memory allows at a time."""
    batch = max(1, ROWS_AT_ONCE // n)
    for start in range(0, n, batch):
        yield 1.0 - np.eye(min(batch, n - start), n, start)


def expanded_tail(n: int) -> float:
    """Return the share of resamples beyond each end of a 95 % interval, expanded for few units.

    ``Phi(-sqrt(n / (n - 1)) * t)``, where t is the quantile of n - 1 degrees of freedom (Hesterberg
    2015).
    """
    t = scipy.special.stdtrit(n - 1, (1 - CONFIDENCE) / 2)
    return float(scipy.special.ndtr(np.sqrt(n / (n - 1)) * t))


def pseudo_values(x: np.ndarray, y: np.ndarray, statistic: Statistic) -> np.ndarray:
    """Compute each unit's contribution to X - Y (jackknife pseudo-values), shape (n_units,).

    For a mean over units of equal weight these are the units' own differences. For other measures,
    a unit contributes as much as the difference changes when it is left out.
    """
    n = len(x)
    total_x, total_y = x.sum(axis=0), y.sum(axis=0)
    whole = statistic(total_x) - statistic(total_y)
    values: np.ndarray = n * whole - (n - 1) * (statistic(total_x - x) - statistic(total_y - y))
    return values


@dataclass(frozen=True, eq=False)
class StudentisedTest:
    """Test of whether the mean of some parts is 0, by the studentised bootstrap.

    Attributes
    ----------
    p
        Two-sided p-value; NaN if a part is undefined or all are equal.
    t
        t of every draw, positive on the side of the observed mean; shape (n_resamples,), empty
        without a p-value.
    """

    p: float
    t: np.ndarray


def studentised_tests(
    parts: np.ndarray,
    is_part: np.ndarray | None = None,
    *,
    n_resamples: int = N_RESAMPLES,
    seed: int = SEED,
) -> list[StudentisedTest]:
    """Test the means of some parts against 0 by the studentised bootstrap (bootstrap-t).

    Units are drawn with replacement, the same ones for all parts. p is twice the share of draws
    whose t is as far from the parts' mean, on the side of the observed mean. Unlike an exchange
    test, this does not assume that positive and negative parts mirror each other, and so it allows
    for skew.

    Parameters
    ----------
    parts
        `pseudo_values` of each measure; shape (n_units, n_measures).
    is_part
        Units that have a part in each measure, bool, in the same shape. The others are drawn too,
        but count neither in means nor in spreads. None: all.

    References
    ----------
    Efron and Tibshirani (1993), An introduction to the bootstrap, section 12.5.

    Examples
    --------
    >>> (test,) = studentised_tests(np.array([[1.0, 2.0, 3.0, 2.0, 1.0, 2.0, 3.0, 2.0]]).T)
    >>> test.p < 0.05
    True
    """
    n, n_measures = parts.shape
    is_part = np.ones(parts.shape, dtype=bool) if is_part is None else is_part
    n_parts = np.maximum(np.count_nonzero(is_part, axis=0), 1)
    parts = np.where(is_part, parts, 0.0)
    means = parts.sum(axis=0) / n_parts if n else np.full(n_measures, np.nan)
    from_mean = np.where(is_part, parts - means, 0.0)
    spreads = np.sqrt((from_mean**2).sum(axis=0) / n_parts)
    is_tested = (n_parts > 1) & np.isfinite(means) & (spreads > 1e-9 * np.abs(means))
    deviations = (from_mean * np.sign(means))[:, is_tested]
    spread, n_tested = spreads[is_tested], int(np.count_nonzero(is_tested))
    shares = is_part[:, is_tested] / n_parts[is_tested]
    moments = np.concatenate([deviations * shares, deviations**2 * shares], axis=1)
    is_whole = bool(is_part.all())
    t = []
    for counts in draw_counts(n, n_resamples, seed) if n_tested else ():
        mean, square = np.split(counts @ moments, 2, axis=1)
        # parts drawn, of those there are
        drawn_share = 1.0 if is_whole else np.maximum(counts @ shares, 1e-9)
        mean, square = mean / drawn_share, square / drawn_share
        of_draws = np.sqrt(np.maximum(square - mean**2, 0))
        t.append(np.sqrt(drawn_share) * mean / np.maximum(of_draws, LEAST_SPREAD * spread))
    columns = iter(np.concatenate(t).T if t else ())
    tests = []
    for mean, spread_of, has_p in zip(means, spreads, is_tested, strict=True):
        if not has_p:
            tests.append(StudentisedTest(np.nan, np.empty(0)))
            continue
        of_measure = next(columns)
        n_reached = int(np.count_nonzero(of_measure >= abs(mean) / spread_of))
        p = min(1.0, 2 * (n_reached + 1) / (n_resamples + 1))
        tests.append(StudentisedTest(p, of_measure))
    return tests


def draw_counts(n: int, n_resamples: int, seed: int) -> Iterable[np.ndarray]:
    """Return how often each of n units is in each resample, in batches that bound the memory.

    Each is float64, shape (<= n_resamples, n). All measures of the same units are resampled alike,
    so small ones are cached.
    """
    if n * n_resamples <= KEPT_COUNTS:
        return _kept_counts(n, n_resamples, seed)
    return _draw_counts(n, n_resamples, seed)


@lru_cache(maxsize=2)
def _kept_counts(n: int, n_resamples: int, seed: int) -> tuple[np.ndarray, ...]:
    return tuple(_draw_counts(n, n_resamples, seed))


def _draw_counts(n: int, n_resamples: int, seed: int) -> Iterator[np.ndarray]:
    rng, batch = np.random.default_rng(seed), max(1, ROWS_AT_ONCE // n)
    for start in range(0, n_resamples, batch):
        yield count_units(rng.integers(0, n, size=(min(batch, n_resamples - start), n)), n)


def count_units(units: np.ndarray, n: int) -> np.ndarray:
    """Count how often each of n units was drawn, (..., n_drawn) to float64 (..., n)."""
    flat = units.reshape(-1, units.shape[-1])
    by_draw = flat + n * np.arange(len(flat))[:, np.newaxis]
    counts = np.bincount(by_draw.ravel(), minlength=n * len(flat))
    return counts.reshape(*units.shape[:-1], n).astype(float)
