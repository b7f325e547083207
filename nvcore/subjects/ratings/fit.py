"""Saliency parameters fitted to ratings, and the order of unseen clips by the fit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.progress import Progress, no_progress
from nvcore.comparison.compare import Result, compare
from nvcore.evidence.bootstrap import CONFIDENCE, MIN_UNITS, N_RESAMPLES, SEED, count_units
from nvcore.metrics.saliency import aggregate_events, recency_weight
from nvcore.settings.params import (
    MIDPOINT_SHARE,
    SPREAD_SHARE,
    Aggregate,
    Params,
    SaliencyOf,
    SaliencyWeight,
)
from nvcore.subjects.ratings.reading import DELAY

LEAST_RECORDINGS: Final = 5
"""Fewest recordings, since two are left out at a time and the rest must suffice for a fit."""
HEIGHT_SHARES: Final = (0.05, 0.075, 0.15, 0.2)
"""Midpoints of the height sigmoid that are tried in addition to the current one, as shares of the
picture's height."""
TOLERANCES: Final = (0.02, 0.05, 0.1, 0.2)
RECENCY_MIDPOINTS: Final = (0.0, 0.25, 0.5, 0.75)
RECENCY_SPREADS: Final = (0.05, 0.1, 0.2, 0.4)
RECENCY_MIDPOINTS_S: Final = (3.75, 7.5, 15.0)
RECENCY_SPREADS_S: Final = (1.5, 5.0)
AGGREGATES: Final[tuple[Aggregate, ...]] = ("max", "sum")
EVENTS_OF: Final[tuple[SaliencyOf, ...]] = ("most_salient", "each")
WEIGHTS: Final[tuple[SaliencyWeight, ...]] = ("time", "risk")
FITTED_SETTINGS: Final = (
    "tolerance",
    "recency_unit",
    "recency_midpoint",
    "recency_spread",
    "recency_midpoint_s",
    "recency_spread_s",
    "saliency_of",
    "saliency_weight",
    "saliency_aggregate",
    "midpoint",
    "spread",
)


@dataclass(frozen=True)
class Fit:
    """Parameters that order the clips best, and their performance on held-out clips.

    Attributes
    ----------
    params
        Settings including the fitted ones.
    changed
        The fitted parameters by name.
    share_default
        Share of the pairs of clips that saliency with the current settings puts in the order of the
        mean ranks. Ties of saliency count half. 0.5 is chance.
    share_fitted
        The same for the fit, over pairs from recordings not used for fitting: the honest value.
    share_training
        The same over the pairs used for fitting, which is too good by construction and not a
        result.
    n_pairs, n_clips, n_settings
        Numbers of pairs of clips with different mean ranks, clips, combinations of parameters
        tried.
    low, high
        95 % interval of `share_fitted`, from resampling the recordings; NaN for the given `reason`.
    gain_low, gain_high
        The same for ``share_fitted - share_default``, the gain of the fit.
    n_recordings
        Number of resampled recordings.
    reason
        Reason for having no interval; empty if there is one.
    """

    params: Params
    changed: dict[str, Any]
    share_default: float
    share_fitted: float
    share_training: float
    n_pairs: int
    n_clips: int
    n_settings: int
    low: float
    high: float
    gain_low: float
    gain_high: float
    n_recordings: int
    reason: str


