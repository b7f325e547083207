"""Analyses of groups by formula, of the same persons in all conditions, and sizes of studies.

Analyses of independent groups only need n, mean and SD of each. Tables of values are reduced to
these, so there is one implementation for both. The tests compare it with SciPy's functions, which
take values only.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np
import pandas as pd
import scipy

from nvcore.evidence.bootstrap import CONFIDENCE, ROUNDING
from nvcore.evidence.paired_tests import holm

SMALLEST_SD: Final = 1e-60
"""Smallest SD. Fourth powers of smaller ones underflow."""
MOST_PERSONS: Final = 100_000
"""Largest study size considered."""
LARGEST_EFFECT: Final = 20.0
"""Effect that two persons show already. Noncentral distributions are not computed beyond it."""
PAIR_COLUMNS: Final = (
    *("test", "first", "second", "difference", "low", "high", "ratio", "ratio_low", "ratio_high"),
    *("value", "df", "p", "p_corrected", "d"),
)


class Groups(NamedTuple):
    """n, mean and SD of k groups, each float64, shape (k,).

    The SD divides by n - 1 and is NaN for n = 1. Pairs are in the order of `pairs_of`.
    """

    n: np.ndarray
    mean: np.ndarray
    sd: np.ndarray

    @property
    def variances(self) -> np.ndarray:
        """Squares of the SD, 0 if the SD is only rounding or too small, NaN for n = 1."""
        is_rounding = self.sd <= max(ROUNDING * np.abs(self.mean).max(initial=0.0), SMALLEST_SD)
        return np.where(is_rounding, 0.0, self.sd) ** 2

    @property
    def within(self) -> tuple[float, float]:
        """Variance within the groups (NaN if there is none), and its degrees of freedom."""
        squares, df = np.nansum((self.n - 1) * self.variances), float((self.n - 1).sum())
        return float(squares / df) if squares else np.nan, df

    @property
    def differences(self) -> np.ndarray:
        """Difference of each pair's means, shape (k (k - 1) / 2,)."""
        first, second = pairs_of(len(self.n))
        difference: np.ndarray = self.mean[first] - self.mean[second]
        return difference


class Test(NamedTuple):
    """Overall test of k groups. NaN is undefined, and `reason` explains it.

    Attributes
    ----------
    test
        Key of `nvcore.evidence.groups.text.TESTS`.
    statistic, value, df_between, df_within, p
        F, H or chi2, with its value, degrees of freedom and p.
    eta2, omega2, f
        Share of the variance between the groups, the share corrected for chance, and Cohen's
        ``sqrt(eta2 / (1 - eta2))``. In the same persons eta² is partial.
    n_reached, n_ways, is_exact
        For permutations: number of permutations with at least that separation, their total number,
        and True if these are all.
    """

    test: str
    statistic: str = ""
    value: float = np.nan
    df_between: float = np.nan
    df_within: float = np.nan
    p: float = np.nan
    eta2: float = np.nan
    omega2: float = np.nan
    f: float = np.nan
    n_reached: int = 0
    n_ways: int = 0
    is_exact: bool = False
    reason: str = ""


