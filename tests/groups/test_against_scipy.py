"""SciPy and older code of ours as the independent reading, and cases countable by hand."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from bench.group_tests import CASES
from nvcore.evidence.bootstrap import ratio
from nvcore.evidence.groups.analyses import (
    Groups,
    anova,
    friedman,
    games_howell,
    paired,
    persons_for,
    power_of_f,
    repeated_measures,
    sphericity,
    t_interval,
    tukey,
    welch,
    welch_f,
)
from nvcore.evidence.groups.permutation import N_RANDOM, permute_between, permute_within
from nvcore.evidence.paired_tests import swap_test

RNG = np.random.default_rng(7)
SAMPLES = [RNG.normal(mean, sd, n) for mean, sd, n in ((5, 1, 9), (6, 2, 7), (8, 4, 12), (5, 1, 4))]
WIDE = RNG.normal(size=(8, 1)) + RNG.normal(size=(8, 3)) * [1, 2, 3] + [0.0, 0.5, 2.0]


def summarised(samples: list[np.ndarray]) -> Groups:
    parts = [(len(own), own.mean(), own.std(ddof=1) if len(own) > 1 else np.nan) for own in samples]
    return Groups(*np.array(parts, dtype=float).T)


def pairs_of(matrix: np.ndarray) -> list[float]:
    return [float(matrix[i, j]) for i in range(len(matrix)) for j in range(i + 1, len(matrix))]


# from summaries, as SciPy from the values


@pytest.mark.parametrize("n_groups", [2, 3, 4])
@pytest.mark.parametrize(("by_us", "equal"), [(anova, True), (welch, False)])
def test_analyses_of_variance_are_scipys(by_us: Callable[..., Any], equal: bool, n_groups: int):
    samples = SAMPLES[:n_groups]
    test = by_us(summarised(samples))
    expected = tuple(stats.f_oneway(*samples, equal_var=equal))
    assert (test.value, test.p) == pytest.approx(expected)


@pytest.mark.parametrize(("by_us", "equal"), [(tukey, True), (games_howell, False)])
def test_comparisons_of_pairs_are_scipys(by_us: Callable[..., Any], equal: bool):
    expected = stats.tukey_hsd(*SAMPLES[:3], equal_var=equal)
    pairs = by_us(summarised(SAMPLES[:3]))
    interval = expected.confidence_interval()
    for name, matrix in (
        ("p_corrected", expected.pvalue),
        ("difference", expected.statistic),
        ("low", interval.low),
        ("high", interval.high),
    ):
        assert pairs[name].tolist() == pytest.approx(pairs_of(matrix), abs=1e-6)


def test_an_interval_of_a_mean_is_students():
    interval = stats.ttest_1samp(SAMPLES[0], 0).confidence_interval(0.95)
    assert t_interval(SAMPLES[0].mean(), stats.sem(SAMPLES[0]), 9) == pytest.approx([*interval])


@pytest.mark.parametrize(("sizes", "sds"), CASES)
def test_welch_finds_no_difference_in_19_of_20_small_groups_of_equal_means(
    sizes: tuple[int, ...], sds: tuple[int, ...]
):
    rng, n = np.random.default_rng(54), np.array(sizes)
    drawn = [rng.normal(0, sd, (20_000, size)) for size, sd in zip(sizes, sds, strict=True)]
    f, df = welch_f(n, *moments(drawn))
    assert 0.03 <= np.mean(stats.f.sf(f, len(n) - 1, df) <= 0.05) <= 0.07


def test_effect_sizes_countable_by_hand():
    test = anova(Groups(np.array([3.0, 3]), np.array([1.0, 3]), np.array([1.0, 1])))
    # between 6 of 6 + 4; omega² (6 - 1) / (10 + 1); d = -2
    assert (test.eta2, test.omega2, test.f) == pytest.approx((0.6, 5 / 11, np.sqrt(1.5)))
    assert tukey(Groups(np.array([3.0, 3]), np.array([1.0, 3]), np.array([1.0, 1])))[
        "d"
    ].tolist() == [-2]


def test_groups_without_spread_have_no_test():
    flat = Groups(np.array([3.0, 3]), np.array([0.1, 0.3]), np.array([1e-17, 0]))
    assert np.isnan([anova(flat).p, welch(flat).p]).all()
    assert anova(flat).reason == "no group has any spread"
    for pairs in (tukey(flat), games_howell(flat)):
        assert pairs[["low", "p_corrected", "d"]].isna().all(axis=None)


def test_a_person_alone_has_no_variance_but_is_in_the_analysis():
    alone = [SAMPLES[0], SAMPLES[1], np.array([9.0])]
    groups = summarised(alone)
    assert anova(groups).p == pytest.approx(stats.f_oneway(*alone).pvalue)
    assert np.isnan(welch(groups).p)
    assert np.isnan(games_howell(groups)["p_corrected"]).tolist() == [False, True, True]


# permutation


@pytest.mark.parametrize(
    ("sizes", "n_ways"),
    [([2, 2, 2], 15), ([2, 3, 3], 280), ([2, 4], 15), ([1, 2, 3], 60), ([1, 1, 4], 15)],
)
def test_each_partition_is_listed_once(sizes: list[int], n_ways: int):
    orders, cuts = np.array([*permutations(RNG.normal(size=sum(sizes)))]), np.cumsum(sizes)[:-1]
    mean, variance = moments(np.split(orders, cuts, axis=1))
    has_welch = sizes[0] > 1
    f = welch_f(np.array(sizes), mean, variance)[0] if has_welch else (sizes * mean**2).sum(axis=1)
    test = permute_between(np.split(orders[0], cuts), has_welch=has_welch)
    assert test.n_ways == n_ways
    assert test.p == pytest.approx(np.mean(f >= f[0] - 1e-9))


def moments(parts: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and variance of each row in each part, shape (n_rows, n_parts)."""
    mean = np.stack([part.mean(axis=1) for part in parts], axis=1)
    squares = [((part.T - own) ** 2).sum(axis=0) for part, own in zip(parts, mean.T, strict=True)]
    return mean, np.transpose(squares) / [max(part.shape[1] - 1, 1) for part in parts]


