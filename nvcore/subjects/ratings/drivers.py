"""Drivers of the ratings: losses that put a clip above others, and the alpha that people use."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
import pandas as pd
import scipy

from nvcore.evidence.bootstrap import MIN_UNITS, SEED, count_units, expanded_tail
from nvcore.subjects.ratings.fit import resample_pairs, sum_by_recording

LOSSES: Final = ("loss_miss", "loss_false")
DRIVERS: Final = {
    "loss_miss": "Loss to misses",
    "loss_false": "Loss to false alarms",
    "missed_s": "Duration of the misses, s",
    "recency": "Recency of the misses",
}
"""Possible drivers of ratings: columns of `validation.clip_saliency` with labels."""
N_RESAMPLES: Final = 2_000
LEAST_WITH: Final = 5
"""Fewest recordings with a loss for judging its effect."""
MOST_INFLATION: Final = 10.0
"""Variance inflation from which a driver cannot be told from the others (Kutner et al. 2005,
Applied linear statistical models, section 10.5)."""
WIDEST: Final = 0.5
"""Widest interval, of the range 0..1, with which alpha counts as known."""
LARGEST_EFFECT: Final = 50.0
MOST_STEPS: Final = 50
LONGEST_STEP: Final = 2.0


@dataclass(frozen=True, eq=False)
class RatingDrivers:
    """Effects that put a clip above others in the ranks.

    Attributes
    ----------
    table
        By driver (key of `DRIVERS`): ``driver``, its ``mean`` and ``sd`` over the clips, and
        ``value``: factor on the odds that somebody finds a clip more annoying than another if it
        has one ``sd`` more of this driver, all others equal (1: no effect), with the 95 % interval
        ``low``, ``high``. NaN if the ratings cannot tell, with the ``reason``.
    alpha, low, high
        ``b_miss / (b_miss + b_false)`` by only the two losses, 0..1, and its 95 % interval; NaN if
        unknown.
    reason
        Reason why alpha is unknown; empty if known. The interval may be known anyway.
    n_clips, n_recordings, n_people
        Numbers of clips, recordings and people behind the result.

    Notes
    -----
    Intervals are of the mean of people, on recordings like these, if `is_of_people`; else of those
    who rated.
    """

    table: pd.DataFrame
    alpha: float
    low: float
    high: float
    reason: str
    n_clips: int
    n_recordings: int
    n_people: int

    @property
    def is_of_people(self) -> bool:
        """Whether enough people rated to resample them, so that intervals are of people."""
        return self.n_people >= MIN_UNITS

    @property
    def with_alpha(self) -> pd.DataFrame:
        """Table with a last row for alpha, whose ``value`` is alpha itself."""
        row = ("alpha", np.nan, np.nan, self.alpha, self.low, self.high, self.reason)
        return pd.DataFrame([*self.table.itertuples(index=False), row], columns=[*self.table])


def find_drivers(ranks: pd.DataFrame, clips: pd.DataFrame) -> RatingDrivers:
    """Regress the ranks of clips on their losses, and on duration and recency of their misses.

    The chance that somebody ranks clip i above clip j is ``1 / (1 + exp(-b (x_i - x_j)))``, so a
    complete table of ratings only matters through its mean ranks. Only the order counts, so ranks
    may rise with annoyance in any monotonic way.

    Parameters
    ----------
    ranks
        Ranks from `nvcore.subjects.ratings.agreement.rank_ratings`.
    clips
        Clips from `nvcore.subjects.ratings.validation.join_clips`.

    Notes
    -----
    Each share of people gets half a person more on both sides. Without it, clips that all rank
    alike would have no estimate. Intervals are percentiles of 2,000 resamples of the recordings
    and, independently, of the people (fixed seed), their ends moved outwards for few recordings;
    each resample takes one Newton step from the estimate. Fewer than eight people are not
    resampled.

    References
    ----------
    Bradley and Terry (1952), Rank analysis of incomplete block designs, Biometrika 39:324;
    Springall (1973), Response surface fitting using a generalization of the Bradley-Terry paired
    comparison model, Applied Statistics 22:59; Cameron, Gelbach and Miller (2011), Robust inference
    with multiway clustering, Journal of Business & Economic Statistics 29:238 (people and
    recordings); Davidson and MacKinnon (1999), Bootstrap testing in nonlinear models, International
    Economic Review 40:487 (resamples by few steps).
    """
    recording, names = pd.factorize(clips["recording"])
    rated = ranks[pd.MultiIndex.from_frame(clips[["clip", "system"]])]
    study = _Study(rated.to_numpy(dtype=float), recording)
    counts = len(clips), len(names), len(ranks)
    values = clips[[*DRIVERS]].to_numpy(dtype=float)
    n_with = [len(np.unique(recording[values[:, i] > 0])) for i in range(len(DRIVERS))]
    mean = np.full(len(DRIVERS), np.nan)
    for i, column in enumerate(values.T):
        known = column[~np.isnan(column)]
        if len(known):
            mean[i] = known.mean()
    # clips without a miss have no recency; they get the mean, which has no effect
    filled = np.where(np.isnan(values), mean, values)
    spread = filled.std(axis=0)
    reasons = [_too_little(n, of, len(names)) for n, of in zip(n_with, spread, strict=True)]
    no_alpha = next(
        (f"{DRIVERS[of].lower()}: {why}" for of, why in zip(LOSSES, reasons, strict=False) if why),
        "",
    )
    if len(names) < MIN_UNITS:
        no_alpha = f"an interval needs {MIN_UNITS} recordings; there are {len(names)}"
        reasons = [no_alpha] * len(reasons)
    used = [i for i, reason in enumerate(reasons) if not reason]
    odds = np.full((3, len(DRIVERS)), np.nan)
    if used:
        for i, inflation in zip(used, _inflation(filled[:, used]), strict=True):
            if inflation > MOST_INFLATION:
                reasons[i] = "it rises and falls with the others: they cannot be told apart"
        scaled = (filled[:, used] - filled[:, used].mean(axis=0)) / spread[used]
        b, drawn = _regress(scaled, study)
        tail = expanded_tail(len(names))
        ends = np.quantile(drawn, [tail, 1 - tail], axis=0)
        odds[:, used] = np.exp(np.clip([b, *ends], -LARGEST_EFFECT, LARGEST_EFFECT))
    odds[:, [i for i, reason in enumerate(reasons) if reason]] = np.nan
    table = pd.DataFrame({"driver": [*DRIVERS], "mean": mean, "sd": spread})
    table = table.assign(value=odds[0], low=odds[1], high=odds[2], reason=reasons)
    if no_alpha:
        return RatingDrivers(table, np.nan, np.nan, np.nan, no_alpha, *counts)
    return RatingDrivers(table, *_alpha(filled[:, :2], study), *counts)


def _too_little(n_with: int, spread: float, n: int) -> str:
    """Explain why a driver that `n_with` recordings have cannot be judged, or return ""."""
    if n_with < LEAST_WITH:
        which = f"{n_with} of {n} recordings have" if n_with else f"no recording of {n} has"
        return f"{which} any; {LEAST_WITH} are needed"
    return "" if spread > 0 else "it is the same in all clips"


def _inflation(values: np.ndarray) -> np.ndarray:
    """Compute the variance inflation of each column, 1 for uncorrelated ones, (n_columns,)."""
    # regularised, so that the inverse is large instead of undefined for equal columns
    correlation = np.atleast_2d(np.corrcoef(values, rowvar=False)) + 1e-9 * np.eye(values.shape[1])
    inflation: np.ndarray = np.diag(np.linalg.inv(correlation))
    return inflation


@dataclass(frozen=True, eq=False)
class _Study:
    """Ranks by people and clips, (n_people, n_clips), and the number of each clip's recording."""

    ranks: np.ndarray
    recording: np.ndarray

    def by_person(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield whether each person ranks clip i above clip j (tie: a half), and ranks both."""
        for row in self.ranks:  # all pairs of all people would not fit into memory
            difference = np.subtract.outer(row, row)
            yield (difference > 0) + 0.5 * (difference == 0), ~np.isnan(difference)

    @cached_property
    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """Share of people who rank clip i above clip j, and number who rank both, (n, n)."""
        wins, both = np.zeros((2, self.ranks.shape[1], self.ranks.shape[1]))
        for is_above, ranks_both in self.by_person():
            wins += is_above
            both += ranks_both
        return (wins + 0.5) / (both + 1), both * ~np.eye(len(both), dtype=bool)


def _regress(x: np.ndarray, study: _Study) -> tuple[np.ndarray, np.ndarray]:
    """Return the effects of the columns of `x`, and those of every resample.

    Recordings and, from `MIN_UNITS` on, people are resampled independently. Each resample adds the
    deviations of both.

    Parameters
    ----------
    x
        Float64, shape (n_clips, k), centred and scaled to a spread of 1.

    Returns
    -------
    Shapes (k,) and (`N_RESAMPLES`, k).
    """
    (above, n_people), recording = study.pairs, study.recording
    k, b = x.shape[1], np.zeros(x.shape[1])

    def slopes() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        height = x @ b
        chance = scipy.special.expit(np.subtract.outer(height, height))
        return chance, n_people * (above - chance), n_people * chance * (1 - chance)

    for _ in range(MOST_STEPS):  # Newton's method: the likelihood has a single maximum
        _, left, weight = slopes()
        information = x.T @ (np.diag(weight.sum(axis=1)) - weight) @ x
        step = np.linalg.solve(_firm(information), x.T @ left.sum(axis=1))
        b = b + step * min(1.0, LONGEST_STEP / np.abs(step).max(initial=1e-300))
        if np.abs(step).max() < 1e-10:
            break
    chance, left, weight = slopes()
    n = int(recording.max()) + 1
    rng = np.random.default_rng(SEED)
    drawn = count_units(rng.integers(0, n, (N_RESAMPLES, n)), n)
    score, of_drawn = np.empty((N_RESAMPLES, k)), np.empty((N_RESAMPLES, k, k))
    for i in range(k):  # over drivers: four
        score[:, i] = resample_pairs(drawn, sum_by_recording(x[:, [i]] * left, recording))
        for j in range(i + 1):
            apart = np.subtract.outer(x[:, i], x[:, i]) * np.subtract.outer(x[:, j], x[:, j])
            sums = sum_by_recording(0.5 * weight * apart, recording)
            of_drawn[:, i, j] = of_drawn[:, j, i] = resample_pairs(drawn, sums)
    effects = b + np.linalg.solve(_firm(of_drawn), score[:, :, None])[:, :, 0]
    if (n := len(study.ranks)) >= MIN_UNITS:
        drawn = count_units(rng.integers(0, n, (N_RESAMPLES, n)), n)
        differences = _differences(x, chance, study) @ np.linalg.inv(_firm(information))
        effects += (drawn - 1) @ differences
    return b, effects


def _differences(x: np.ndarray, chance: np.ndarray, study: _Study) -> np.ndarray:
    """Return how far the score of each person is from the mean of people, (n_people, k).

    Resampling recordings already varies how a person ranks single recordings. This part of the
    variance is taken off, or it would count twice (Cameron, Gelbach and Miller 2011).
    """
    n, n_recordings = len(study.ranks), int(study.recording.max()) + 1
    share = study.pairs[1] / (study.pairs[1] + 1)  # the half person more is nobody's
    parts = np.zeros((n, n_recordings, x.shape[1]))  # of the score, by person and recording
    for part, (is_above, ranks_both) in zip(parts, study.by_person(), strict=True):
        excess = share * (is_above - ranks_both * chance)
        np.add.at(part, study.recording, x * excess.sum(axis=1)[:, None] - excess @ x)
    parts -= parts.mean(axis=0)
    differences = parts.sum(axis=1) / 2  # each pair is a part of two recordings
    parts -= parts.mean(axis=1, keepdims=True)
    twice = (parts**2).sum(axis=(0, 1)) * n_recordings / (n_recordings - 1)
    variance = (differences**2).sum(axis=0)
    left = np.clip(1 - twice / np.where(variance > 0, variance, 1.0), 0, 1)
    scaled: np.ndarray = differences * np.sqrt(left * n / (n - 1))
    return scaled


def _firm(information: np.ndarray) -> np.ndarray:
    """Regularise matrices, so that they can be solved even if a driver never varies."""
    k = information.shape[-1]
    trace = np.trace(information, axis1=-2, axis2=-1)[..., None, None]
    firm: np.ndarray = information + (1e-9 * trace + 1e-12) * np.eye(k)
    return firm


def _alpha(losses: np.ndarray, study: _Study) -> tuple[float, float, float, str]:
    """Return alpha by the two losses, its interval, and the reason if it is unknown."""
    if _inflation(losses).max() > MOST_INFLATION:
        r = np.corrcoef(losses, rowvar=False)[0, 1]
        why = f"the two losses rise and fall together (correlation {r:.2f})"
        return np.nan, np.nan, np.nan, why
    sd = losses.std(axis=0)
    b, drawn = _regress((losses - losses.mean(axis=0)) / sd, study)
    # an effect below 0 counts as 0, since nobody is pleased by misses
    b, drawn = np.maximum(b / sd, 0), np.maximum(drawn / sd, 0)
    tail = expanded_tail(int(study.recording.max()) + 1)
    is_known = drawn.sum(axis=1) > 0
    if b.sum() <= 0 or 1 - is_known.mean() > tail:
        return np.nan, np.nan, np.nan, "clips with larger losses are not shown to annoy more"
    alphas = drawn[is_known, 0] / drawn[is_known].sum(axis=1)
    low, high = np.quantile(alphas, [tail, 1 - tail]).tolist()
    if high - low > WIDEST:
        why = f"anything from {low:.2f} to {high:.2f} fits the ratings"
        return np.nan, low, high, why
    return float(b[0] / b.sum()), low, high, ""
