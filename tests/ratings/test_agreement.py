"""Ranks and Kendall's W: hand-made cases, the textbook's formula, missing ratings."""

import numpy as np
import pandas as pd
import pytest
from rating_tables import table
from scipy import stats

from nvcore.subjects.ratings.agreement import measure_agreement, rank_ratings


def textbook_w(ratings):
    """W corrected for ties, as in Siegel & Castellan, 1988, 9.6."""
    ranks = pd.DataFrame(ratings).rank(axis=1).to_numpy()
    m, n = ranks.shape
    ties = sum(
        (count**3 - count) for row in ranks for count in np.unique(row, return_counts=True)[1]
    )
    sums = ranks.sum(axis=0)
    above = 12 * (sums**2).sum() - 3 * m**2 * n * (n + 1) ** 2
    return above / (m**2 * n * (n**2 - 1) - m * ties)


def test_ranks_average_ties():
    ranks = rank_ratings(table([[1, 5, 5, 7]]))
    np.testing.assert_allclose(ranks.to_numpy(), [[1, 2.5, 2.5, 4]])


def test_ranks_of_who_rated_half_of_the_clips_span_the_same_scale():
    ranks = rank_ratings(table([[1, 2, 3, 4], [1, np.nan, 2, np.nan]]))
    np.testing.assert_allclose(ranks.to_numpy()[1], [1.5, np.nan, 3.5, np.nan])
    assert np.nanmean(ranks.to_numpy()[1]) == np.nanmean(ranks.to_numpy()[0])


def test_who_rated_nothing_is_left_out():
    ranks = rank_ratings(table([[1, 2, 3], [np.nan] * 3]))
    assert ranks.index.tolist() == ["P0"]


def test_same_ranks_agree_fully_and_opposite_ones_not_at_all():
    same = measure_agreement(rank_ratings(table([[1, 2, 3, 4], [10, 20, 30, 41]])))
    opposite = measure_agreement(rank_ratings(table([[1, 2, 3, 4], [4, 3, 2, 1]])))
    assert same.w == pytest.approx(1)
    assert opposite.w == pytest.approx(0)
    assert (same.n_participants, same.n_clips, same.n_missing) == (2, 4, 0)


@pytest.mark.parametrize("seed", range(5))
def test_w_is_the_textbooks_with_ties(seed):
    ratings = np.random.default_rng(seed).integers(1, 6, (6, 9)).astype(float)
    assert measure_agreement(rank_ratings(table(ratings))).w == pytest.approx(textbook_w(ratings))


def test_p_of_chance_is_spread_evenly():
    rng = np.random.default_rng(1)
    p = [measure_agreement(rank_ratings(table(rng.random((5, 12))))).p for _ in range(40)]
    assert 0.02 <= np.mean(np.array(p) < 0.1) <= 0.18


def test_who_goes_the_other_way_is_an_outlier():
    rng = np.random.default_rng(2)
    clips = np.arange(10.0)
    ratings = [*(clips + rng.normal(0, 1, 10) for _ in range(7)), -clips]
    people = measure_agreement(rank_ratings(table(ratings))).participants
    assert people["is_outlier"].tolist() == [False] * 7 + [True]
    assert people["agreement"].iloc[-1] < -0.8
    assert people["n_rated"].tolist() == [10] * 8


@pytest.mark.parametrize("n", [2, 3])
def test_nobody_is_an_outlier_among_few(n):
    clips = np.arange(12.0)
    ratings = [*(clips for _ in range(n - 1)), -clips]
    agreement = measure_agreement(rank_ratings(table(ratings)))
    assert agreement.participants["agreement"].min() < 0
    assert not agreement.knows_outliers
    assert not agreement.participants["is_outlier"].any()


def test_nobody_is_an_outlier_where_people_agree_by_chance_only():
    ratings = np.random.default_rng(11).random((6, 8))
    agreement = measure_agreement(rank_ratings(table(ratings)))
    assert agreement.p > 0.05
    assert (agreement.participants["agreement"] <= 0).any()
    assert not agreement.is_more_than_chance
    assert not agreement.participants["is_outlier"].any()


@pytest.mark.parametrize(
    ("ratings", "words"),
    [
        ([[1, 2, 3, 4]], "two participants"),
        ([[1, 2], [1, 2]], "three clips"),
        ([[4, 4, 4], [2, 2, 2]], "nobody tells"),
        ([[1, 2, 3, np.nan, np.nan], [np.nan, np.nan, 1, 2, 3]], "three clips in common"),
    ],
)
def test_undefined_agreement_says_why(ratings, words):
    agreement = measure_agreement(rank_ratings(table(ratings)))
    assert np.isnan(agreement.w)
    assert np.isnan(agreement.p)
    assert words in agreement.method


def test_w_with_gaps_is_that_of_all_pairs_one_by_one():
    rng = np.random.default_rng(4)
    ratings = rng.integers(1, 5, (9, 8)).astype(float)
    ratings[rng.random(ratings.shape) < 0.3] = np.nan
    ratings[3] = 2.0  # tells no clip from another
    correlations = []
    for i in range(9):
        for j in range(i):
            both = ~np.isnan(ratings[i]) & ~np.isnan(ratings[j])
            own, theirs = ratings[i, both], ratings[j, both]
            if both.sum() >= 3 and np.ptp(own) > 0 and np.ptp(theirs) > 0:
                correlations.append(stats.spearmanr(own, theirs).statistic)
    expected = (1 + 8 * np.mean(correlations)) / 9
    assert measure_agreement(rank_ratings(table(ratings))).w == pytest.approx(expected)


def test_agreement_of_forty_people_with_gaps_is_there_at_once():
    rng = np.random.default_rng(5)
    ratings = np.arange(20.0) + rng.normal(0, 2.5, (40, 20))
    ratings[rng.integers(0, 40, 6), rng.integers(0, 20, 6)] = np.nan
    ranks = rank_ratings(table(ratings))
    assert measure_agreement(ranks).p == pytest.approx(1 / 2001)  # one by one: minutes