@pytest.mark.parametrize("equal", [True, False])
def test_two_groups_are_scipys_permutation_test_of_t(equal: bool):
    x, y = np.array([4.0, 7, 2, 2, 3]), np.array([19.0, 7, 17])

    def t(x: np.ndarray, y: np.ndarray, axis: int) -> np.ndarray:
        return np.abs(stats.ttest_ind(x, y, equal_var=equal, axis=axis).statistic)

    expected = stats.permutation_test((x, y), t, n_resamples=np.inf, alternative="greater")
    assert permute_between([x, y], has_welch=not equal).p == pytest.approx(expected.pvalue)


@pytest.mark.parametrize(
    ("groups", "n_reached", "n_ways"),
    [
        # t² is 2² / (1 / 3) = 12 with 0 and 0 as a pair, 13 with 2 and 3, else less than 2
        ([[0.0, 0], [1.0, 2, 3]], 2, 10),
        ([[2.0, 3], [0.0, 0, 1]], 1, 10),
        # two different groups without variance: no other way comes near
        ([[0.0, 0], [1.0, 1]], 1, 3),
        # the mean of equal values is off by rounding
        ([[0.1] * 3, [0.3] * 3], 1, 10),
        # of all other ways, at most one group has equal values
        ([[0.0, 0], [1.0, 1], [2.0, 2]], 1, 15),
    ],
)
def test_groups_of_equal_values_are_counted_by_hand(
    groups: list[list[float]], n_reached: int, n_ways: int
):
    test = permute_between([np.array(own) for own in groups])
    assert (test.n_reached, test.n_ways, test.is_exact) == (n_reached, n_ways, True)


def test_ranks_without_ties_are_kruskal_and_mann_whitney_exactly():
    x, y = np.array([1.0, 2, 3, 6]), np.array([4.0, 5, 7, 8, 9])
    ranks = np.split(stats.rankdata([*x, *y]), [4])
    expected = stats.mannwhitneyu(x, y, method="exact").pvalue
    assert permute_between(ranks, has_welch=False).p == pytest.approx(expected)


def test_too_many_ways_are_drawn_and_the_same_every_time():
    x, y = RNG.normal(0, 1, 30), RNG.normal(0.8, 2, 25)
    test = permute_between([x, y])
    assert (test.n_ways, test.is_exact) == (N_RANDOM, False)
    assert test.p == pytest.approx(stats.ttest_ind(x, y, equal_var=False).pvalue, abs=0.01)
    assert permute_between([x, y]) == test
    assert permute_between([RNG.normal(size=n) for n in (2, 99)]).n_ways == N_RANDOM
    wide = RNG.normal([0, 0.5, 0.7], size=(12, 3))
    test = permute_within(wide)
    assert (test.n_ways, test.is_exact) == (N_RANDOM, False)
    assert test.p == pytest.approx(repeated_measures(wide)[0].p, abs=0.02)


def test_two_conditions_within_persons_are_the_exchange_of_systems():
    wide = RNG.normal([0, 0.9], size=(9, 2))
    x, y = (np.column_stack([own, np.ones(9)]) for own in wide.T)
    assert permute_within(wide).p == pytest.approx(swap_test(x, y, ratio).p)


