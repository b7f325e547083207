"""What drives ratings: a known alpha comes back, and what cannot be told is not."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from numpy.typing import ArrayLike
from scipy import stats

from nvcore.subjects.ratings import drivers as module
from nvcore.subjects.ratings.drivers import DRIVERS, find_drivers


def study(ranks: np.ndarray, **columns: np.ndarray) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Ranks (people by clips) and clips, two of each recording; a driver that is not given is 0."""
    n = ranks.shape[1]
    names, systems = np.repeat([f"r{i}" for i in range(n // 2)], 2), np.tile(["X", "Y"], n // 2)
    clips = pd.DataFrame({"clip": names, "system": systems, "recording": names})
    clips = clips.assign(**{of: columns.get(of, np.zeros(n)) for of in DRIVERS})
    wide = pd.DataFrame(ranks, columns=pd.MultiIndex.from_arrays([names, systems]))
    return wide, clips


def rated(
    rng: np.random.Generator, losses: np.ndarray, alpha: ArrayLike, *, effect: float = 1.5
) -> np.ndarray:
    """Ranks by people (twelve with one alpha) who weigh the losses; clips annoy otherwise, too."""
    alphas = np.full(12, alpha) if np.ndim(alpha) == 0 else np.asarray(alpha)
    annoyance = np.column_stack([alphas, 1 - alphas]) @ losses.T
    felt = effect * annoyance / annoyance.std() + rng.normal(0, 0.3, len(losses))
    ranks: np.ndarray = stats.rankdata(felt + rng.gumbel(size=felt.shape), axis=1)
    return ranks


def skewed(rng: np.random.Generator, n: int = 40) -> np.ndarray:
    return 0.02 * rng.lognormal(0, 1, (n, 2))


@pytest.mark.parametrize(("alpha", "spread"), [(0.8, 0.0), (0.6, 0.15), (0.5, 0.25)])
def test_intervals_hold_the_mean_alpha_of_people_in_95_percent_of_studies(
    alpha: float, spread: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "N_RESAMPLES", 500)
    rng = np.random.default_rng(31)
    recording, found = np.repeat(np.arange(20), 2), []
    for _ in range(300):  # the heart of `find_drivers`, without tables
        losses = skewed(rng)
        both = alpha * (1 - alpha) / spread**2 - 1 if spread else 0.0
        alphas = rng.beta(both * alpha, both * (1 - alpha), 12) if spread else alpha
        found.append(module._alpha(losses, module._Study(rated(rng, losses, alphas), recording)))
    known, low, high, reasons = zip(*found, strict=True)
    is_held = (np.array(low) <= alpha) & (alpha <= np.array(high))
    assert 0.925 <= is_held.mean() <= 0.975  # 0.95 within two standard errors
    assert np.count_nonzero(reasons) < 50
    assert np.nanmedian(known) == pytest.approx(alpha, abs=0.02)


def test_people_who_rank_alike_leave_the_interval_as_it_is_and_others_widen_it() -> None:
    rng = np.random.default_rng(12)
    losses = skewed(rng)
    columns = {"loss_miss": losses[:, 0], "loss_false": losses[:, 1]}

    def width(ranks: np.ndarray) -> float:
        found = find_drivers(*study(ranks, **columns))
        assert found.is_of_people == (len(ranks) >= 8)
        return found.high - found.low

    one, other = (rated(rng, losses, np.full(1, alpha)) for alpha in (0.95, 0.05))
    alike, of_two = np.repeat(one, 8, axis=0), np.concatenate([one, other])
    # each share gets half a person more, which weighs less among more people
    assert width(alike) == pytest.approx(width(alike[:7]), rel=0.05)
    assert width(np.repeat(of_two, 4, axis=0)) > 1.5 * width(np.repeat(of_two, 3, axis=0))


def test_odds_of_two_kinds_of_clips_are_counted_by_hand():
    # three of four people rank the ten clips with misses above those without, one the other way
    # round; with half a person more on both sides the share is 0.7, the odds 7 to 3
    misses = np.repeat([0.0, 1.0], 10)
    ranks = np.array([misses, misses, misses, -misses])
    found = find_drivers(*study(ranks, loss_miss=misses))
    row = found.table.set_index("driver").loc["loss_miss"]
    assert row["value"] == pytest.approx((7 / 3) ** 0.5)  # an SD is half a step
    assert (row["low"], row["high"]) == pytest.approx((row["value"], row["value"]), rel=0.02)
    assert (found.n_clips, found.n_recordings, found.n_people) == (20, 10, 4)
    assert found.reason == "loss to false alarms: no recording of 10 has any; 5 are needed"
    others = found.table.set_index("driver").drop("loss_miss")
    assert others["value"].isna().all()
    assert (others["reason"] != "").all()
    assert found.with_alpha["driver"].tolist() == [*DRIVERS, "alpha"]


def test_duration_and_recency_are_told_apart_from_the_losses():
    rng = np.random.default_rng(5)
    losses, missed_s, recency = skewed(rng), rng.exponential(2, 40), rng.random(40)
    missed_s[:4], recency[:4] = 0, np.nan  # clips without a miss have no recency
    felt = 3 * np.nan_to_num(recency, nan=0.5) + missed_s + rng.gumbel(size=(30, 40))
    ranks, clips = study(felt, loss_miss=losses[:, 0], loss_false=losses[:, 1],
                         missed_s=missed_s, recency=recency)  # fmt: skip
    table = find_drivers(ranks, clips).table.set_index("driver")
    assert (table.loc[["missed_s", "recency"], "low"] > 1).all()
    of_losses = table.loc[["loss_miss", "loss_false"]]
    assert ((of_losses["low"] < 1) & (of_losses["high"] > 1)).all()
    assert table.loc["recency", "mean"] == pytest.approx(np.nanmean(recency))


def test_where_the_ratings_cannot_tell_alpha_there_is_the_reason_instead():
    losses = skewed(np.random.default_rng(7))

    def found(of: np.ndarray, **more: float) -> module.RatingDrivers:
        ranks = rated(np.random.default_rng(8), of, 0.7, **more)
        return find_drivers(*study(ranks, loss_miss=of[:, 0], loss_false=of[:, 1]))

    few = np.column_stack([losses[:, 0], np.where(np.arange(40) < 6, losses[:, 1], 0)])
    alike = losses[:, [0, 0]] * [1, 2]
    for one, why in (
        (found(losses[:14]), "an interval needs 8 recordings; there are 7"),
        (found(few), "loss to false alarms: 3 of 20 recordings have any; 5 are needed"),
        (found(alike), r"the two losses rise and fall together (correlation 1.00)"),
        (found(losses, effect=0.0), "clips with larger losses are not shown to annoy more"),
        (found(losses * [1, 0.1]), "anything from"),
    ):
        assert np.isnan(one.alpha)
        assert why in one.reason
    assert found(losses).reason == ""
