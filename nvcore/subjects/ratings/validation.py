"""Saliency compared with people: its correlation with the mean rank of annoyance."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
import scipy

from nvcore.common.errors import InputError
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.values import duration_of_recordings, per_recording
from nvcore.metrics.saliency import aggregate_events, recency_weight
from nvcore.subjects.ratings.clips import stretch_of
from nvcore.subjects.ratings.reading import DELAY

LEAST_CLIPS: Final = 5
"""Fewest clips for a meaningful correlation."""
N_RESAMPLES: Final = 5_000
SEED: Final = 20_110_360
BATCH_CELLS: Final = 2_000_000
"""Pairs of clips processed at a time, which limits the memory of the bootstrap."""
MOST_IN_PAIRS: Final = 120
"""Most clips for which all pairs of all resamples are processed at once."""
Statistic = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Correlation:
    """Correlation over clips with its 95 % interval.

    Attributes
    ----------
    name
        Name of the coefficient.
    value
        -1..1; NaN if undefined.
    low, high
        BCa bootstrap interval over clips; NaN if undefined.
    p
        Two-sided p-value of no correlation; NaN if `value` is.
    note
        Reason for undefined values, else empty.
    """

    name: str
    value: float
    low: float
    high: float
    p: float
    note: str = ""


def clip_saliency(result: Result, delay_s: pd.Series | None = None) -> pd.DataFrame:
    """Compute the saliency of every clip with the boxes of X and with those of Y, and its losses.

    Parameters
    ----------
    result
        Comparison whose recordings are the clips (`nvcore.subjects.ratings.clips.compare_clips`).
    delay_s
        Result of `mean_delay`. With recency in seconds, the time from a clip's end to its rating
        counts, too. None: clips are rated as they end.

    Returns
    -------
    Rows of X, then of Y: ``clip``, ``system``, ``saliency_s`` (0 is best), ``delay_s`` (seconds, 0
    if unknown), ``recording`` of the clip; means over its time of ``loss_miss``,
    ``D(G, S) / (W/2)``, and ``loss_false``, ``D(S, G) / (W/2)``, both before weighing by alpha;
    ``missed_s``, seconds of its saliency events, and ``recency``, their mean recency by duration
    (0..1; NaN without any).
    """
    frames = result.dataset.frame_columns
    names = result.dataset.recordings["name"].astype(str).tolist()
    sums = partial(per_recording, result)
    length_s, n = duration_of_recordings(result), len(names)
    parts = []
    for _, system in result.sides:
        clips = pd.MultiIndex.from_product([names, [system.name]])
        delays = np.zeros(n)
        if delay_s is not None:
            delays = delay_s.reindex(clips).fillna(0.0).to_numpy(dtype=float)
        events = system.events
        recording = events["recording"].to_numpy(dtype=np.int64)
        tau, rest_s, duration_s, weight_s = (
            events[name].to_numpy(dtype=float)
            for name in ("tau", "rest_s", "duration_s", "weight_s")
        )
        recency = recency_weight(tau, rest_s + delays[recording], result.params)
        step_s = frames.step_s / frames.half_width
        missed_s = sums(duration_s, recording)
        with np.errstate(invalid="ignore"):  # a recording may have no frames, a clip no miss
            columns = {
                "clip": names,
                "system": system.name,
                "saliency_s": aggregate_events(
                    recording, weight_s * recency, n, aggregate=result.params.saliency_aggregate
                ),
                DELAY: delays,
                "recording": [stretch_of(name)[0] for name in names],
                "loss_miss": sums(system.distances.d_miss * step_s, frames.recording) / length_s,
                "loss_false": sums(system.distances.d_false * step_s, frames.recording) / length_s,
                "missed_s": missed_s,
                "recency": sums(duration_s * recency, recording) / missed_s,
            }
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def mean_delay(ratings: pd.DataFrame) -> pd.Series:
    """Return the mean seconds from a clip's end to its ratings, by clip and system. NaN: not known.

    Parameters
    ----------
    ratings
        Table from `nvcore.subjects.ratings.reading.read_ratings`. Without ``delay_s`` there are no
        rows.
    """
    if DELAY not in ratings:
        return pd.Series(dtype=float, index=pd.MultiIndex.from_arrays([[], []]))
    given: pd.Series = ratings[ratings["rating"].notna()].groupby(["clip", "system"])[DELAY].mean()
    return given


def split_known(
    ratings: pd.DataFrame, saliency: pd.DataFrame, *, system: str = ""
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Split ratings into those of this comparison's clips, and others, which no measure uses.

    Parameters
    ----------
    ratings
        Of `nvcore.subjects.ratings.reading.read_ratings`.
    saliency
        Of `clip_saliency`.
    system
        System whose boxes the clips showed, filled in if the ratings do not say.

    Raises
    ------
    InputError
        If no rated clip is a recording of this comparison.
    """
    complete = ratings.assign(system=ratings["system"].where(ratings["system"] != "", system))
    clips = pd.MultiIndex.from_frame(saliency[["clip", "system"]])
    is_known = pd.MultiIndex.from_frame(complete[["clip", "system"]]).isin(clips)
    if not is_known.any():
        raise _none_known(complete["clip"])
    return complete[is_known].reset_index(drop=True), complete[~is_known].reset_index(drop=True)


