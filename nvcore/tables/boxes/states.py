"""Boxes of consecutive frames with the outcome of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.dataset.schema import NO_TRACK, DetectionState, TruthState
from nvcore.metrics.encounters import RELEVANT_K

_LARGEST_TRACK: Final = 2**31 - 1


@dataclass(frozen=True, eq=False)
class TruthBoxes:
    """Truth boxes of consecutive frames, by frame.

    Attributes
    ----------
    frame
        Frame of each box, counted from the first of these frames; int64, shape (n,).
    xywh
        px; float32, (n, 4).
    score
        NaN: none; float32, (n,).
    track
        NO_TRACK if none; int32, (n,). If an id of the recording does not fit int32: the rank of
        each id among the recording's ids.
    state_x, state_y
        `TruthState` for each system; uint8, (n,).
    is_relevant
        Pedestrians near enough to count (``k >= 0.5``); bool, (n,).
    is_salient_x, is_salient_y
        The most salient pedestrian of its frame, missed by more than the tolerance; bool, (n,).
    """

    frame: np.ndarray
    xywh: np.ndarray
    score: np.ndarray
    track: np.ndarray
    state_x: np.ndarray
    state_y: np.ndarray
    is_relevant: np.ndarray
    is_salient_x: np.ndarray
    is_salient_y: np.ndarray


@dataclass(frozen=True, eq=False)
class DetectedBoxes:
    """Detections of consecutive frames, by frame, without those below the threshold.

    Attributes
    ----------
    frame, xywh, score, track
        See `TruthBoxes`.
    state
        `DetectionState`, never BELOW; int8, (n,).
    """

    frame: np.ndarray
    xywh: np.ndarray
    score: np.ndarray
    track: np.ndarray
    state: np.ndarray


@dataclass(frozen=True, eq=False)
class FrameBoxes:
    """All boxes of consecutive frames."""

    truth: TruthBoxes
    x: DetectedBoxes
    y: DetectedBoxes


def gather_boxes(result: Result, row_start: int, row_stop: int) -> FrameBoxes:
    """Return the boxes of frames ``row_start:row_stop`` (rows of the frames table) with states."""
    assert 0 <= row_start <= row_stop <= len(result.dataset.frames), (row_start, row_stop)
    rows = (row_start, row_stop)
    return FrameBoxes(
        truth=_gather_truth(result, *rows),
        x=_gather_detections(result, result.x, *rows),
        y=_gather_detections(result, result.y, *rows),
    )


def _gather_truth(result: Result, row_start: int, row_stop: int) -> TruthBoxes:
    truth = result.dataset.truth
    boxes = truth.rows_of(row_start, row_stop)
    is_pedestrian = ~truth.ignore[boxes]
    return TruthBoxes(
        frame=truth.frame_index[boxes] - row_start,
        xywh=_xywh(truth, boxes),
        score=truth.score[boxes].astype(np.float32),
        track=_short_tracks(
            result.tracks.track, truth.offsets, result.dataset.frame_columns, row_start, row_stop
        ),
        state_x=_truth_state(result.x, boxes, is_pedestrian),
        state_y=_truth_state(result.y, boxes, is_pedestrian),
        is_relevant=(result.k_truth.k[boxes] >= RELEVANT_K) & is_pedestrian,
        is_salient_x=_is_salient(result.x, boxes, row_start, row_stop),
        is_salient_y=_is_salient(result.y, boxes, row_start, row_stop),
    )


def _gather_detections(
    result: Result, system: SystemResult, row_start: int, row_stop: int
) -> DetectedBoxes:
    detections = result.dataset.system(system.name)
    boxes = detections.rows_of(row_start, row_stop)
    track = _short_tracks(
        detections.track, detections.offsets, result.dataset.frame_columns, row_start, row_stop
    )
    state = system.matches.state[boxes]
    is_used = state != DetectionState.BELOW
    return DetectedBoxes(
        frame=detections.frame_index[boxes][is_used] - row_start,
        xywh=_xywh(detections, boxes)[is_used],
        score=detections.score[boxes][is_used].astype(np.float32),
        track=track[is_used],
        state=state[is_used],
    )


def _xywh(boxes: BoxColumns, rows: slice) -> np.ndarray:
    edges = [boxes.x[rows], boxes.y[rows], boxes.w[rows], boxes.h[rows]]
    return np.column_stack(edges).astype(np.float32)


def _truth_state(system: SystemResult, boxes: slice, is_pedestrian: np.ndarray) -> np.ndarray:
    is_matched = system.matches.truth_det[boxes] >= 0
    state = np.where(is_matched, TruthState.MATCHED, TruthState.MISSED)
    return np.where(is_pedestrian, state, TruthState.NOT_JUDGED).astype(np.uint8)


def _is_salient(system: SystemResult, boxes: slice, row_start: int, row_stop: int) -> np.ndarray:
    salient_rows = system.salient_row[row_start:row_stop]
    is_salient = np.zeros(boxes.stop - boxes.start, dtype=bool)
    is_salient[salient_rows[salient_rows >= 0] - boxes.start] = True
    return is_salient


def _short_tracks(
    track: np.ndarray, offsets: np.ndarray, frames: FrameColumns, row_start: int, row_stop: int
) -> np.ndarray:
    """Return the tracks of the boxes of some frames as int32."""
    start, stop = offsets[row_start], offsets[row_stop]
    short = np.empty(stop - start, np.int32)
    recordings = np.unique(frames.recording[row_start:row_stop])
    for recording in recordings:  # a loop over recordings, nearly always just one
        # use the ids of the whole recording, so that all its parts are numbered alike
        first, last = offsets[frames.first[[recording, recording + 1]]]
        ids = track[first:last]
        part = slice(max(start, first) - start, min(stop, last) - start)
        long = track[start:stop][part]
        if len(ids) and (ids.min() < NO_TRACK or ids.max() > _LARGEST_TRACK):
            sorted_ids = np.unique(ids[ids != NO_TRACK])
            long = np.where(long == NO_TRACK, NO_TRACK, np.searchsorted(sorted_ids, long))
        short[part] = long
    return short