def pairs_of(k: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and second group of each pair, int64, shape (k (k - 1) / 2,)."""
    return np.triu_indices(k, 1)


def pair_table(test: str, k: int, **columns: Any) -> pd.DataFrame:
    """Return a row for each pair of k groups with `PAIR_COLUMNS`. Missing columns are NaN."""
    first, second = pairs_of(k)
    table = pd.DataFrame({"test": test, "first": first, "second": second, **columns})
    return table.reindex(columns=[*PAIR_COLUMNS])


def anova(groups: Groups) -> Test:
    """Compute a one-way analysis of variance with effect sizes, assuming equal variances.

    References
    ----------
    Fisher (1925), Statistical methods for research workers, chapter 7; Hays (1963), Statistics for
    psychologists (omega²); Cohen (1988), Statistical power analysis, section 8.2 (f).

    Examples
    --------
    >>> groups = Groups(*np.array([[11] * 3, [1678, 2171, 1245], [755.1, 766.2, 389.5]]))
    >>> test = anova(groups)
    >>> round(test.value, 4), round(test.p, 6), round(test.eta2, 3), round(test.omega2, 3)
    (5.412, 0.009842, 0.265, 0.211)
    """
    n, mean, _ = groups
    error, df_within = groups.within
    if np.isnan(error):
        return Test("anova", reason="no group has any spread")
    between, df = float((n * (mean - n @ mean / n.sum()) ** 2).sum()), len(n) - 1.0
    value, within = between / df / error, error * df_within
    return Test(
        *("anova", "F", value, df, df_within, float(scipy.stats.f.sf(value, df, df_within))),
        eta2=between / (between + within),
        omega2=(between - df * error) / (between + within + error),
        f=float(np.sqrt(between / within)),
    )


def welch(groups: Groups) -> Test:
    """Compute Welch's analysis of variance, for groups of different variances."""
    if not (groups.variances > 0).all():
        return Test("welch", reason="a group has no spread, or one value alone")
    value, df = map(float, welch_f(groups.n, groups.mean, groups.variances))
    df_between = len(groups.n) - 1.0
    p = float(scipy.stats.f.sf(value, df_between, df))
    return Test("welch", "F", value, df_between, df, p)


def welch_f(
    n: np.ndarray, mean: np.ndarray, variances: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return Welch's F and its degrees of freedom within the groups.

    Parameters
    ----------
    n, mean, variances
        n, mean and variance of k groups, shape (..., k). Variances are above 0.

    References
    ----------
    Welch (1951), On the comparison of several mean values: an alternative approach, Biometrika
    38:330. With two groups it is Welch's t test.
    """
    weight, k = n / variances, mean.shape[-1]
    share = weight / weight.sum(axis=-1, keepdims=True)
    lack = ((1 - share) ** 2 / (n - 1)).sum(axis=-1)
    centre = (share * mean).sum(axis=-1, keepdims=True)
    spread = (weight * (mean - centre) ** 2).sum(axis=-1) / (k - 1)
    return spread / (1 + 2 * (k - 2) / (k**2 - 1) * lack), (k**2 - 1) / (3 * lack)


def tukey(groups: Groups) -> pd.DataFrame:
    """Compare all pairs by Tukey's test (Kramer's for unequal n), assuming equal variances.

    References
    ----------
    Tukey (1949), Comparing individual means in the analysis of variance; Kramer (1956).
    """
    variance, df = groups.within
    return _by_range("tukey", groups, variance / groups.n, np.full(len(groups.differences), df))


def games_howell(groups: Groups) -> pd.DataFrame:
    """Compare all pairs by Games and Howell's test, for groups of different variances.

    References
    ----------
    Games and Howell (1976), Pairwise multiple comparison procedures with unequal n's and/or
    variances.
    """
    first, second = pairs_of(len(groups.n))
    part = np.where(groups.variances > 0, groups.variances, np.nan) / groups.n
    squares = part**2 / np.maximum(groups.n - 1, 1)
    df = (part[first] + part[second]) ** 2 / (squares[first] + squares[second])
    return _by_range("games_howell", groups, part, df)


def _by_range(test: str, groups: Groups, part: np.ndarray, df: np.ndarray) -> pd.DataFrame:
    """Compare all pairs by the studentised range.

    `part` is each group's variance over n, `df` has a value for each pair.
    """
    k, (first, second), difference = len(groups.n), pairs_of(len(groups.n)), groups.differences
    error = np.sqrt((part[first] + part[second]) / 2)
    q, p, limit = np.abs(difference) / error, np.full(len(df), np.nan), np.full(len(df), np.nan)
    is_known = ~np.isnan(q)
    if is_known.any():
        p[is_known] = np.minimum(scipy.stats.studentized_range.sf(q[is_known], k, df[is_known]), 1)
        freedoms, place = np.unique(df[is_known], return_inverse=True)  # a quantile takes 0.1 s
        limit[is_known] = scipy.stats.studentized_range.ppf(CONFIDENCE, k, freedoms)[place]
    ends = {"low": difference - limit * error, "high": difference + limit * error}
    more = {"value": q, "df": df, "p_corrected": p, "d": cohens_d(groups)}
    return pair_table(test, k, difference=difference, **ends, **more)


def cohens_d(groups: Groups) -> np.ndarray:
    """Return Cohen's d of each pair, shape (k (k - 1) / 2,), NaN if the pooled SD is 0."""
    first, second = pairs_of(len(groups.n))
    squares, df = np.nan_to_num((groups.n - 1) * groups.variances), groups.n - 1
    pooled = (squares[first] + squares[second]) / np.maximum(df[first] + df[second], 1)
    d: np.ndarray = groups.differences / np.sqrt(np.where(pooled > 0, pooled, np.nan))
    return d


def t_interval(
    mean: np.ndarray, error: np.ndarray, n: np.ndarray | int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the 95 % interval of means of n values with these standard errors, NaN for n = 1."""
    half = scipy.stats.t.ppf((1 + CONFIDENCE) / 2, n - 1) * error
    return mean - half, mean + half


def paired_t(
    test: str, k: int, n: int, difference: np.ndarray, sd: np.ndarray, *, are_logs: bool = False
) -> pd.DataFrame:
    """Compute paired t tests of all pairs of k conditions, corrected by Holm's method.

    Parameters
    ----------
    n
        Number of persons.
    difference, sd
        Mean and SD of the persons' differences, shape (k (k - 1) / 2,).
    are_logs
        True if these are of logarithms. The effects are then ratios of geometric means.
    """
    spread = np.where(sd > 0, sd, np.nan)
    error = spread / np.sqrt(n)
    p = 2 * scipy.stats.t.sf(np.abs(difference) / error, n - 1)
    effect = np.array([difference, *t_interval(difference, error, n)])
    names = PAIR_COLUMNS[6:9] if are_logs else PAIR_COLUMNS[3:6]
    columns = dict(zip(names, np.exp(effect) if are_logs else effect, strict=True))
    more = {"value": difference / error, "df": n - 1.0, "p": p, "p_corrected": holm(p)}
    return pair_table(test, k, **columns, **more, d=difference / spread)


def assumed_pairs(groups: Groups, correlation: float) -> pd.DataFrame:
    """Compute paired t tests as if the persons were the same: a what-if, not a result.

    The SD of the differences is ``sqrt(s1² + s2² - 2 r s1 s2)``.

    Parameters
    ----------
    groups
        Groups of the same n.
    correlation
        Correlation of the values in any two conditions, -1 to 1.
    """
    first, second = pairs_of(len(groups.n))
    s, t = groups.sd[first], groups.sd[second]
    sd = np.sqrt(np.maximum(s**2 + t**2 - 2 * correlation * s * t, 0))
    return paired_t("assumed", len(groups.n), int(groups.n[0]), groups.differences, sd)


def residuals(values: np.ndarray) -> np.ndarray:
    """Return values, shape (n, k), minus the persons' and the conditions' means.

    They are all 0 if they are only rounding errors.
    """
    centred = values - values.mean(axis=1, keepdims=True)
    left: np.ndarray = centred - centred.mean(axis=0)
    is_rounding = np.abs(left).max(initial=0.0) <= ROUNDING * np.abs(values).max(initial=0.0)
    return np.zeros_like(left) if is_rounding else left


def repeated_measures(values: np.ndarray) -> list[Test]:
    """Compute a repeated-measures analysis of variance, plain and with Greenhouse and Geisser's df.

    F is the variance between conditions over the rest, after removing those between conditions and
    between persons. With two conditions it is the paired t test, ``F = t²``.

    Parameters
    ----------
    values
        Shape (n_persons, k), with at least two persons and two conditions, without NaN.

    References
    ----------
    Fisher (1925), chapter 8; Greenhouse and Geisser (1959), On methods in the analysis of profile
    data, Psychometrika 24:95.
    """
    n, k = values.shape
    within = float((residuals(values) ** 2).sum())
    if not within:
        reason = "all persons differ alike between the conditions"
        return [Test(test, reason=reason) for test in ("repeated", "repeated_gg")]
    between = n * k * float(values.mean(axis=0).var())
    value = between / within * (n - 1)
    effect = {"eta2": between / (between + within), "f": float(np.sqrt(between / within))}
    tests = []
    for test, share in (("repeated", 1.0), ("repeated_gg", sphericity(values))):
        df = share * (k - 1), share * (k - 1) * (n - 1)
        tests.append(Test(test, "F", value, *df, float(scipy.stats.f.sf(value, *df)), **effect))
    return tests


def sphericity(values: np.ndarray) -> float:
    """Return Greenhouse and Geisser's epsilon: 1 if all differences vary alike, else less.

    At worst it is 1 / (k - 1). ``tr(S)² / ((k - 1) tr(S²))``, where S is the covariance of the
    conditions minus the persons' means. NaN without spread.
    """
    left = residuals(values)
    covariance = left.T @ left
    trace, squares = float(np.trace(covariance)), float((covariance**2).sum())
    if not squares:
        return np.nan
    epsilon: float = trace * trace / ((values.shape[1] - 1) * squares)
    return min(epsilon, 1.0)


def friedman(values: np.ndarray) -> Test:
    """Compute Friedman's test of the ranks within each person, with ties.

    It needs three conditions or more.
    """
    if values.shape[1] < 3:
        return Test("friedman", reason="it needs three conditions")
    if not np.ptp(values, axis=1).any():
        return Test("friedman", reason="nobody's values differ between the conditions")
    chi2, p = scipy.stats.friedmanchisquare(*values.T)
    return Test("friedman", "chi2", float(chi2), values.shape[1] - 1.0, p=float(p))


def paired(values: np.ndarray, *, are_logs: bool) -> pd.DataFrame:
    """Compute paired t tests of all pairs of conditions, corrected by Holm, for values (n, k)."""
    n, k = values.shape
    first, second = pairs_of(k)
    apart = values[:, first] - values[:, second]
    sd = apart.std(axis=0, ddof=1)
    sd = np.where(sd > ROUNDING * np.abs(values).max(), sd, 0.0)
    return paired_t("paired", k, n, apart.mean(axis=0), sd, are_logs=are_logs)


def power_of_f(f: float, n: int, k: int, level: float) -> float:
    """Return the share of studies whose analysis of variance or two-sided t test is significant.

    Parameters
    ----------
    f
        Cohen's f: SD of the groups' means over the SD within groups (half of d for two groups). For
        pairs, mean over SD of the differences.
    n, k
        Numbers of persons in each group, and of groups. For pairs, k is 1.

    References
    ----------
    Cohen (1988), Statistical power analysis for the behavioral sciences, chapters 2 and 8, by the
    noncentral F distribution.

    Examples
    --------
    >>> round(power_of_f(0.25, 53, 3, 0.05), 3), round(power_of_f(0.5 / 2, 64, 2, 0.05), 3)
    (0.805, 0.801)
    """
    df = max(k - 1, 1), k * (n - 1)
    return float(scipy.stats.ncf.sf(scipy.stats.f.isf(level, *df), *df, f**2 * n * k))


def persons_for(power: float, effect: float, power_of: Callable[[int], float]) -> float:
    """Return the smallest n >= 2 with this power, NaN if it is beyond `MOST_PERSONS`.

    Parameters
    ----------
    effect
        Effect that `power_of` is for. With NaN or 0 there is no such n.
    power_of
        Function that returns the power of n persons, increasing with n.
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