def fit_saliency(result: Result, clips: pd.DataFrame, *, progress: Progress = no_progress) -> Fit:
    """Fit tolerance, events, their weight, recency, aggregate and sigmoid to the ratings.

    Every combination of the values above is tried. Each pair of clips is judged by the one that
    orders the clips of all other recordings best (leave-pair-out cross-validation, Airola et al.
    2011, by recordings), so no pair is judged by a fit that has seen it.

    Parameters
    ----------
    result
        Comparison with the current settings.
    clips
        Clips from `nvcore.subjects.ratings.validation.join_clips`.
    progress
        Called after each sigmoid, tolerance and kind of events.

    Notes
    -----
    The intervals are percentiles of 10,000 resamples of the recordings, with their clips. Each
    pair keeps the setting that judged it: the intervals show how much the share depends on the
    rated recordings, not the result of a fit to others. A clip and its copy in a resample are not a
    pair.

    Raises
    ------
    InputError
        If the clips are from fewer than five recordings, or all mean ranks are equal.
    """
    recording = pd.factorize(clips["recording"])[0]
    if recording.max(initial=-1) + 1 < LEAST_RECORDINGS:
        raise InputError(
            f"a fit that is judged on recordings left out needs {LEAST_RECORDINGS} rated "
            f"recordings; there are {recording.max(initial=-1) + 1}"
        )
    rank = clips["mean_rank"].to_numpy(dtype=float)
    order = np.sign(np.subtract.outer(rank, rank))
    if not order.any():
        raise InputError("all clips have the same mean rank: there is nothing to fit to")
    settings = [result.params]
    rows = _rows_of_clips(clips, result)
    delay_s = np.zeros(2 * len(result.dataset.recordings))
    delay_s[rows] = clips[DELAY]
    saliency = [_of_recordings(_events(result, result.params), result.params, delay_s)[rows]]
    steps = list(_front_settings(result))
    for n_done, front in enumerate(steps, 1):
        x, y = result.names
        compared = compare(result.dataset, front, x=x, y=y, previous=result)
        for weight in WEIGHTS:
            weighted = replace(front, saliency_weight=weight)
            events = _events(compared, weighted)
            for setting in _back_settings(weighted):
                settings.append(setting)
                saliency.append(_of_recordings(events, setting, delay_s)[rows])
        progress(n_done / len(steps), "fitting")
    agreement = _agreement(np.array(saliency), order, recording)
    total = agreement.sum(axis=(1, 2), dtype=np.int64)
    best = int(total.argmax())
    n_pairs = int(np.count_nonzero(order))
    held_out = _agreement_held_out(agreement)
    counts = sum_by_recording(np.abs(order), recording)
    changed = {
        name: getattr(settings[best], name)
        for name in FITTED_SETTINGS
        if getattr(settings[best], name) != getattr(result.params, name)
    }
    return Fit(
        params=settings[best],
        changed=changed,
        share_default=_share(total[0], n_pairs),
        share_fitted=_share(held_out.sum(), n_pairs),
        share_training=_share(total[best], n_pairs),
        n_pairs=n_pairs // 2,
        n_clips=len(clips),
        n_settings=len(settings),
        n_recordings=len(held_out),
        **_intervals(held_out.astype(float), agreement[0].astype(float), counts),
    )


def _front_settings(result: Result) -> Iterator[Params]:
    """Yield settings whose saliency events differ in more than their weight."""
    height = float(result.dataset.recordings["height"].max())
    sigmoids: list[dict[str, Any]] = [{}]
    if result.params.proximity == "height":
        sigmoids += [
            {"midpoint": share * height, "spread": share * height * SPREAD_SHARE / MIDPOINT_SHARE}
            for share in HEIGHT_SHARES
        ]
    for sigmoid, tolerance, whose in product(sigmoids, TOLERANCES, EVENTS_OF):
        # events weighed by risk have their duration, too
        rule = {"saliency_of": whose, "saliency_weight": "risk"}
        yield replace(result.params, tolerance=tolerance, **rule, **sigmoid)


def _back_settings(front: Params) -> Iterator[Params]:
    """Yield settings that change the weights of the same events. The first of equals is kept."""
    shares = product(RECENCY_MIDPOINTS, RECENCY_SPREADS)
    seconds = product(RECENCY_MIDPOINTS_S, RECENCY_SPREADS_S)
    recencies: list[dict[str, Any]] = [
        {"recency_unit": "share", "recency_midpoint": midpoint, "recency_spread": spread}
        for midpoint, spread in shares
    ]
    recencies += [
        {"recency_unit": "seconds", "recency_midpoint_s": midpoint, "recency_spread_s": spread}
        for midpoint, spread in seconds
    ]
    for recency, aggregate in product(recencies, AGGREGATES):
        yield replace(front, saliency_aggregate=aggregate, **recency)


def _events(result: Result, params: Params) -> tuple[np.ndarray, ...]:
    """Return recording, weight (s) by `params`, tau and rest (s) of the saliency events of X and Y.

    Recordings of Y are numbered after those of X. Events weighed by risk serve both weights.
    """
    n = len(result.dataset.recordings)
    weight = "duration_s" if params.saliency_weight == "time" else "weight_s"
    tables = [system.events for _, system in result.sides]

    def column(name: str) -> np.ndarray:
        return np.concatenate([table[name].to_numpy(dtype=float) for table in tables])

    is_of_y = np.repeat([0, 1], [len(table) for table in tables])
    recording = column("recording").astype(np.int64) + n * is_of_y
    return recording, column(weight), column("tau"), column("rest_s")


def _of_recordings(
    events: tuple[np.ndarray, ...], params: Params, delay_s: np.ndarray
) -> np.ndarray:
    """Return the saliency of all recordings with X, then with Y, s, weighing events by `params`.

    Parameters
    ----------
    delay_s
        Seconds from the end of each recording to its rating, in the same order; float64.
    """
    recording, weight_s, tau, rest_s = events
    weight_s = weight_s * recency_weight(tau, rest_s + delay_s[recording], params)
    return aggregate_events(recording, weight_s, len(delay_s), aggregate=params.saliency_aggregate)


def _rows_of_clips(clips: pd.DataFrame, result: Result) -> np.ndarray:
    """Return the row of each rated clip in `_of_recordings`, int64."""
    names = result.dataset.recordings["name"].astype(str).tolist()
    place = {name: i for i, name in enumerate(names)}
    first: np.ndarray = clips["clip"].map(place).to_numpy(dtype=np.int64)
    rows: np.ndarray = first + len(names) * (clips["system"] == result.y.name).to_numpy()
    return rows


