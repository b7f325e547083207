from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import permutation_test

from nvcore.evidence.bootstrap import ratio
from nvcore.evidence.paired_tests import (
    Paired,
    SwapTest,
    holm,
    mcnemar,
    step_down,
    swap_test,
    swap_tests,
)
from nvcore.metrics.venn import Venn


def venn(both: int, x_only: int, y_only: int, neither: int) -> Venn:
    return Venn(both=both, x_only=x_only, y_only=y_only, neither=neither, distant=0)


@pytest.mark.parametrize(
    ("counts", "low", "high"),
    [
        # Newcombe (1998), Statistics in Medicine 17:2635, table II, method 10
        ((36, 12, 2, 0), 0.0569, 0.3404),
        ((18, 12, 2, 18), 0.0562, 0.3290),
        # Fagerland, Lydersen and Laake (2014): airway reactivity of 21 children
        ((1, 1, 7, 12), -0.507, -0.026),
    ],
)
def test_the_interval_of_paired_shares_is_as_published(
    counts: tuple[int, int, int, int], low: float, high: float
) -> None:
    test = mcnemar(venn(*counts))
    assert (test.low, test.high) == (
        pytest.approx(low, abs=5e-4 if low < 0 else 6e-5),
        pytest.approx(high, abs=5e-4 if low < 0 else 6e-5),
    )


def test_the_exact_p_and_the_odds_ratio_are_as_published() -> None:
    # two culture media, Armitage and Berry (1994), p. 127, after Liddell (1983):
    # R' = 6, exact 95 % interval 1.335744 to 55.197091, two-sided p = 0.0129
    assert mcnemar(venn(1, 1, 7, 12)).p == pytest.approx(0.0703, abs=5e-5)  # Fagerland's children
    test = mcnemar(venn(20, 12, 2, 16))
    assert test.p == pytest.approx(0.0129, abs=5e-5)
    assert test.odds_ratio == pytest.approx(6)
    assert test.odds_low == pytest.approx(1.335744, abs=1e-6)
    assert test.odds_high == pytest.approx(55.197091, abs=1e-5)
    assert test.difference == pytest.approx(0.2)
    assert test.reason == ""


def test_swapping_x_and_y_turns_the_sign_and_inverts_the_odds() -> None:
    there, back = mcnemar(venn(20, 12, 3, 16)), mcnemar(venn(20, 3, 12, 16))
    assert there.difference == -back.difference
    assert (there.low, there.high) == (pytest.approx(-back.high), pytest.approx(-back.low))
    assert there.p == back.p
    assert there.odds_low == pytest.approx(1 / back.odds_high)
    assert there.odds_high == pytest.approx(1 / back.odds_low)


def test_few_discordant_encounters_have_words_instead_of_a_p_value() -> None:
    test = mcnemar(venn(40, 5, 0, 5))
    assert np.isnan(test.p)
    assert "X and Y differ in too few encounters for a test: 5" in test.reason
    assert test.low < 0.1 < test.high
    assert not np.isnan(mcnemar(venn(40, 6, 0, 5)).p)
    assert mcnemar(venn(40, 6, 0, 5)).p == pytest.approx(2 / 2**6)


def test_few_encounters_have_words_instead_of_an_interval() -> None:
    test = mcnemar(venn(2, 7, 0, 0))
    assert np.isnan([test.low, test.high]).all()
    assert test.reason == "too few encounters for an interval: 9, at least 10 are needed"
    assert test.odds_ratio == np.inf
    assert test.odds_low > 1


def test_without_encounters_nothing_is_invented() -> None:
    test = mcnemar(venn(0, 0, 0, 0))
    numbers = (test.share_x, test.share_y, test.difference, test.low, test.high, test.p,
               test.odds_ratio, test.odds_low, test.odds_high)  # fmt: skip
    assert np.isnan(numbers).all()
    assert test.n == 0


