"""Whether people agree: ranks of each participant, Kendall's W, and who goes another way."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
import pandas as pd
from scipy import stats

CLIP: Final = ["clip", "system"]
LEAST_CLIPS: Final = 3
"""Two participants, or a participant and the others, are compared over at least so many clips."""
N_PERMUTATIONS: Final = 2_000
SEED: Final = 20_110_360
FENCE: Final = 1.5
"""Outliers lie so many interquartile ranges below the lower quartile (Tukey)."""


@dataclass(frozen=True)
class Agreement:
    """How far participants rank clips alike.

    Attributes
    ----------
    n_participants, n_clips, n_missing
        Counts; missing are the ratings that the table of both would have and has not.
    w
        Kendall's coefficient of concordance, corrected for ties: 0 no agreement, 1 the same
        ranks; NaN with fewer than two participants or three clips.
    p
        How often ranks by chance would agree as much. NaN where `w` is.
    method
        Where `w` and `p` are from, or why there are none, in words.
    participants
        Per participant: ``participant``, ``n_rated``, ``agreement`` (Spearman's correlation with
        the mean rank that the others give; NaN: too few clips) and ``is_outlier``.
    """

    n_participants: int
    n_clips: int
    n_missing: int
    w: float
    p: float
    method: str
    participants: pd.DataFrame


def rank_ratings(ratings: pd.DataFrame) -> pd.DataFrame:
    """Ranks of each participant, 1 for the least annoying clip, ties averaged.

    Parameters
    ----------
    ratings
        Of `read_ratings`.

    Returns
    -------
    One row for each participant, one column for each clip (levels ``clip``, ``system``), NaN
    where a rating is missing. Who rated m of n clips has ranks stretched from 1..m to 1..n, so
    that all may be averaged: ``(rank - 0.5) * n / m + 0.5``.
    """
    wide = ratings.dropna(subset="rating").pivot_table(
        index="participant", columns=CLIP, values="rating", aggfunc="first"
    )
    ranks = wide.rank(axis=1, method="average")
    stretch = wide.shape[1] / wide.notna().sum(axis=1)
    return ranks.sub(0.5).mul(stretch, axis=0).add(0.5)


def measure_agreement(ranks: pd.DataFrame) -> Agreement:
    """Kendall's W of ranks from `rank_ratings`, and each participant's agreement with the others.

    Notes
    -----
    Without missing ratings W is that of the Friedman test, chi2 = m (n - 1) W, with its p-value.
    With missing ones it is ``(1 + (m - 1) r) / m``, r the mean of Spearman's correlations of all
    pairs of participants over the clips that both rated (without ties and gaps the two are the
    same), and p is from ranks shuffled within each participant.
    """
    values = ranks.to_numpy(dtype=float)
    m, n = values.shape
    missing = int(np.isnan(values).sum())
    w, p, method = _concordance(values)
    return Agreement(m, n, missing, w, p, method, _participants(ranks))


def _concordance(values: np.ndarray) -> tuple[float, float, str]:
    m, n = values.shape
    if m < 2 or n < LEAST_CLIPS:
        return np.nan, np.nan, "agreement needs two participants and three clips at least"
    if (np.nanmax(values, axis=1) == np.nanmin(values, axis=1)).all():
        return np.nan, np.nan, "nobody tells one clip from another"
    if not np.isnan(values).any():
        chi2, p = stats.friedmanchisquare(*values.T)
        return float(chi2) / (m * (n - 1)), float(p), "Friedman test, corrected for ties"
    found = _mean_correlation(values)
    if np.isnan(found):
        return np.nan, np.nan, "no two participants rated three clips in common"
    rng = np.random.default_rng(SEED)
    by_chance = np.array([_mean_correlation(_shuffled(values, rng)) for _ in range(N_PERMUTATIONS)])
    p = (1 + np.count_nonzero(by_chance >= found - 1e-12)) / (1 + N_PERMUTATIONS)
    text = f"mean correlation of pairs, {N_PERMUTATIONS:,} permutations, seed {SEED}"
    return (1 + (m - 1) * found) / m, p, text


def _shuffled(values: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The ranks of each participant in another order, the missing ones where they are."""
    mixed = values.copy()
    for row in mixed:
        is_rated = ~np.isnan(row)
        row[is_rated] = rng.permutation(row[is_rated])
    return mixed


def _mean_correlation(values: np.ndarray) -> float:
    """Mean of Spearman's correlations of the pairs with enough clips in common."""
    known = ~np.isnan(values)
    if known.all():
        return _mean_of_pairs(np.corrcoef(values))
    pairs = [_spearman(a, b) for a, b in combinations(values, 2)]
    usable = [r for r in pairs if not np.isnan(r)]
    return float(np.mean(usable)) if usable else np.nan


def _mean_of_pairs(matrix: np.ndarray) -> float:
    return float(np.nanmean(matrix[np.triu_indices(len(matrix), 1)]))


def _spearman(a: np.ndarray, b: np.ndarray) -> float:
    """Spearman's correlation over what both have; NaN if that is too little or all the same."""
    both = ~np.isnan(a) & ~np.isnan(b)
    if np.count_nonzero(both) < LEAST_CLIPS:
        return np.nan
    one, other = stats.rankdata(a[both]), stats.rankdata(b[both])
    if np.ptp(one) == 0 or np.ptp(other) == 0:
        return np.nan
    return float(np.corrcoef(one, other)[0, 1])


def _participants(ranks: pd.DataFrame) -> pd.DataFrame:
    values = ranks.to_numpy(dtype=float)
    agreement = np.full(len(values), np.nan)
    for i in range(len(values)):
        others = np.delete(values, i, axis=0)
        rated = ~np.isnan(others).all(axis=0)
        mean = np.full(values.shape[1], np.nan)
        mean[rated] = np.nanmean(others[:, rated], axis=0)
        agreement[i] = _spearman(values[i], mean)
    known = agreement[~np.isnan(agreement)]
    low, high = np.percentile(known, [25, 75]) if len(known) else (np.nan, np.nan)
    return pd.DataFrame(
        {
            "participant": ranks.index.to_numpy(),
            "n_rated": np.count_nonzero(~np.isnan(values), axis=1),
            "agreement": agreement,
            "is_outlier": (agreement <= 0) | (agreement < low - FENCE * (high - low)),
        }
    )
