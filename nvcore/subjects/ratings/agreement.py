"""Agreement between people: ranks of each participant, Kendall's W, and outliers."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Final

import numpy as np
import pandas as pd
import scipy

CLIP: Final = ["clip", "system"]
LEAST_CLIPS: Final = 3
"""Fewest common clips for comparing two participants, or a participant with the others."""
LEAST_FOR_OUTLIERS: Final = 4
"""Fewest participants for finding outliers."""
CHANCE: Final = 0.05
"""Agreement with a p-value below this is more than chance."""
N_PERMUTATIONS: Final = 2_000
SEED: Final = 20_110_360
BATCH_CELLS: Final = 2_000_000
"""Ranks processed at a time, which limits the memory of the permutations."""
FENCE: Final = 1.5
"""Outliers lie more than this many interquartile ranges below the lower quartile (Tukey)."""


@dataclass(frozen=True)
class Agreement:
    """Similarity of the participants' ranks of clips.

    Attributes
    ----------
    n_participants, n_clips, n_missing
        Counts; missing: pairs of participant and clip without a rating.
    w
        Kendall's coefficient of concordance, corrected for ties: 0 no agreement, 1 the same
        ranks; NaN with fewer than two participants or three clips.
    p
        Probability that random ranks agree as much. NaN if `w` is.
    method
        Method of computing `w` and `p`, or the reason for having none, in words.
    participants
        Per participant: ``participant``, ``n_rated``, ``agreement`` (Spearman's correlation with
        the mean rank that the others give; NaN: too few clips) and ``is_outlier``, which is False
        for all unless `knows_outliers`.
    """

    n_participants: int
    n_clips: int
    n_missing: int
    w: float
    p: float
    method: str
    participants: pd.DataFrame

    @property
    def is_more_than_chance(self) -> bool:
        """Whether the participants agree more than random ranks would."""
        return bool(self.p < CHANCE)

    @property
    def knows_outliers(self) -> bool:
        """Whether there are enough participants, with enough agreement, to find outliers."""
        return self.n_participants >= LEAST_FOR_OUTLIERS and self.is_more_than_chance


def rank_ratings(ratings: pd.DataFrame) -> pd.DataFrame:
    """Rank the clips of each participant, 1 for the least annoying clip, ties averaged.

    Parameters
    ----------
    ratings
        Table from `read_ratings`.

    Returns
    -------
    One row for each participant, one column for each clip (levels ``clip``, ``system``), NaN if a
    rating is missing. The ranks of a participant who rated m of n clips are stretched from 1..m to
    1..n, so that all may be averaged: ``(rank - 0.5) * n / m + 0.5``.
    """
    wide = ratings.dropna(subset="rating").pivot_table(
        index="participant", columns=CLIP, values="rating", aggfunc="first"
    )
    ranks = wide.rank(axis=1, method="average")
    stretch = wide.shape[1] / wide.notna().sum(axis=1)
    return ranks.sub(0.5).mul(stretch, axis=0).add(0.5)


def measure_agreement(ranks: pd.DataFrame) -> Agreement:
    """Compute Kendall's W of ranks from `rank_ratings`, and each participant's agreement.

    A participant's agreement is that with the mean of the others.

    Notes
    -----
    Without missing ratings W is that of the Friedman test, chi2 = m (n - 1) W, with its p-value.
    With missing ones it is ``(1 + (m - 1) r) / m``, r the mean of Spearman's correlations of all
    pairs of participants over the clips that both rated (without ties and gaps the two are the
    same), and p is from ranks shuffled within each participant.
    """
    values = ranks.to_numpy(dtype=float)
    m, n = values.shape
    n_missing = int(np.isnan(values).sum())
    w, p, method = _concordance(values)
    agreement = Agreement(m, n, n_missing, w, p, method, _participants(ranks))
    if not agreement.knows_outliers:
        agreement.participants["is_outlier"] = False
    return agreement


def _concordance(values: np.ndarray) -> tuple[float, float, str]:
    m, n = values.shape
    if m < 2 or n < LEAST_CLIPS:
        return np.nan, np.nan, "agreement needs two participants and three clips at least"
    if (np.nanmax(values, axis=1) == np.nanmin(values, axis=1)).all():
        return np.nan, np.nan, "nobody tells one clip from another"
    if not np.isnan(values).any():
        chi2, p = scipy.stats.friedmanchisquare(*values.T)
        return float(chi2) / (m * (n - 1)), float(p), "Friedman test, corrected for ties"
    correlation = float(_mean_correlations(values[None])[0])
    if np.isnan(correlation):
        return np.nan, np.nan, "no two participants rated three clips in common"
    rng = np.random.default_rng(SEED)
    batch = int(np.clip(BATCH_CELLS // values.size, 1, N_PERMUTATIONS))
    sizes = [min(batch, N_PERMUTATIONS - k) for k in range(0, N_PERMUTATIONS, batch)]
    by_chance = np.concatenate([_mean_correlations(_shuffle(values, k, rng)) for k in sizes])
    p = (1 + np.count_nonzero(by_chance >= correlation - 1e-12)) / (1 + N_PERMUTATIONS)
    text = f"mean correlation of pairs, {N_PERMUTATIONS:,} permutations, seed {SEED}"
    return (1 + (m - 1) * correlation) / m, p, text


def _shuffle(values: np.ndarray, n_times: int, rng: np.random.Generator) -> np.ndarray:
    """Shuffle the ranks of each participant, keeping missing ones in place.

    Shape (n_times, participants, clips).
    """
    shuffles = np.repeat(values[None], n_times, axis=0)
    for i, row in enumerate(values):
        is_rated = ~np.isnan(row)
        shuffles[:, i, is_rated] = rng.permuted(shuffles[:, i, is_rated], axis=1)
    return shuffles


def _mean_correlations(tables: np.ndarray) -> np.ndarray:
    """Return the mean of Spearman's correlations over all pairs with enough common clips, by table.

    Pairs with the same common clips are summed at once, because the sum of all products of
    standardised ranks is the product of their sums.

    Parameters
    ----------
    tables
        Ranks, NaN in the same places of all tables; float64, (tables, participants, clips).
    """
    is_rated = ~np.isnan(tables[0])
    patterns, member = np.unique(is_rated, axis=0, return_inverse=True)
    total, n_pairs = np.zeros(len(tables)), np.zeros(len(tables))
    for p, q in combinations_with_replacement(range(len(patterns)), 2):
        is_common = patterns[p] & patterns[q]
        if np.count_nonzero(is_common) < LEAST_CLIPS:
            continue
        sum_p, n_p = _sum_ranks(tables[:, member == p][:, :, is_common])
        if p == q:  # leave out each with itself
            total += 0.5 * ((sum_p * sum_p).sum(axis=1) - n_p)
            n_pairs += 0.5 * n_p * (n_p - 1)
        else:
            sum_q, n_q = _sum_ranks(tables[:, member == q][:, :, is_common])
            total += (sum_p * sum_q).sum(axis=1)
            n_pairs += n_p * n_q
    mean = np.full(len(tables), np.nan)
    np.divide(total, n_pairs, out=mean, where=n_pairs > 0)
    return mean


def _sum_ranks(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sum standardised ranks over participants, and count those who rank clips differently."""
    ranks = scipy.stats.rankdata(values, axis=2)
    ranks -= ranks.mean(axis=2, keepdims=True)
    length = np.sqrt((ranks * ranks).sum(axis=2, keepdims=True))
    standard = np.divide(ranks, length, out=np.zeros_like(ranks), where=length > 0)
    return standard.sum(axis=1), (length[:, :, 0] > 0).sum(axis=1)


def _participants(ranks: pd.DataFrame) -> pd.DataFrame:
    values = ranks.to_numpy(dtype=float)
    agreement = np.full(len(values), np.nan)
    for i in range(len(values)):
        others = np.delete(values, i, axis=0)
        is_rated = ~np.isnan(others).all(axis=0)
        mean = np.full(values.shape[1], np.nan)
        mean[is_rated] = np.nanmean(others[:, is_rated], axis=0)
        both = pd.DataFrame({"own": values[i], "others": mean})
        agreement[i] = both.corr("spearman", min_periods=LEAST_CLIPS).iloc[0, 1]
    defined = agreement[~np.isnan(agreement)]
    low, high = np.percentile(defined, [25, 75]) if len(defined) else (np.nan, np.nan)
    return pd.DataFrame(
        {
            "participant": ranks.index.to_numpy(),
            "n_rated": np.count_nonzero(~np.isnan(values), axis=1),
            "agreement": agreement,
            "is_outlier": (agreement <= 0) | (agreement < low - FENCE * (high - low)),
        }
    )
