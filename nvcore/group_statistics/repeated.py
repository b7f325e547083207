"""Analyses of the same persons in all conditions: each is compared with themselves."""

from __future__ import annotations

import numpy as np
import pandas as pd
import scipy

from nvcore.evidence.bootstrap import ROUNDING
from nvcore.group_statistics.summaries import Test, paired_t, pairs_of


def residuals(values: np.ndarray) -> np.ndarray:
    """What is left of values, shape (n, k), without the persons' and the conditions' means.

    All 0 where it is rounding.
    """
    centred = values - values.mean(axis=1, keepdims=True)
    left: np.ndarray = centred - centred.mean(axis=0)
    is_rounding = np.abs(left).max(initial=0.0) <= ROUNDING * np.abs(values).max(initial=0.0)
    return np.zeros_like(left) if is_rounding else left


def repeated_measures(values: np.ndarray) -> list[Test]:
    """Repeated-measures analysis of variance, as it is and with Greenhouse and Geisser's df.

    F is the variance between conditions over what is left when those between conditions and
    between persons are taken off. With two conditions it is the paired t test, ``F = t²``.

    Parameters
    ----------
    values
        Shape (n_persons, k), of two persons and two conditions at least, without NaN.

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
    """Greenhouse and Geisser's epsilon: 1 where all differences vary alike, 1 / (k - 1) at worst.

    ``tr(S)² / ((k - 1) tr(S²))``, S the covariance of the conditions less the persons' means; NaN
    without spread.
    """
    left = residuals(values)
    covariance = left.T @ left
    trace, squares = float(np.trace(covariance)), float((covariance**2).sum())
    if not squares:
        return np.nan
    epsilon: float = trace * trace / ((values.shape[1] - 1) * squares)
    return min(epsilon, 1.0)


def friedman(values: np.ndarray) -> Test:
    """Friedman's test of the ranks within each person, with ties; of three conditions or more."""
    if values.shape[1] < 3:
        return Test("friedman", reason="it needs three conditions")
    if not np.ptp(values, axis=1).any():
        return Test("friedman", reason="nobody's values differ between the conditions")
    chi2, p = scipy.stats.friedmanchisquare(*values.T)
    return Test("friedman", "chi2", float(chi2), values.shape[1] - 1.0, p=float(p))


def paired(values: np.ndarray, *, are_logs: bool) -> pd.DataFrame:
    """Paired t tests of all pairs of conditions, corrected by Holm; values of shape (n, k)."""
    n, k = values.shape
    first, second = pairs_of(k)
    apart = values[:, first] - values[:, second]
    sd = apart.std(axis=0, ddof=1)
    sd = np.where(sd > ROUNDING * np.abs(values).max(), sd, 0.0)
    return paired_t("paired", k, n, apart.mean(axis=0), sd, are_logs=are_logs)