def _agreement(saliency: np.ndarray, order: np.ndarray, recording: np.ndarray) -> np.ndarray:
    """Measure how far each setting puts the pairs of clips in the order of the ratings.

    Parameters
    ----------
    saliency
        Saliency of each clip at each setting, float64, shape (settings, clips).
    order
        Sign of the difference of the ratings, shape (clips, clips).
    recording
        Number of each clip's recording, shape (clips,).

    Returns
    -------
    Pairs in the order of the ratings minus those in the other, summed over the clips of each two
    recordings; int16, shape (settings, recordings, recordings). With float64, and clip by clip, the
    settings of 200 recordings would take gigabytes.
    """
    by_recording = np.argsort(recording, kind="stable")
    starts = np.flatnonzero(np.diff(recording[by_recording], prepend=-1))
    by_rating = order[np.ix_(by_recording, by_recording)].astype(np.int8)
    agreement = np.empty((len(saliency), len(starts), len(starts)), dtype=np.int16)
    for sums, of_clips in zip(agreement, saliency[:, by_recording], strict=True):
        is_higher = np.greater.outer(of_clips, of_clips).view(np.int8)
        pairs = (is_higher - is_higher.T) * by_rating
        rows = np.add.reduceat(pairs, starts, axis=0, dtype=np.int16)
        sums[:] = np.add.reduceat(rows, starts, axis=1, dtype=np.int16)
    return agreement


def sum_by_recording(pairs: np.ndarray, recording: np.ndarray) -> np.ndarray:
    """Sum over the pairs of clips of every two recordings, float64, (recordings, recordings)."""
    member = (recording[:, None] == np.arange(recording.max() + 1)).astype(np.float64)
    sums: np.ndarray = member.T @ pairs @ member
    return sums


def resample_pairs(drawn: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """Sum over all pairs of clips in each resample. A clip and its copy are not a pair.

    Parameters
    ----------
    drawn
        How often each recording was drawn; float64, shape (n_resamples, n_recordings).
    sums
        Result of `sum_by_recording`.

    Returns
    -------
    Shape (n_resamples,).
    """
    within = np.diag(sums)
    across = ((drawn @ (sums - np.diag(within))) * drawn).sum(axis=1)
    total: np.ndarray = across + drawn @ within
    return total


def _agreement_held_out(agreement: np.ndarray) -> np.ndarray:
    """Return the agreement on every two recordings by the best setting without both.

    See `_agreement`.
    """
    n = agreement.shape[1]
    row = agreement.sum(axis=2, dtype=np.int64)
    total = row.sum(axis=1)
    within = np.einsum("saa->sa", agreement).astype(np.int64)
    outside = 2 * row - within  # leaves with a recording: its row and column, itself only once
    best = np.empty((n, n), dtype=np.int64)
    for i in range(n):  # over recordings, because the whole cube of scores would not fit in memory
        between = agreement[:, i, :].astype(np.int64)
        remaining = total[:, None] - outside[:, [i]] - outside + 2 * between
        remaining[:, i] = total - outside[:, i]
        best[i] = remaining.argmax(axis=0)
    held_out: np.ndarray = np.take_along_axis(agreement, best[None], axis=0)[0]
    return held_out


def _intervals(fitted: np.ndarray, start: np.ndarray, counts: np.ndarray) -> dict[str, Any]:
    """Return intervals of the fit's share and gain, or the reason for none, as fields of `Fit`.

    Parameters
    ----------
    fitted, start, counts
        Agreement by the fits and by the current settings, and number of pairs of clips, for each
        two recordings; float64, (n, n).
    """
    n, names = len(counts), ("low", "high", "gain_low", "gain_high")
    if n < MIN_UNITS:
        reason = f"an interval needs {MIN_UNITS} recordings; there are {n}"
        return {**dict.fromkeys(names, np.nan), "reason": reason}
    rng = np.random.default_rng(SEED)
    drawn = count_units(rng.integers(0, n, (N_RESAMPLES, n)), n)
    n_drawn = resample_pairs(drawn, counts)
    with np.errstate(invalid="ignore", divide="ignore"):
        share, before = (
            0.5 + 0.5 * resample_pairs(drawn, sums) / n_drawn for sums in (fitted, start)
        )
    ends = [50 * (1 - CONFIDENCE), 50 * (1 + CONFIDENCE)]
    found = np.nanpercentile([share, share - before], ends, axis=1).T.ravel().tolist()
    return {**dict(zip(names, found, strict=True)), "reason": ""}


def _share(agreement: float | np.floating, n_pairs: int) -> float:
    """Return the share of pairs ordered like the ratings, from the sum of agreements of -1..1."""
    return 0.5 + 0.5 * float(agreement) / n_pairs
