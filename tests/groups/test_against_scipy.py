"""SciPy and older code of ours as the independent reading, and cases countable by hand."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from nvcore.evidence.bootstrap import ratio
from nvcore.evidence.paired_tests import swap_test
from nvcore.group_statistics.permutation import (
    N_RANDOM,
    n_partitions,
    permute_between,
    permute_within,
)
from nvcore.group_statistics.repeated import friedman, paired, repeated_measures, sphericity
from nvcore.group_statistics.sample_size import persons_for, power_of_anova, power_of_t
from nvcore.group_statistics.summaries import (
    Groups,
    anova,
    games_howell,
    mean_interval,
    tukey,
    welch,
)

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
def test_analyses_of_variance_are_scipys(n_groups: int):
    samples = SAMPLES[:n_groups]
    test = anova(summarised(samples))
    assert (test.value, test.p) == pytest.approx(tuple(stats.f_oneway(*samples)))
    expected = tuple(stats.f_oneway(*samples, equal_var=False))
    test = welch(summarised(samples))
    assert (test.value, test.p) == pytest.approx(expected)


@pytest.mark.parametrize("equal", [True, False])
def test_comparisons_of_pairs_are_scipys(equal: bool):
    expected = stats.tukey_hsd(*SAMPLES, equal_var=equal)
    pairs = (tukey if equal else games_howell)(summarised(SAMPLES))
    interval = expected.confidence_interval()
    for name, matrix in (
        ("p_corrected", expected.pvalue),
        ("difference", expected.statistic),
        ("low", interval.low),
        ("high", interval.high),
    ):
        assert pairs[name].tolist() == pytest.approx(pairs_of(matrix), abs=1e-6)


def test_two_groups_are_students_and_welchs_t_test():
    two = SAMPLES[:2]
    for test, equal in ((anova, True), (welch, False)):
        expected = stats.ttest_ind(*two, equal_var=equal)
        assert test(summarised(two)).value == pytest.approx(expected.statistic**2)
        assert test(summarised(two)).p == pytest.approx(expected.pvalue)


def test_an_interval_of_a_mean_is_students():
    low, high = mean_interval(summarised(SAMPLES))
    expected = stats.ttest_1samp(SAMPLES[0], 0).confidence_interval(0.95)
    assert (low[0], high[0]) == pytest.approx((expected.low, expected.high))


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


def test_a_partition_is_listed_once():
    assert n_partitions([3, 3, 3, 3]) == 15_400
    assert n_partitions([2, 3, 3]) == 8 * 7 // 2 * 20 // 2
    for sizes in ([2, 2, 2], [1, 2, 3], [1, 1, 4]):
        values = RNG.normal(size=sum(sizes))
        groups = np.split(values, np.cumsum(sizes)[:-1])
        test = permute_between(groups)
        named = [np.split(np.array(order), np.cumsum(sizes)[:-1])
                 for order in permutations(values)]  # fmt: skip
        f = np.array([anova_f(parts) for parts in named])
        assert test.n_ways == n_partitions(sizes)
        assert test.p == pytest.approx(np.mean(f >= anova_f(groups) - 1e-9))


def anova_f(groups: list[np.ndarray]) -> float:
    every = np.concatenate(groups)
    return sum(len(own) * (own.mean() - every.mean()) ** 2 for own in groups)


def test_two_groups_are_scipys_permutation_test_of_the_difference():
    x, y = np.array([4.0, 7, 2, 2, 3]), np.array([19.0, 7, 17])

    def size(x: np.ndarray, y: np.ndarray, axis: int) -> np.ndarray:
        return np.abs(x.mean(axis=axis) - y.mean(axis=axis))

    expected = stats.permutation_test((x, y), size, n_resamples=np.inf, alternative="greater")
    assert permute_between([x, y]).p == pytest.approx(expected.pvalue)


def test_ranks_without_ties_are_kruskal_and_mann_whitney_exactly():
    x, y = np.array([1.0, 2, 3, 6]), np.array([4.0, 5, 7, 8, 9])
    ranks = np.split(stats.rankdata([*x, *y]), [4])
    expected = stats.mannwhitneyu(x, y, method="exact").pvalue
    assert permute_between(ranks).p == pytest.approx(expected)


def test_too_many_ways_are_drawn_and_the_same_every_time():
    x, y = RNG.normal(0, 1, 30), RNG.normal(0.8, 1, 25)
    test = permute_between([x, y])
    assert (test.n_ways, test.is_exact) == (N_RANDOM, False)
    assert test.p == pytest.approx(stats.ttest_ind(x, y).pvalue, abs=0.01)
    assert permute_between([x, y]) == test
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
    "groups", [[[1.0, 1], [1.0, 1, 1]], [[1.0], [2.0], [3.0]], [[1.0, 2]], [[0.1] * 3, [0.1] * 3]]
)
def test_what_cannot_be_exchanged_has_no_p(groups: list[list[float]]):
    test = permute_between([np.array(own) for own in groups])
    assert np.isnan(test.p)
    assert test.n_ways == 0


def test_persons_who_do_not_differ_or_are_alone_have_no_p():
    for wide in (np.ones((4, 3)), np.array([[1.0, 2, 3]]), np.array([[0.1, 0.1], [0.3, 0.3]])):
        assert np.isnan(permute_within(wide).p)


values = st.integers(0, 9).map(float)


samples = st.lists(st.lists(values, min_size=1, max_size=3).map(np.array), min_size=2, max_size=4)


@given(samples)
@settings(max_examples=50, deadline=None)
def test_exchanged_groups_give_the_same_overall(samples: list[np.ndarray]):
    there, back = permute_between(samples), permute_between(samples[::-1])
    assert there == pytest.approx(back, nan_ok=True)
    summary = summarised(samples)
    for test in (anova, welch):
        turned = Groups(*(each[::-1] for each in summary))
        assert test(turned)[2:9] == pytest.approx(test(summary)[2:9], nan_ok=True)


@given(samples)
@settings(max_examples=5, deadline=None)  # SciPy's quantiles of the studentised range take long
def test_exchanged_groups_mirror_the_pairs(samples: list[np.ndarray]):
    summary = summarised(samples)
    for compare in (tukey, games_howell):
        first, second = compare(summary), compare(Groups(*(each[::-1] for each in summary)))
        k = len(samples) - 1
        mirrored = second.assign(first=k - second["second"], second=k - second["first"])
        mirrored = mirrored.sort_values(["first", "second"])
        for name in ("difference", "d"):
            assert (-mirrored[name]).tolist() == pytest.approx(first[name].tolist(), nan_ok=True)
        for name in ("value", "p_corrected"):
            assert mirrored[name].tolist() == pytest.approx(first[name].tolist(), nan_ok=True)
        assert (-mirrored["high"]).tolist() == pytest.approx(first["low"].tolist(), nan_ok=True)


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
    assert persons_for(power, effect, lambda n: power_of_t(effect, n, 0.05, is_paired=False)) == n


def test_pairs_and_three_groups_need_g_powers_numbers():
    """G*Power 3.1: t of dependent means, d 0.5: 34; one-way ANOVA, f 0.25, three groups: 159."""
    assert persons_for(0.8, 0.5, lambda n: power_of_t(0.5, n, 0.05, is_paired=True)) == 34
    assert persons_for(0.8, 0.25, lambda n: power_of_anova(0.25, n, 3, 0.05)) == 159 / 3


def test_no_effect_needs_no_size_a_huge_one_two_persons_and_a_tiny_one_none():
    def power(n: int) -> float:
        return power_of_t(1e-3, n, 0.05, is_paired=False)

    assert np.isnan(persons_for(0.8, 0.0, power))
    assert np.isnan(persons_for(0.8, np.nan, power))
    assert np.isnan(persons_for(0.8, 1e-3, power))
    assert persons_for(0.8, 50.0, power) == 2
    assert persons_for(0.5, 15.0, lambda n: power_of_t(15.0, n, 0.05, is_paired=False)) == 2


def test_tables_of_pairs_have_one_form():
    assert [*tukey(summarised(SAMPLES))] == [*paired(WIDE, are_logs=False)]
    assert isinstance(tukey(summarised(SAMPLES[:1])), pd.DataFrame)
