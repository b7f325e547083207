"""Saliency parameters fitted to ratings, and how well the fit orders clips it has not seen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.errors import InputError
from nvcore.evidence.bootstrap import CONFIDENCE, MIN_UNITS, N_RESAMPLES, SEED, count_units
from nvcore.metrics.saliency import recency_weight
from nvcore.params import MIDPOINT_SHARE, SPREAD_SHARE, Aggregate, Params
from nvcore.progress import Progress, no_progress

LEAST_RECORDINGS: Final = 5
"""Two are left out at a time: fewer leave nothing to fit to."""
HEIGHT_SHARES: Final = (0.05, 0.075, 0.15, 0.2)
"""Midpoints of the height sigmoid that are tried beside the one in use, shares of the picture's
height."""
TOLERANCES: Final = (0.02, 0.05, 0.1, 0.2)
RECENCY_MIDPOINTS: Final = (0.0, 0.25, 0.5, 0.75)
RECENCY_SPREADS: Final = (0.05, 0.1, 0.2, 0.4)
AGGREGATES: Final[tuple[Aggregate, ...]] = ("max", "sum")


@dataclass(frozen=True)
class Fit:
    """The parameters that order the clips best, and what they are worth on clips left out.

    Attributes
    ----------
    params
        The settings with the fitted ones in place.
    changed
        The fitted parameters by name.
    share_default
        Share of the pairs of clips that saliency with the settings in use puts in the order of
        the mean ranks; ties of saliency count half. 0.5 is chance.
    share_fitted
        The same for the fit, of pairs whose recordings it was not fitted to: this is its worth.
    share_training
        The same of the pairs that it was fitted to. Too good by construction: no result.
    n_pairs, n_clips, n_settings
        Pairs of clips with different mean ranks, clips, combinations of parameters tried.
    low, high
        95 % interval of `share_fitted`, from resampling the recordings; NaN: `reason` says why.
    gain_low, gain_high
        The same of ``share_fitted - share_default``, what the fit gains.
    n_recordings
        Recordings that were resampled.
    reason
        Why there is no interval; else empty.
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


def fit_saliency(
    result: Result,
    clips: pd.DataFrame,
    *,
    progress: Progress = no_progress,
) -> Fit:
    """Fit tolerance, recency, aggregate and height sigmoid to the ratings.

    Every combination of the values above is tried. Each pair of clips is judged by the one that
    orders the clips of all other recordings best (leave-pair-out cross-validation, Airola et al.
    2011, by recordings), so that no pair is judged by a fit that has seen it.

    Parameters
    ----------
    result
        The comparison, with the settings in use.
    clips
        Of `nvcore.studies.ratings.validation.join_clips`.
    progress
        Called after each sigmoid and tolerance.

    Notes
    -----
    The intervals are percentiles of 10,000 resamples of the recordings, with their clips. Each
    pair keeps the setting that judged it: they say how much the share depends on the recordings
    rated, not how a fit to others would have come out. A clip and its copy in a resample are no
    pair.

    Raises
    ------
    InputError
        With fewer than five recordings among the clips, or where all mean ranks are the same.
    """
    recording = pd.factorize(clips["clip"])[0]
    if recording.max(initial=-1) + 1 < LEAST_RECORDINGS:
        raise InputError(
            f"a fit that is judged on recordings left out needs {LEAST_RECORDINGS} rated "
            f"recordings; there are {recording.max(initial=-1) + 1}"
        )
    rank = clips["mean_rank"].to_numpy(dtype=float)
    wanted = np.sign(np.subtract.outer(rank, rank))
    if not wanted.any():
        raise InputError("all clips have the same mean rank: there is nothing to fit to")
    tried = [result.params]
    saliency = [_of_clips(*_events(result), result.params, clips, result)]
    steps = list(_front_settings(result))
    for done, front in enumerate(steps, 1):
        found = compare(result.dataset, front, x=result.x.name, y=result.y.name, previous=result)
        events = _events(found)
        for setting in _back_settings(front):
            tried.append(setting)
            saliency.append(_of_clips(*events, setting, clips, result))
        progress(done / len(steps), "fitting")
    agreement = _agreement(np.array(saliency), wanted)
    total = agreement.sum(axis=(1, 2))
    best = int(total.argmax())
    n_pairs = int(np.count_nonzero(wanted))
    judged = _left_out(agreement, recording)
    start, counted = (_by_recording(one, recording) for one in (agreement[0], np.abs(wanted)))
    (low, high), (gain_low, gain_high), reason = _intervals(judged, start, counted)
    changed = {
        name: getattr(tried[best], name)
        for name in ("tolerance", "recency_midpoint", "recency_spread", "saliency_aggregate",
                     "midpoint", "spread")
        if getattr(tried[best], name) != getattr(result.params, name)
    }  # fmt: skip
    return Fit(
        params=tried[best],
        changed=changed,
        share_default=_share(total[0], n_pairs),
        share_fitted=_share(judged.sum(), n_pairs),
        share_training=_share(total[best], n_pairs),
        n_pairs=n_pairs // 2,
        n_clips=len(clips),
        n_settings=len(tried),
        low=low,
        high=high,
        gain_low=gain_low,
        gain_high=gain_high,
        n_recordings=len(judged),
        reason=reason,
    )


