"""Encounters (one pedestrian of one recording), and each system's performance in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import UNKNOWN_OCCLUSION, MissClass
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.encounters import (
    EncounterArrays,
    EncounterMeasures,
    encounter_frames,
    group_rows,
)
from nvcore.metrics.linking import TruthTracks, track_truth
from nvcore.settings.params import Params

SHORT_SHARE: Final = 0.5
"""Share of one-frame encounters above which encounters are frames rather than people."""


def mostly_one_frame(n_frames: np.ndarray) -> bool:
    """Whether most of these encounters are a single frame long.

    Parameters
    ----------
    n_frames
        Annotated frames of each encounter; shape (n,).
    """
    return bool(np.count_nonzero(n_frames == 1) > SHORT_SHARE * len(n_frames))


@dataclass(frozen=True)
class Encounters:
    """The encounters of a dataset and their properties that do not depend on any parameter.

    Attributes
    ----------
    recording, track
        Recording and track of each encounter, sorted by both; int32 and int64, shape (n,).
    encounter_of
        Encounter of each truth row, -1 for ignored boxes; int64, shape (n_truth,).
    order, offsets
        ``order[offsets[e]:offsets[e + 1]]`` are the truth rows of encounter e, by frame.
    frame_index
        Frame row of each truth row in `order`; int64.
    first_row, last_row
        Frame rows of the first and the last annotated frame; int64, shape (n,).
    n_frames
        Annotated frames; int64, shape (n,).
    lateral_offset
        Mean distance from the middle of the picture, fraction of W/2, 0..1.
    lateral_position
        Mean signed position, -1 left edge, 0 middle, 1 right edge.
    peak_height
        Largest box height, px.
    aspect_ratio, aspect_z
        Mean h/w and its z-score over all encounters (NaN for fewer than two, or no spread).
    occluded_share
        Share of the frames with known occlusion that are at least partly occluded; NaN: unknown.
    """

    recording: np.ndarray
    track: np.ndarray
    encounter_of: np.ndarray
    order: np.ndarray
    offsets: np.ndarray
    frame_index: np.ndarray
    first_row: np.ndarray
    last_row: np.ndarray
    n_frames: np.ndarray
    lateral_offset: np.ndarray
    lateral_position: np.ndarray
    peak_height: np.ndarray
    aspect_ratio: np.ndarray
    aspect_z: np.ndarray
    occluded_share: np.ndarray

    @property
    def arrays(self) -> EncounterArrays:
        """The truth rows for compiled loops."""
        return EncounterArrays(self.offsets, self.order, self.frame_index)

    def __len__(self) -> int:
        return len(self.track)


def encounters_of(dataset: Dataset) -> tuple[TruthTracks, Encounters]:
    """Return the tracks and encounters of a dataset's ground truth.

    The result is cached: no setting changes it.
    """
    if "encounters" not in dataset.derived:
        truth, frames = dataset.truth, dataset.frame_columns
        occlusion = dataset.boxes["occlusion"].to_numpy()[: len(truth)]
        tracks = track_truth(truth, frames)
        encounters = find_encounters(
            truth, tracks.track, occlusion, frames, each_alone=dataset.each_alone
        )
        dataset.derived["encounters"] = tracks, encounters
    pair: tuple[TruthTracks, Encounters] = dataset.derived["encounters"]
    return pair


def find_encounters(
    truth: BoxColumns,
    track: np.ndarray,
    occlusion: np.ndarray,
    frames: FrameColumns,
    *,
    each_alone: bool = False,
) -> Encounters:
    """Group the pedestrians of the ground truth into encounters.

    Ignored boxes belong to none.

    Parameters
    ----------
    track
        Track of each truth row (given or linked); int64, shape (n_truth,).
    occlusion
        0 none, 1 partial, 2 heavy, -1 unknown; int8, shape (n_truth,).
    each_alone
        True if recordings must not be compared with each other, which leaves out z-scores.
    """
    recording = frames.recording[truth.frame_index]
    code, key_recording, key_track = _number_encounters(recording, track, ~truth.ignore)
    counts = np.bincount(code[code >= 0], minlength=len(key_track)).astype(np.int64)
    order = group_rows(code, counts)[: int(counts.sum())]
    offsets = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
    starts = offsets[:-1]
    row_frame = truth.frame_index[order]
    first_row, last_row = row_frame[starts], row_frame[offsets[1:] - 1]
    is_new_frame = np.ones(len(order), dtype=bool)  # a track id given twice in a frame counts once
    is_new_frame[1:] = np.diff(row_frame) != 0
    is_new_frame[starts] = True
    half = frames.half_width[row_frame]
    centre = np.clip(truth.x[order] + 0.5 * truth.w[order], 0, 2 * half)
    signed_offset = (centre - half) / half
    aspect = truth.h[order] / truth.w[order]
    is_known = (occlusion[order] != UNKNOWN_OCCLUSION).astype(float)
    is_occluded = (occlusion[order] > 0).astype(float)
    # no encounter is empty, so reduceat has no empty segments
    mean_aspect = _sum(aspect, starts) / counts
    n_known = _sum(is_known, starts)
    with np.errstate(invalid="ignore"):
        occluded_share = _sum(is_occluded, starts) / n_known
    return Encounters(
        recording=key_recording,
        track=key_track,
        encounter_of=code,
        order=order,
        offsets=offsets,
        frame_index=row_frame,
        first_row=first_row,
        last_row=last_row,
        n_frames=_sum(is_new_frame, starts).astype(np.int64),
        lateral_offset=_sum(np.abs(signed_offset), starts) / counts,
        lateral_position=_sum(signed_offset, starts) / counts,
        peak_height=np.maximum.reduceat(truth.h[order], starts) if len(starts) else np.empty(0),
        aspect_ratio=mean_aspect,
        aspect_z=np.full(len(counts), np.nan) if each_alone else _z_scores(mean_aspect),
        occluded_share=occluded_share,
    )


def _sum(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Sum each segment. Segments must not be empty."""
    if not len(starts):
        return np.empty(0)
    total: np.ndarray = np.add.reduceat(values, starts, dtype=float)
    return total