def test_without_discordant_encounters_there_is_no_odds_ratio() -> None:
    test = mcnemar(venn(30, 0, 0, 2))
    assert np.isnan([test.odds_ratio, test.odds_low, test.odds_high, test.p]).all()
    assert test.low < 0 < test.high


def flip_signs(differences: np.ndarray, **options: int) -> SwapTest:
    """The test of the mean of differences X - Y, one per unit."""
    x = np.asarray(differences, dtype=float)[:, np.newaxis]
    return swap_test(x, np.zeros_like(x), lambda sums: sums[..., 0], **options)


def test_fisher_s_test_of_darwin_s_maize_is_as_published() -> None:
    # Fisher (1935), The design of experiments, section 21: of 32,768 ways to place the signs of
    # Darwin's 15 differences (eighths of an inch), 1,726 have a sum of at least 314 in size
    darwin = [49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48]
    test = flip_signs(np.array(darwin))
    assert sum(darwin) == 314
    assert test.n_permutations == 32768
    assert test.p == 1726 / 32768


def test_random_exchanges_come_close_to_all() -> None:
    rng = np.random.default_rng(2)
    differences = rng.normal(0.3, 1, 17)  # one more than all ways are tried for
    expected = permutation_test(
        (differences, np.zeros(17)), lambda x, y, axis: (x - y).sum(axis=axis), vectorized=True,
        permutation_type="samples", n_resamples=20_000, rng=np.random.default_rng(3),
    ).pvalue  # fmt: skip
    test = flip_signs(differences)
    assert not test.is_exact
    assert test.n_permutations == 10_000
    assert test.p == pytest.approx(expected, abs=0.02)


def test_random_exchanges_never_give_a_p_of_0() -> None:
    assert flip_signs(np.ones(30)).p == 1 / 10_001


def test_scipy_s_exact_permutation_test_gives_the_same_of_a_ratio() -> None:
    rng = np.random.default_rng(4)
    size = rng.uniform(5, 50, 9)
    x, y = (np.column_stack([rng.uniform(0.6, 1, 9) * size, size]) for _ in "xy")
    expected = permutation_test(
        (x[:, 0], y[:, 0]), lambda a, b, axis: (a - b).sum(axis=axis) / size.sum(),
        permutation_type="samples", vectorized=True, n_resamples=2**9,
    ).pvalue  # fmt: skip
    assert swap_test(x, y, ratio).p == pytest.approx(expected)


def test_swapping_x_and_y_and_reordering_units_change_no_exact_p() -> None:
    rng = np.random.default_rng(5)
    x, y = rng.uniform(1, 2, (12, 2)), rng.uniform(1, 2, (12, 2))
    y[:, 1] = x[:, 1]
    order = rng.permutation(12)
    p = swap_test(x, y, ratio).p
    assert swap_test(y, x, ratio).p == p
    assert swap_test(x[order], y[order], ratio).p == p


def test_units_in_which_both_are_equal_do_not_count() -> None:
    differences = np.array([0.1, 0.2, 0.1, 0.3, 0.2, 0.1])
    test = flip_signs(np.concatenate([differences, np.zeros(30)]))
    assert test.n_swapped == 6
    assert test.p == flip_signs(differences).p == 2 / 2**6


@pytest.mark.parametrize("n", [0, 1, 5])
def test_too_few_units_have_words_instead_of_a_p_value(n: int) -> None:
    test = flip_signs(np.ones(n))
    assert np.isnan(test.p)
    assert f"X and Y differ in too few recordings for a test: {n}, at least 6" in test.reason


def test_an_undefined_measure_has_no_p_value() -> None:
    test = swap_test(np.zeros((9, 2)), np.zeros((9, 2)), ratio)
    assert np.isnan(test.p)
    assert "undefined" in test.reason