def _none_known(clips: pd.Series) -> InputError:
    examples = ", ".join(clips.drop_duplicates().head(3))
    return InputError(
        f"none of the rated clips ({examples}, ...) is a recording of this comparison with the "
        "boxes of X or Y: the clip's name must be the recording's, the system's that of X or Y"
    )


def join_clips(ranks: pd.DataFrame, saliency: pd.DataFrame) -> pd.DataFrame:
    """Join mean rank and saliency of the clips that have both.

    Parameters
    ----------
    ranks
        Ranks from `agreement.rank_ratings`. Ratings without a system must go through `split_known`
        first.
    saliency
        Of `clip_saliency`.

    Returns
    -------
    Columns ``clip``, ``system``, ``mean_rank`` (1 is least annoying), ``n_ratings``, and those of
    `saliency`.

    Raises
    ------
    InputError
        If no rated clip is a recording of this comparison.
    """
    rank_of_clip = pd.DataFrame({"mean_rank": ranks.mean(), "n_ratings": ranks.notna().sum()})
    rank_of_clip = rank_of_clip.reset_index()
    clips: pd.DataFrame = rank_of_clip.merge(saliency, on=["clip", "system"], how="inner")
    if clips.empty:
        raise _none_known(rank_of_clip["clip"])
    return clips


def _pearson(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return Pearson's correlation over the last axis. NaN where all values are the same."""
    a = x - x.mean(axis=-1, keepdims=True)
    b = y - y.mean(axis=-1, keepdims=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        r: np.ndarray = (a * b).sum(-1) / np.sqrt((a * a).sum(-1) * (b * b).sum(-1))
    return r


def _spearman(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return _pearson(scipy.stats.rankdata(x, axis=-1), scipy.stats.rankdata(y, axis=-1))


def _kendall(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return tau-b over the last axis: the cosine between the signs of all differences."""
    if x.shape[-1] > MOST_IN_PAIRS:
        return _kendall_by_sorting(x, y)
    a = np.sign(x[..., :, None] - x[..., None, :])
    b = np.sign(y[..., :, None] - y[..., None, :])
    across = (-2, -1)
    with np.errstate(invalid="ignore", divide="ignore"):
        tau: np.ndarray = (a * b).sum(across) / np.sqrt((a * a).sum(across) * (b * b).sum(across))
    return tau


def _kendall_by_sorting(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return tau-b in n log n, one resample after another."""
    rows_x, rows_y = (values.reshape(-1, values.shape[-1]) for values in np.broadcast_arrays(x, y))
    taus = [scipy.stats.kendalltau(a, b).statistic for a, b in zip(rows_x, rows_y, strict=True)]
    tau: np.ndarray = np.array(taus).reshape(np.broadcast_shapes(x.shape, y.shape)[:-1])
    return tau


COEFFICIENTS: Final = (
    ("Pearson's r", _pearson, scipy.stats.pearsonr),
    ("Spearman's rho", _spearman, scipy.stats.spearmanr),
    ("Kendall's tau", _kendall, scipy.stats.kendalltau),
)
"""Name, the coefficient over the last axis (many resamples at once), and its test."""


def correlate(saliency_s: np.ndarray, mean_rank: np.ndarray) -> list[Correlation]:
    """Compute Pearson's r, Spearman's rho and Kendall's tau of saliency and mean rank over clips.

    Notes
    -----
    Intervals are bias-corrected and accelerated (BCa), from 5,000 resamples of the clips with a
    fixed seed. Clips of one recording, shown with two systems, are assumed to be independent, so
    with few recordings the intervals are too narrow.
    """
    n = len(saliency_s)
    if n < LEAST_CLIPS:
        note = f"{n} clips; a correlation needs {LEAST_CLIPS} at least"
    elif np.ptp(saliency_s) == 0 or np.ptp(mean_rank) == 0:
        note = "all clips have the same value: there is nothing to correlate"
    else:
        return [_correlation(*coefficient, saliency_s, mean_rank) for coefficient in COEFFICIENTS]
    return [Correlation(label, np.nan, np.nan, np.nan, np.nan, note) for label, *_ in COEFFICIENTS]


def _correlation(
    label: str, value: Statistic, test: Any, x: np.ndarray, y: np.ndarray
) -> Correlation:
    outcome = test(x, y)
    with warnings.catch_warnings():  # a resample may hold one clip only, many times
        warnings.simplefilter("ignore")
        interval = scipy.stats.bootstrap(
            (x, y),
            lambda x, y, **_: value(x, y),  # always over the last axis
            paired=True,
            vectorized=True,
            n_resamples=N_RESAMPLES,
            method="BCa",
            rng=np.random.default_rng(SEED),
            batch=max(1, BATCH_CELLS // len(x) ** 2),
        ).confidence_interval
    low, high = float(interval.low), float(interval.high)
    note = "" if np.isfinite([low, high]).all() else "the clips allow no interval"
    return Correlation(label, float(outcome.statistic), low, high, float(outcome.pvalue), note)