def _number_encounters(
    recording: np.ndarray, track: np.ndarray, is_member: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each row's encounter (-1: none), and each encounter's recording and track, sorted."""
    small, track_ids = track, None
    if len(track) and (track.min() < -1 or track.max() >= 2**31 - 1):
        small, track_ids = pd.factorize(track, sort=True)  # ids such as timestamps
    key = recording.astype(np.int64) << 32 | (small + 1)
    code = np.full(len(key), -1, np.int64)
    codes, keys = pd.factorize(key[is_member])
    keys = np.asarray(keys, dtype=np.int64)
    by_key = np.argsort(keys)
    rank = np.empty(len(keys), np.int64)
    rank[by_key] = np.arange(len(keys))
    code[is_member] = rank[codes] if len(keys) else codes
    keys = keys[by_key]
    tracks = (keys & 0xFFFFFFFF) - 1
    if track_ids is not None:
        tracks = np.asarray(track_ids, dtype=np.int64)[tracks]
    return code, (keys >> 32).astype(np.int32), tracks


def _z_scores(values: np.ndarray) -> np.ndarray:
    spread = values.std() if len(values) > 1 else 0.0
    # equal values have a spread of a rounding error, not always 0
    if not spread > 1e-9 * np.abs(values).max(initial=0):
        return np.full(len(values), np.nan)
    scores: np.ndarray = (values - values.mean()) / spread
    return scores


def judge_encounters(
    encounters: Encounters,
    k_truth: np.ndarray,
    is_matched: np.ndarray,
    frames: FrameColumns,
    params: Params,
) -> pd.DataFrame:
    """Measure one system's performance in every encounter.

    Frames with ``k >= 0.5`` are relevant. An encounter is detected if the share of matched relevant
    frames is at least ``coverage`` and not 0. Distant encounters (without relevant frames) have
    neither a class nor measures.

    Returns
    -------
    One row per encounter: n_relevant, matched (relevant frames), peak_k, coverage (0..1, 1 is
    best), is_detected, lag_s, gap_s, tail_s (seconds, 0 is best, NaN if never matched), miss_class
    (None for distant ones).

    References
    ----------
    Paper 11-0360, figures 1 and 2; ``docs/metrics.md``, encounters.
    """
    measures = EncounterMeasures.empty(len(encounters))
    over_ranges(
        encounter_frames,
        len(encounters),
        encounters.arrays,
        frames.arrays,
        k_truth,
        is_matched,
        measures,
    )
    n_relevant, n_matched, peak_k, lag, gap, tail = measures
    rate = frames.fps[encounters.recording]
    with np.errstate(invalid="ignore"):
        coverage = n_matched / n_relevant
    is_detected = (coverage >= params.coverage) & (n_matched > 0)
    lag_s, gap_s, tail_s = lag / rate, gap / rate, tail / rate
    classes = np.array([None, *(kind.value for kind in MissClass)], dtype=object)
    code = np.select(  # in the order of MissClass, 0 for distant ones: the first that holds
        [
            n_relevant == 0,
            n_matched == 0,
            lag_s > params.lag_s,
            gap_s > params.gap_s,
            tail_s > params.gap_s,
            coverage < params.coverage,
        ],
        range(len(classes) - 1),
        default=len(classes) - 1,
    )
    miss_class = classes[code]
    return pd.DataFrame(
        {
            "n_relevant": n_relevant,
            "matched": n_matched,
            "peak_k": peak_k,
            "coverage": coverage,
            "is_detected": is_detected,
            "lag_s": lag_s,
            "gap_s": gap_s,
            "tail_s": tail_s,
            "miss_class": pd.Series(miss_class, dtype=object),  # not str: None stays None
        }
    )


RELEVANT_K: Final = 0.5
"""Least proximity weight of a relevant pedestrian."""