def _front_settings(result: Result) -> Iterator[Params]:
    """Settings whose saliency events differ in more than their weight."""
    height = float(result.dataset.recordings["height"].max())
    sigmoids: list[dict[str, Any]] = [{}]
    if result.params.proximity == "height":
        sigmoids += [
            {"midpoint": share * height, "spread": share * height * SPREAD_SHARE / MIDPOINT_SHARE}
            for share in HEIGHT_SHARES
        ]
    for sigmoid, tolerance in product(sigmoids, TOLERANCES):
        yield replace(result.params, tolerance=tolerance, **sigmoid)


def _back_settings(front: Params) -> Iterator[Params]:
    for midpoint, spread, aggregate in product(RECENCY_MIDPOINTS, RECENCY_SPREADS, AGGREGATES):
        yield replace(
            front, recency_midpoint=midpoint, recency_spread=spread, saliency_aggregate=aggregate
        )


def _events(result: Result) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Clip (recording, those of Y after those of X), duration in seconds and tau of each event."""
    n = len(result.dataset.recordings)
    columns = [
        (system.events["recording"].to_numpy() + n * side, system.events["duration_s"].to_numpy(),
         system.events["tau"].to_numpy())
        for side, (_, system) in enumerate(result.sides)
    ]  # fmt: skip
    clip, duration_s, tau = (np.concatenate(parts) for parts in zip(*columns, strict=True))
    return clip, duration_s, tau


def _of_clips(
    clip: np.ndarray,
    duration_s: np.ndarray,
    tau: np.ndarray,
    params: Params,
    clips: pd.DataFrame,
    result: Result,
) -> np.ndarray:
    """Saliency of the rated clips, seconds."""
    names = result.dataset.recordings["name"].astype(str).tolist()
    value = duration_s * recency_weight(tau, params)
    every = np.zeros(2 * len(names))
    if params.saliency_aggregate == "max":
        np.maximum.at(every, clip, value)
    else:
        np.add.at(every, clip, value)
    place = {name: i for i, name in enumerate(names)}
    rows = clips["clip"].map(place).to_numpy()
    rows = rows + len(names) * (clips["system"] == result.y.name).to_numpy()
    of_clips: np.ndarray = every[rows]
    return of_clips


def _agreement(saliency: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """1 for pairs in the wanted order, -1 in the other, 0 for ties; int8, (settings, n, n)."""
    ordered = np.empty((len(saliency), *wanted.shape), dtype=np.int8)
    for setting, of_clips in zip(ordered, saliency, strict=True):  # all at once would be gigabytes
        setting[:] = np.sign(np.subtract.outer(of_clips, of_clips)) * wanted
    return ordered


def _by_recording(pairs: np.ndarray, recording: np.ndarray) -> np.ndarray:
    """Sums over the pairs of clips of each two recordings; float64, (recordings, recordings)."""
    member = (recording[:, None] == np.arange(recording.max() + 1)).astype(np.float64)
    sums: np.ndarray = member.T @ pairs @ member
    return sums


def _left_out(agreement: np.ndarray, recording: np.ndarray) -> np.ndarray:
    """Agreement of each two recordings, by the setting that is best without the two."""
    n = int(recording.max()) + 1
    blocks = np.array([_by_recording(one, recording) for one in agreement])
    total, row = blocks.sum(axis=(1, 2)), blocks.sum(axis=2)
    own = np.einsum("saa->sa", blocks)
    outside = 2 * row - own  # what leaves with a recording: its row, its column, once itself
    best = np.empty((n, n), dtype=np.int64)
    for one in range(n):  # over recordings: the whole cube of scores would not fit in memory
        left = total[:, None] - outside[:, [one]] - outside + 2 * blocks[:, one, :]
        left[:, one] = total - outside[:, one]
        best[one] = left.argmax(axis=0)
    chosen: np.ndarray = np.take_along_axis(blocks, best[None], axis=0)[0]
    return chosen


def _intervals(
    fitted: np.ndarray, start: np.ndarray, counted: np.ndarray
) -> tuple[tuple[float, float], tuple[float, float], str]:
    """Intervals of the fit's share and of its gain, and why there are none.

    Parameters
    ----------
    fitted, start, counted
        Agreement by the fits and by the settings in use, and number, of the pairs of clips of each
        two recordings; float64, (n, n).
    """
    n, none = len(counted), (np.nan, np.nan)
    if n < MIN_UNITS:
        return none, none, f"an interval needs {MIN_UNITS} recordings; there are {n}"
    rng = np.random.default_rng(SEED)
    weight = count_units(rng.integers(0, n, (N_RESAMPLES, n)), n)

    def resampled(sums: np.ndarray) -> np.ndarray:
        own = np.diag(sums)
        across = ((weight @ (sums - np.diag(own))) * weight).sum(axis=1)
        total: np.ndarray = across + weight @ own
        return total

    with np.errstate(invalid="ignore", divide="ignore"):
        share, before = (0.5 + 0.5 * resampled(one) / resampled(counted) for one in (fitted, start))
    ends = [50 * (1 - CONFIDENCE), 50 * (1 + CONFIDENCE)]
    found, gain = (tuple(np.nanpercentile(one, ends).tolist()) for one in (share, share - before))
    return found, gain, ""


def _share(agreement: float | np.floating, n_pairs: int) -> float:
    """Share of pairs in the wanted order, from agreement of -1..1 in sum."""
    return 0.5 + 0.5 * float(agreement) / n_pairs