def test_three_conditions_within_persons_by_hand():
    # all three agree: of 6 * 6 ways to order the second and the third person, one is as extreme
    test = permute_within(np.array([[1.0, 2, 3], [2.0, 4, 9], [0.0, 5, 6]]))
    assert (test.n_reached, test.n_ways) == (1, 36)


@pytest.mark.parametrize(
    ("groups", "reason"),
    [
        ([[1.0, 1], [1.0, 1, 1]], "there is nothing to exchange"),
        ([[1.0], [2.0], [3.0]], "there is nothing to exchange"),
        ([[1.0, 2]], "there is nothing to exchange"),
        ([[0.1] * 3, [0.1] * 3], "there is nothing to exchange"),
        ([[1.0], [2.0, 3.0]], "a group has one value alone"),
    ],
)
def test_what_cannot_be_exchanged_has_no_p(groups: list[list[float]], reason: str):
    test = permute_between([np.array(own) for own in groups])
    assert np.isnan(test.p)
    assert (test.n_ways, test.reason) == (0, reason)


def test_persons_who_do_not_differ_or_are_alone_have_no_p():
    for wide in (np.ones((4, 3)), np.array([[1.0, 2, 3]]), np.array([[0.1, 0.1], [0.3, 0.3]])):
        assert np.isnan(permute_within(wide).p)


values = st.integers(0, 9).map(float)


samples = st.lists(st.lists(values, min_size=1, max_size=3).map(np.array), min_size=2, max_size=4)


@given(samples)
@settings(max_examples=50, deadline=None)
def test_exchanged_groups_give_the_same_overall(groups: list[np.ndarray]):
    there, back = permute_between(groups), permute_between(groups[::-1])
    assert back.p == pytest.approx(there.p, nan_ok=True)
    summary = summarised(groups)
    for test in (anova, welch):
        turned = Groups(*(each[::-1] for each in summary))
        assert test(turned)[2:9] == pytest.approx(test(summary)[2:9], nan_ok=True)


@pytest.mark.parametrize("compare", [tukey, games_howell])
def test_exchanged_groups_mirror_the_pairs(compare: Callable[..., Any]):
    first = compare(summarised(SAMPLES[:3]))
    mirrored = compare(summarised(SAMPLES[2::-1])).iloc[::-1]
    for name in ("difference", "d"):
        assert (-mirrored[name]).tolist() == pytest.approx(first[name].tolist())
    for name in ("value", "p_corrected"):
        assert mirrored[name].tolist() == pytest.approx(first[name].tolist())
    assert (-mirrored["high"]).tolist() == pytest.approx(first["low"].tolist())


@given(st.lists(st.tuples(values, values, values), min_size=2, max_size=4))
@settings(max_examples=60, deadline=None)
def test_a_constant_for_each_person_changes_nothing(rows: list[tuple[float, float, float]]):
    wide = np.array(rows)
    moved = wide + 10 * np.arange(len(wide))[:, np.newaxis]
    assert permute_within(moved) == pytest.approx(permute_within(wide), nan_ok=True)
    for before, after in zip(repeated_measures(wide), repeated_measures(moved), strict=True):
        assert after[2:9] == pytest.approx(before[2:9], nan_ok=True, abs=1e-9)


# the same persons


def test_two_conditions_are_the_paired_t_test():
    two = WIDE[:, :2]
    expected = stats.ttest_rel(*two.T)
    for test in repeated_measures(two):
        assert (test.value, test.p) == pytest.approx((expected.statistic**2, expected.pvalue))
    pair = paired(two, are_logs=False).iloc[0]
    interval = expected.confidence_interval(0.95)
    assert (pair["value"], pair["p"]) == pytest.approx((expected.statistic, expected.pvalue))
    assert (pair["low"], pair["high"]) == pytest.approx((interval.low, interval.high))


def test_repeated_measures_countable_by_hand():
    # persons' means 2, 3; conditions' means 1.5, 2, 4; left over: rows +-(0, 0.5, 0.5)
    wide = np.array([[1.0, 2, 3], [2.0, 2, 5]])
    centred = wide - wide.mean(axis=1, keepdims=True)
    between = 2 * (centred.mean(axis=0) ** 2).sum()
    within = ((centred - centred.mean(axis=0)) ** 2).sum()
    test = repeated_measures(wide)[0]
    assert test.value == pytest.approx(between / 2 / (within / 2))
    assert (test.df_between, test.df_within) == (2, 2)
    assert test.eta2 == pytest.approx(between / (between + within))