def test_differences_that_are_equal_but_for_rounding_count_as_equal() -> None:
    tenths = np.array([1, 2, 3, 1, 2, -3, 7, 4])
    assert flip_signs(tenths / 10).p == flip_signs(tenths).p < 1


def test_holm_s_worked_example() -> None:
    # four hypotheses, p = 0.01, 0.04, 0.03, 0.005: times 3, 1, 2, 4, never falling; at 0.05 the
    # first and the last one are rejected
    corrected = holm(np.array([0.01, 0.04, 0.03, 0.005]))
    assert corrected.tolist() == pytest.approx([0.03, 0.06, 0.06, 0.02])


def test_holm_leaves_undefined_ones_out_and_stays_at_most_1() -> None:
    corrected = holm(np.array([np.nan, 0.6, 0.4, np.nan]))
    assert np.isnan(corrected[[0, 3]]).all()
    assert corrected[[1, 2]].tolist() == pytest.approx([0.8, 0.8])
    assert holm(np.array([0.9, 0.8])).tolist() == [1, 1]
    assert len(holm(np.empty(0))) == 0


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_never_lowers_and_lies_below_bonferroni(p: list[float]) -> None:
    values = np.array(p)
    corrected = holm(values)
    assert (corrected >= values).all()
    assert (corrected <= np.minimum(len(p) * values, 1) + 1e-12).all() or len(set(p)) < len(p)
    by_size = np.argsort(values, kind="stable")
    assert (np.diff(corrected[by_size]) >= 0).all()


def test_step_down_by_hand() -> None:
    # four ways; ranks of the sizes found (the first way): test a 1 of 4, test b 2 of 4
    draws = np.array([[4.0, 3.0], [1.0, 4.0], [2.0, 1.0], [3.0, 2.0]])
    corrected = step_down(draws, np.array([0.25, 0.5]), n_added=0)
    # smallest p of both: 1/4 in the first way (a) and in the second (b); of b alone 2/4
    assert corrected.tolist() == [0.5, 0.5]


@given(st.integers(0, 2**32 - 1), st.integers(1, 6))
def test_step_down_lies_between_p_and_bonferroni(seed: int, n_tests: int) -> None:
    draws = np.abs(np.random.default_rng(seed).normal(size=(200, n_tests)))
    p = (draws >= draws[0]).mean(axis=0)
    corrected = step_down(draws, p, n_added=0)
    assert (corrected >= p).all()
    assert (corrected <= np.minimum(n_tests * p, 1) + 1e-12).all()
    order = np.argsort(p)
    assert (np.diff(corrected[order]) >= 0).all()


def test_tests_made_together_are_those_made_one_by_one() -> None:
    rng = np.random.default_rng(6)
    size = rng.uniform(5, 50, 9)
    pairs = [
        Paired(*(np.column_stack([rng.uniform(0.6, 1, 9) * size, size]) for _ in "xy"), ratio)
        for _ in range(3)
    ]
    curve = Paired(rng.uniform(1, 2, (9, 4)), rng.uniform(1, 2, (9, 4)), lambda s: s.max(axis=-1))
    together = swap_tests([*pairs, curve])
    for measure, test in zip([*pairs, curve], together, strict=True):
        alone = swap_test(measure.x, measure.y, measure.statistic)
        assert test.p == pytest.approx(alone.p)
        assert len(test.sizes) == 2**8


def test_a_shift_is_taken_off_and_changes_its_sign_with_the_exchange() -> None:
    rng = np.random.default_rng(7)
    difference, shift, ones = rng.normal(0.4, 1, 10), rng.normal(0, 1, 10), np.ones((10, 1))
    x, y = np.column_stack([difference, ones]), np.column_stack([0 * difference, ones])
    assert swap_test(x, y, ratio, shift=shift).p == flip_signs(difference - shift).p
    general = swap_test(x, y, lambda sums: sums[..., 0] / sums[..., 1], shift=shift)
    assert general.p == flip_signs(difference - shift).p
