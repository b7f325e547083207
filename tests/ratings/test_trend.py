"""The line through saliency over mean rank."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from nvcore.subjects.ratings.trend import fit_trend


def clips(rank: np.ndarray, saliency_s: np.ndarray, *, per_recording: int = 1) -> pd.DataFrame:
    names = [f"r{i // per_recording}" for i in range(len(rank))]
    return pd.DataFrame({"recording": names, "mean_rank": rank, "saliency_s": saliency_s})


def test_a_perfect_line_has_its_slope_no_width_and_no_outlier():
    rank = np.arange(1.0, 11)
    trend = fit_trend(clips(rank, 3 + 0.5 * rank))
    assert (trend.slope_s, trend.low_s, trend.high_s) == pytest.approx((0.5, 0.5, 0.5))
    assert trend.saliency_s[[0, -1]] == pytest.approx([3.5, 8.0])
    assert trend.most_s - trend.least_s == pytest.approx(np.zeros(len(trend.rank)), abs=1e-9)
    assert not trend.is_outlier.any()


def test_the_line_is_that_of_least_squares():
    rng = np.random.default_rng(5)
    rank, saliency_s = rng.uniform(1, 20, 15), rng.exponential(2, 15)
    trend = fit_trend(clips(rank, saliency_s))
    slope, height = np.polyfit(rank, saliency_s, 1)
    assert trend.slope_s == pytest.approx(slope)
    assert trend.residual_s == pytest.approx(saliency_s - height - slope * rank)


def test_an_outlier_is_more_than_three_robust_deviations_away():
    rank = np.arange(1.0, 22)
    saliency_s = np.resize([1.0, -1.0], 21)
    saliency_s[10] = 9.0
    trend = fit_trend(clips(rank, saliency_s))
    limit_s = 3 * 1.4826 * np.median(np.abs(trend.residual_s))
    assert trend.is_outlier.tolist() == (np.abs(trend.residual_s) > limit_s).tolist()
    assert np.flatnonzero(trend.is_outlier).tolist() == [10]


def test_the_interval_of_the_slope_holds_the_true_one_in_most_studies():
    rng = np.random.default_rng(1)
    n_held = 0
    for _ in range(200):
        rank = rng.permutation(np.arange(1.0, 31))
        own = np.repeat(rng.normal(0, 1, 15), 2)  # clips of one recording are alike
        trend = fit_trend(clips(rank, 0.3 * rank + own + rng.normal(0, 1, 30), per_recording=2))
        n_held += trend.low_s <= 0.3 <= trend.high_s
    assert 0.85 <= n_held / 200 <= 0.99


def test_few_clips_and_one_rank_have_no_line():
    assert fit_trend(clips(np.arange(4.0), np.arange(4.0))) is None
    assert fit_trend(clips(np.ones(8), np.arange(8.0))) is None