def test_f_by_all_exchanges_is_that_of_repeated_measures():
    """Of ways listed one by one, with their F."""
    wide = np.array([[1.0, 2.5, 3], [2.0, 2, 5], [1.0, 4, 3.5]])
    f = [
        repeated_measures(np.array([wide[0], second, third]))[0].value
        for second in permutations(wide[1])
        for third in permutations(wide[2])
    ]
    expected = np.mean(np.array(f) >= repeated_measures(wide)[0].value - 1e-9)
    assert permute_within(wide).p == pytest.approx(expected)


def test_sphericity_is_1_where_all_differences_vary_alike_and_at_worst_a_half():
    assert sphericity(np.eye(3)) == pytest.approx(1)
    one_way = np.outer([1.0, 2, 4, 3], [1.0, 0, 0])
    assert sphericity(one_way) == pytest.approx(0.5)
    assert np.isnan(sphericity(np.ones((3, 3))))


def test_greenhouse_and_geissers_example():
    """Box (1954) and later books: epsilon by the formula of the covariance's own elements."""
    s, k = np.cov(WIDE, rowvar=False), 3
    top = k**2 * (np.trace(s) / k - s.mean()) ** 2
    bottom = (k - 1) * ((s**2).sum() - 2 * k * (s.mean(axis=1) ** 2).sum() + k**2 * s.mean() ** 2)
    assert sphericity(WIDE) == pytest.approx(top / bottom)


def test_friedman_is_scipys_and_needs_three_conditions_that_differ():
    assert friedman(WIDE).p == pytest.approx(stats.friedmanchisquare(*WIDE.T).pvalue)
    assert friedman(WIDE[:, :2]).reason == "it needs three conditions"
    assert np.isnan(friedman(np.ones((3, 3))).p)


def test_logarithms_give_ratios():
    pair = paired(np.log(np.array([[1.0, 2], [2.0, 5], [1.0, 3]])), are_logs=True).iloc[0]
    assert pair["ratio"] == pytest.approx((1 / 2 * 2 / 5 * 1 / 3) ** (1 / 3))
    assert pair["ratio_low"] < pair["ratio"] < pair["ratio_high"]
    assert np.isnan(pair["difference"])


def test_persons_who_all_differ_alike_have_no_test():
    wide = np.array([[1.1, 2.1, 3.1], [2.3, 3.3, 4.3]])
    assert all(np.isnan(test.p) for test in repeated_measures(wide))
    assert paired(wide, are_logs=False)[["p", "p_corrected", "low"]].isna().all(axis=None)


# the size of a study


@pytest.mark.parametrize(
    ("effect", "power", "n"), [(0.2, 0.8, 394), (0.5, 0.8, 64), (0.8, 0.8, 26), (0.5, 0.95, 105)]
)
def test_two_groups_need_cohens_numbers(effect: float, power: float, n: int):
    """Cohen (1988), table 2.4.1, two-sided 0.05; 394 and 105: G*Power 3.1."""
    assert persons_for(power, effect, lambda n: power_of_f(effect / 2, n, 2, 0.05)) == n


def test_pairs_and_three_groups_need_g_powers_numbers():
    """G*Power 3.1: t of dependent means, d 0.5: 34; one-way ANOVA, f 0.25, three groups: 159."""
    assert persons_for(0.8, 0.5, lambda n: power_of_f(0.5, n, 1, 0.05)) == 34
    assert persons_for(0.8, 0.25, lambda n: power_of_f(0.25, n, 3, 0.05)) == 159 / 3


def test_no_effect_needs_no_size_a_huge_one_two_persons_and_a_tiny_one_none():
    def power(n: int) -> float:
        return power_of_f(1e-3 / 2, n, 2, 0.05)

    assert np.isnan(persons_for(0.8, 0.0, power))
    assert np.isnan(persons_for(0.8, np.nan, power))
    assert np.isnan(persons_for(0.8, 1e-3, power))
    assert persons_for(0.8, 50.0, power) == 2
    assert persons_for(0.5, 15.0, lambda n: power_of_f(15.0 / 2, n, 2, 0.05)) == 2
    # a tail of 1e-17, which SciPy's nct.cdf does not give, is no reason for a sixth person
    d = 3.3344079450707564
    assert persons_for(0.8, d, lambda n: power_of_f(d, n, 1, 0.005)) == 5


def test_tables_of_pairs_have_one_form():
    assert [*tukey(summarised(SAMPLES))] == [*paired(WIDE, are_logs=False)]
    assert isinstance(tukey(summarised(SAMPLES[:1])), pd.DataFrame)
