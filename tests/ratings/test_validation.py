"""Saliency against mean ranks, and the fit that is judged on clips left out."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import at, make_dataset, result_of
from places import SAMPLE
from rating_tables import table
from scipy import stats

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result, compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.subjects.ratings import fit as module
from nvcore.subjects.ratings.agreement import rank_ratings
from nvcore.subjects.ratings.fit import FITTED_SETTINGS, fit_saliency
from nvcore.subjects.ratings.validation import (
    clip_saliency,
    correlate,
    join_clips,
    mean_delay,
    split_known,
)
from nvcore.tables.result import recordings_table


@pytest.fixture(scope="module")
def result() -> Result:
    session = read_session(SAMPLE)
    return compare(load(session))


@pytest.fixture
def one_sigmoid(monkeypatch):
    monkeypatch.setattr(module, "HEIGHT_SHARES", ())


def rated(result, saliency_s):
    """Clips of the sample whose mean rank follows these saliencies."""
    clips = clip_saliency(result)
    return clips.assign(mean_rank=stats.rankdata(saliency_s), n_ratings=1)


def test_saliency_of_clips_is_that_of_the_recordings_report(result):
    clips, recordings = clip_saliency(result), recordings_table(result)
    assert clips["clip"].tolist() == 2 * recordings["recording"].tolist()
    n = len(recordings)
    assert clips["system"].tolist() == [result.x.name] * n + [result.y.name] * n
    expected = [*recordings["saliency_x"], *recordings["saliency_y"]]
    np.testing.assert_array_equal(clips["saliency_s"], expected)


def test_the_time_to_the_rating_counts_in_recency_in_seconds_alone():
    # 2 s; X misses the pedestrian in the first one: 1 s weighed by the time since
    truth = [at(f, 50, track=1) for f in range(20)]
    dataset = make_dataset(truth, truth[10:], truth)
    ratings = pd.DataFrame(
        {"participant": list("abc"), "clip": "r0", "system": "x", "rating": [3.0, 5.0, np.nan],
         "delay_s": [4.0, 8.0, 99.0]}
    )  # fmt: skip
    delay_s = mean_delay(ratings)
    assert delay_s.loc[("r0", "x")] == 6.0  # who gave no rating gave none late
    in_seconds = result_of(dataset, recency_unit="seconds")
    at_once, later = (clip_saliency(in_seconds, delay) for delay in (None, delay_s))
    assert at_once["saliency_s"].tolist() == pytest.approx([1 / (1 + np.exp((1 - 7.5) / 1.5)), 0])
    assert later["saliency_s"].tolist() == pytest.approx([1 / (1 + np.exp((7 - 7.5) / 1.5)), 0])
    assert later["delay_s"].tolist() == [6.0, 0.0]
    by_share = result_of(dataset)
    assert clip_saliency(by_share, delay_s)["saliency_s"].equals(
        clip_saliency(by_share)["saliency_s"]
    )
    assert mean_delay(ratings.drop(columns="delay_s")).empty


def test_a_fit_counts_the_time_to_the_ratings_as_the_plot_does(result, one_sigmoid):
    in_seconds = compare(result.dataset, replace(result.params, recency_unit="seconds"))
    delay_s = clip_saliency(result).set_index(["clip", "system"])["delay_s"]
    late = clip_saliency(in_seconds, delay_s + np.arange(20.0))
    clips = late.assign(mean_rank=stats.rankdata(late["saliency_s"]), n_ratings=1)
    assert fit_saliency(in_seconds, clips).share_default == 1
    assert fit_saliency(in_seconds, clips.assign(delay_s=0.0)).share_default < 1


def test_ratings_without_system_are_joined_to_the_one_that_was_shown():
    ratings = table([[1, 2, 3], [2, 1, 3]])
    saliency = pd.DataFrame(
        {"clip": ["C000", "C002"] * 2, "system": ["X"] * 2 + ["Y"] * 2, "saliency_s": range(4)}
    ).assign(delay_s=0.0)
    known, _ = split_known(ratings, saliency, system="Y")
    joined = join_clips(rank_ratings(known), saliency)
    assert joined["clip"].tolist() == ["C000", "C002"]
    assert joined["saliency_s"].tolist() == [2, 3]
    assert joined["mean_rank"].tolist() == [1, 2]  # among the clips of this comparison
    assert joined["n_ratings"].tolist() == [2, 2]


def test_ratings_of_other_clips_are_set_apart():
    ratings = table([[1, 2, 3], [2, 1, 3]])
    saliency = pd.DataFrame({"clip": ["C000", "C001"], "system": "X", "saliency_s": [1.0, 2.0]})
    known, unknown = split_known(ratings, saliency, system="X")
    assert known["clip"].tolist() == ["C000", "C001"] * 2
    assert set(known["system"]) == {"X"}
    assert unknown["clip"].tolist() == ["C002", "C002"]
    with pytest.raises(InputError, match="C000"):
        split_known(ratings, saliency, system="Y")
    with pytest.raises(InputError, match="C000"):
        join_clips(rank_ratings(ratings), saliency)


def test_coefficients_are_scipys_with_intervals_around_them():
    rng = np.random.default_rng(3)
    saliency = rng.random(25).round(1)  # with ties
    rank = saliency + rng.normal(0, 0.2, 25)
    pearson, spearman, kendall = correlate(saliency, rank)
    assert pearson.value == pytest.approx(stats.pearsonr(saliency, rank).statistic)
    assert spearman.value == pytest.approx(stats.spearmanr(saliency, rank).statistic)
    assert kendall.value == pytest.approx(stats.kendalltau(saliency, rank).statistic)
    for correlation in (pearson, spearman, kendall):
        assert -1 <= correlation.low < correlation.value < correlation.high <= 1
        assert correlation.p < 0.001


def test_the_interval_is_that_of_the_plain_bootstrap():
    rng = np.random.default_rng(4)
    saliency = rng.random(12)
    rank = saliency + rng.normal(0, 0.5, 12)
    for correlation, find in zip(
        correlate(saliency, rank), (stats.pearsonr, stats.spearmanr, stats.kendalltau), strict=True
    ):
        plain = stats.bootstrap(
            (saliency, rank), lambda a, b, find=find: find(a, b).statistic, paired=True,
            vectorized=False, n_resamples=1000, method="BCa", rng=np.random.default_rng(5),
        ).confidence_interval  # fmt: skip
        assert correlation.low == pytest.approx(plain.low, abs=0.08)
        assert correlation.high == pytest.approx(plain.high, abs=0.08)


@pytest.mark.parametrize(
    ("saliency", "words"), [(np.arange(4.0), "4 clips"), (np.zeros(9), "same value")]
)
def test_undefined_correlation_says_why(saliency, words):
    correlations = correlate(saliency, np.arange(len(saliency), dtype=float))
    assert all(np.isnan(each.value) for each in correlations)
    assert all(words in each.note for each in correlations)


def test_a_fit_finds_the_settings_that_the_ratings_were_made_with(result):
    made = replace(
        result.params, tolerance=0.1, recency_midpoint=0.75, recency_spread=0.05,
        saliency_aggregate="sum",
    )  # fmt: skip
    truth = clip_saliency(compare(result.dataset, made))
    fit = fit_saliency(result, rated(result, truth["saliency_s"]))
    assert fit.share_training > 0.95
    assert fit.share_default < fit.share_fitted <= fit.share_training
    assert fit.n_clips == 20
    fitted = clip_saliency(compare(result.dataset, fit.params))
    tau = stats.kendalltau(fitted["saliency_s"], truth["saliency_s"]).statistic
    assert tau > 0.9


def test_a_fit_tries_whose_events_by_what_weight_and_in_seconds(result, one_sigmoid):
    made = replace(
        result.params, saliency_of="each", saliency_weight="risk", saliency_aggregate="sum",
        recency_unit="seconds", recency_midpoint_s=3.75, recency_spread_s=5.0,
    )  # fmt: skip
    truth = clip_saliency(compare(result.dataset, made))
    fit = fit_saliency(result, rated(result, truth["saliency_s"]))
    assert fit.share_training > 0.97
    assert fit.share_default < fit.share_fitted
    fitted = clip_saliency(compare(result.dataset, fit.params))
    tau = stats.kendalltau(fitted["saliency_s"], truth["saliency_s"]).statistic
    assert fit.share_training == pytest.approx((1 + tau) / 2)
    assert fit.changed == {
        name: getattr(fit.params, name)
        for name in FITTED_SETTINGS
        if getattr(fit.params, name) != getattr(result.params, name)
    }


@pytest.fixture(scope="module")
def chance(result):
    """Ratings by chance, fits to them, the shares of progress of all, and what was tried.

    The last is the saliency of the clips at each setting, and the recordings of the clips.
    """
    rng, shares, tried = np.random.default_rng(6), [], []
    real = module._agreement

    def agreement(saliency, order, recording):
        tried.append((saliency, recording))
        return real(saliency, order, recording)

    ratings = [rated(result, rng.random(20)) for _ in range(3)]
    with pytest.MonkeyPatch.context() as patch:  # one sigmoid is tried
        patch.setattr(module, "HEIGHT_SHARES", ())
        patch.setattr(module, "_agreement", agreement)
        fits = [
            fit_saliency(result, clips, progress=lambda share, _what: shares.append(share))
            for clips in ratings
        ]
    return ratings, fits, shares, tried[0]


def test_a_fit_to_chance_is_worth_chance_though_it_fits_what_it_has_seen(chance):
    _, fits, _, (saliency, recording) = chance
    assert all(fit.share_fitted < fit.share_training > 0.55 for fit in fits)
    # three fits may all be lucky: the same with many ratings, without the comparisons made again
    rng, training, held_out = np.random.default_rng(7), [], []
    for _ in range(100):
        order = np.sign(np.subtract.outer(rank := rng.random(20), rank))
        agreement = module._agreement(saliency, order, recording)
        n_pairs = np.count_nonzero(order)
        training.append(module._share(agreement.sum(axis=(1, 2)).max(), n_pairs))
        held_out.append(module._share(module._agreement_held_out(agreement).sum(), n_pairs))
    assert np.mean(training) > 0.55
    assert abs(np.mean(held_out) - 0.5) < 0.03  # their spread is 0.09


def test_the_progress_of_a_fit_rises_evenly_to_its_end(chance):
    _, _, shares, _ = chance
    n = len(shares) // 3
    assert shares == 3 * [i / n for i in range(1, n + 1)]


def test_the_share_of_the_settings_in_use_is_counted_by_hand(chance):
    (ratings, *_), (fit, *_), *_ = chance
    s, r = ratings["saliency_s"].to_numpy(), ratings["mean_rank"].to_numpy()
    right = total = 0.0
    for i in range(20):
        for j in range(i):
            total += 1
            right += 0.5 if s[i] == s[j] else float((s[i] > s[j]) == (r[i] > r[j]))
    assert fit.n_pairs == total
    assert fit.share_default == pytest.approx(right / total)


def test_each_pair_is_judged_without_its_recordings(result):
    """Against the plain way: for each pair of recordings, the best setting of all other clips."""
    rng = np.random.default_rng(8)
    recording = np.array([0, 1, 2, 3, 4, 5, 0, 1, 2, 3])
    saliency = rng.random((30, 10))
    wanted = np.sign(np.subtract.outer(rank := rng.random(10), rank))
    cube = np.sign(saliency[:, :, None] - saliency[:, None, :]) * wanted
    sums = module._agreement(saliency, wanted, recording)
    assert (sums == [module.sum_by_recording(pairs, recording) for pairs in cube]).all()
    total = 0.0
    for i in range(10):
        for j in range(10):
            is_other = ~np.isin(recording, [recording[i], recording[j]])
            best = cube[:, is_other][:, :, is_other].sum(axis=(1, 2)).argmax()
            total += cube[best, i, j]
    assert module._agreement_held_out(sums).sum() == pytest.approx(total)


def test_few_recordings_and_equal_ranks_are_refused(result):
    ratings = rated(result, np.arange(20.0))
    few = ratings[ratings["clip"].isin(ratings["clip"].unique()[:4])]
    with pytest.raises(InputError, match="there are 4"):
        fit_saliency(result, few)
    with pytest.raises(InputError, match="same mean rank"):
        fit_saliency(result, ratings.assign(mean_rank=1.0))


def test_many_clips_counted_by_sorting_have_the_same_intervals(monkeypatch):
    rng = np.random.default_rng(9)
    saliency = np.round(rng.normal(size=20), 1)
    rank = np.round(saliency + rng.normal(size=20), 1)
    by_pairs = correlate(saliency, rank)
    monkeypatch.setattr("nvcore.subjects.ratings.validation.MOST_IN_PAIRS", 10)
    by_sorting = correlate(saliency, rank)
    assert by_sorting[2].low == pytest.approx(by_pairs[2].low)
    assert by_sorting[2].high == pytest.approx(by_pairs[2].high)


def test_the_interval_of_the_share_is_that_of_recordings_drawn_one_by_one():
    """Against the plain way: the clips of the drawn recordings, without a clip and its copy."""
    rng = np.random.default_rng(13)
    recording = np.repeat(np.arange(9), 2)
    rank = rng.random(18)
    saliency = rank + rng.normal(0, 0.3, 18)
    wanted = np.sign(np.subtract.outer(rank, rank))
    agreement = np.sign(np.subtract.outer(saliency, saliency)) * wanted
    sums, n_pairs = (module.sum_by_recording(of, recording) for of in (agreement, np.abs(wanted)))
    found = module._intervals(sums, sums, n_pairs)
    shares = []
    for _ in range(1500):
        right = total = 0.0
        drawn = rng.integers(0, 9, 9)
        for i, first in enumerate(drawn):
            for j, second in enumerate(drawn):
                if i != j and first == second:
                    continue  # a recording and its copy
                right += sums[first, second]
                total += n_pairs[first, second]
        shares.append(0.5 + 0.5 * right / total)
    assert (found["gain_low"], found["gain_high"], found["reason"]) == (0, 0, "")
    ends = np.percentile(shares, [2.5, 97.5])
    np.testing.assert_allclose([found["low"], found["high"]], ends, atol=0.02)


def test_a_fit_to_few_recordings_has_no_interval_but_the_reason(result, chance):
    (ratings, *_), (whole, *_), *_ = chance
    few = ratings[ratings["clip"].isin(ratings["clip"].unique()[:6])]
    fit = fit_saliency(result, few)
    assert np.isnan([fit.low, fit.high, fit.gain_low, fit.gain_high]).all()
    assert fit.reason == "an interval needs 8 recordings; there are 6"
    assert whole.low < whole.share_fitted < whole.high
    assert whole.gain_low < whole.share_fitted - whole.share_default < whole.gain_high
    assert whole.reason == ""
