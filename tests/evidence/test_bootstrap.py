from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import bootstrap, norm
from scipy.stats import t as student

from nvcore.evidence.bootstrap import (
    MIN_UNITS,
    bootstrap_difference,
    count_units,
    ratio,
    studentised_tests,
)


def rates(values: np.ndarray, size: float = 1.0) -> np.ndarray:
    """Numerator and denominator of units of equal size."""
    return np.column_stack([values * size, np.full(len(values), size)])


def draw(seed: int, n: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    shared = rng.normal(0.8, 0.1, n)
    return rates(shared + rng.normal(0.02, 0.02, n)), rates(shared + rng.normal(0, 0.02, n))


def test_the_difference_is_of_the_measure_over_all_units() -> None:
    x = np.array([[9, 10], [10, 30], *[[1, 1]] * 6])  # 25 / 46
    y = np.array([[8, 10], [16, 30], *[[0, 1]] * 6])  # 24 / 46
    interval = bootstrap_difference(x, y)
    assert (interval.x, interval.y) == (25 / 46, 24 / 46)
    assert interval.difference == pytest.approx(1 / 46)
    assert interval.low < interval.difference < interval.high
    assert (interval.n_units, interval.n_resamples) == (8, 10_000)
    assert interval.seed == 110360
    assert (interval.method, interval.reason) == ("BCa bootstrap", "")


def test_units_of_equal_size_give_scipy_s_interval_of_the_mean_difference() -> None:
    x, y = draw(1, 30)
    n = len(x)
    level = 1 - 2 * norm.sf(student.isf(0.025, n - 1) * np.sqrt(n / (n - 1)))
    expected = bootstrap(
        (x[:, 0] - y[:, 0],), np.mean, confidence_level=level, n_resamples=10_000, method="BCa",
        rng=np.random.default_rng(5),
    ).confidence_interval  # fmt: skip
    interval = bootstrap_difference(x, y)
    width = expected.high - expected.low
    assert interval.low == pytest.approx(expected.low, abs=0.03 * width)
    assert interval.high == pytest.approx(expected.high, abs=0.03 * width)


def test_swapping_x_and_y_turns_the_sign() -> None:
    x, y = draw(2, 12)
    there, back = bootstrap_difference(x, y), bootstrap_difference(y, x)
    assert there.difference == -back.difference
    assert there.low == pytest.approx(-back.high, rel=1e-9)
    assert there.high == pytest.approx(-back.low, rel=1e-9)


def test_the_same_seed_gives_the_same_interval_and_another_one_nearly() -> None:
    x, y = draw(3, 15)
    first, again = bootstrap_difference(x, y), bootstrap_difference(x, y)
    other = bootstrap_difference(x, y, seed=1)
    assert first == again
    assert other.low != first.low
    assert other.low == pytest.approx(first.low, abs=0.05 * (first.high - first.low))


def test_a_measure_of_a_whole_curve_can_be_resampled() -> None:
    # rows: units; columns: thresholds; the figure is the smallest rate over the thresholds
    rng = np.random.default_rng(4)
    shape = (20, 5, 2)
    x, y = rng.uniform(1, 2, shape), rng.uniform(1, 2, shape)
    x[..., 0] *= 3

    def least(sums: np.ndarray) -> np.ndarray:
        return ratio(sums).min(axis=-1)

    interval = bootstrap_difference(x, y, least)
    expected = (x.sum(0)[:, 0] / x.sum(0)[:, 1]).min() - (y.sum(0)[:, 0] / y.sum(0)[:, 1]).min()
    assert interval.difference == pytest.approx(expected)
    assert 0 < interval.low < expected < interval.high


SHARED, _ = draw(7, 12)
ONLY_ONE = np.zeros((10, 2))  # of ten units has anything to count
ONLY_ONE[0] = 1, 4
MORE = ONLY_ONE + np.array([0.1, 0])


@pytest.mark.parametrize(
    ("x", "y", "difference", "reason"),
    [
        (*draw(6, 0), np.nan, "undefined"),
        (*draw(6, 1), 0.1066, "too few units for an interval: 1, at least 8"),
        (*draw(6, MIN_UNITS - 1), 0.0107, "few units for an interval: 7, at least 8 are needed"),
        (SHARED, SHARED.copy(), 0, "X and Y are the same in all units"),
        (SHARED, rates(SHARED[:, 0] - 0.1), 0.1, "differ by the same in all units"),
        (MORE, ONLY_ONE, 0.25, "undefined in some resamples"),
        (3 * ONLY_ONE / [1, 3], ONLY_ONE, 0.5, "in too few units for a test: 1, at least 6"),
    ],
)
def test_without_an_interval_there_are_words(
    x: np.ndarray, y: np.ndarray, difference: float, reason: str
) -> None:
    interval = bootstrap_difference(x, y)
    assert interval.difference == pytest.approx(difference, nan_ok=True, abs=1e-4)
    assert np.isnan([interval.low, interval.high]).all()
    assert reason in interval.reason
    assert interval.method == ""


def test_what_bca_cannot_correct_has_the_plain_interval_and_says_so() -> None:
    # the figure of all units is far above that of any resample: no bias correction reaches it
    x, y = draw(9, 20)

    def jagged(sums: np.ndarray) -> np.ndarray:
        return ratio(sums) + np.isclose(sums[..., 0], x[:, 0].sum(), rtol=1e-12) * 100

    interval = bootstrap_difference(x, y, jagged)
    assert interval.method == "percentile bootstrap"
    assert interval.difference > 99
    assert interval.low < interval.high < 1


def test_drawn_units_are_counted() -> None:
    drawn = np.array([[0, 0, 2], [1, 2, 2]])
    assert count_units(drawn, 3).tolist() == [[2, 0, 1], [0, 1, 2]]
    assert count_units(drawn[0], 3).tolist() == [2, 0, 1]


@pytest.mark.parametrize(("kind", "least"), [("normal", 0.92), ("exponential", 0.89)])
def test_intervals_hold_the_true_difference_about_as_often_as_they_say(
    kind: str, least: float
) -> None:
    # of 400 intervals of 95 % some 380; the standard error of the share is 0.011
    rng, n = np.random.default_rng(11), 8
    draws = rng.normal(0, 1, (400, n)) if kind == "normal" else rng.exponential(1, (400, n)) - 1
    held = 0
    for differences in draws:
        shared = rng.normal(5, 3, n)  # what recordings share falls out of the pairs
        interval = bootstrap_difference(rates(shared + differences), rates(shared), n_resamples=599)
        held += interval.low <= 0 <= interval.high
    assert least <= held / len(draws) <= 0.98


def test_an_interval_reaches_further_to_the_side_of_the_units_that_differ_most():
    """The sample's encounters: Y alone detects three in one recording, X alone two in others."""
    n = np.array([4, 4, 3, 2, 4, 4, 4, 5, 4, 4])
    ahead = np.array([0, 2, 0, 0, 2, -3, 1, 1, 1, -1])
    x, y = (np.stack([10 + sign * ahead.clip(0), n], axis=1) for sign in (1, 0))
    y = y + np.stack([(-ahead).clip(0), 0 * n], axis=1)
    interval = bootstrap_difference(x, y)
    assert interval.difference == pytest.approx(3 / 38)
    assert interval.difference - interval.low > 1.5 * (interval.high - interval.difference)
    mirrored = bootstrap_difference(y, x)
    assert (mirrored.low, mirrored.high) == pytest.approx((-interval.high, -interval.low), abs=0.02)


def test_units_without_a_part_do_not_make_a_test_surer() -> None:
    parts = np.random.default_rng(1).normal(0.8, 0.8, 8)
    (alone,) = studentised_tests(parts[:, np.newaxis])
    assert 0.02 < alone.p < 0.2
    among = np.concatenate([parts, np.full(40, 99.0)])[:, np.newaxis]
    is_part = np.arange(48)[:, np.newaxis] < 8
    (test,) = studentised_tests(among, is_part)
    assert test.p == pytest.approx(alone.p, rel=0.25)  # the number of parts drawn varies, too
    (all_are,) = studentised_tests(parts[:, np.newaxis], np.ones((8, 1), dtype=bool))
    assert all_are.p == alone.p
