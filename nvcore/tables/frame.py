"""One frame summarised: who is there, who is missed by which system, false alarms."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.schema import DetectionState, TruthState
from nvcore.scoring import SystemResult
from nvcore.tables.box_states import gather_boxes


@dataclass(frozen=True)
class SystemSummary:
    """One system in one frame.

    Attributes
    ----------
    name
        The system's name.
    similarity, similarity_window
        Of this frame and its moving mean, 0..1, 1 is best.
    n_det, matched, false_alarms
        Detections that count; pedestrians matched; detections that match nobody.
    n_absorbed
        Detections on ignore regions; they count for nothing.
    """

    name: str
    similarity: float
    similarity_window: float
    n_det: int
    matched: int
    false_alarms: int
    n_absorbed: int


@dataclass(frozen=True, eq=False)
class FrameSummary:
    """One frame.

    Attributes
    ----------
    recording, recording_index
        Name and row of the recording.
    row, row_in_recording
        Row of the frames table, and within the recording.
    frame, time_s
        Frame number; seconds since the recording's first listed frame.
    n_truth, n_ignored
        Pedestrians, and boxes that the truth ignores.
    x, y
        The two systems.
    pedestrians
        The tallest first, columns track, height_px, distance_m (NaN
        unknown), proximity weight k, is_relevant (``k >= 0.5``), found_x and found_y (matched by
        X, by Y), is_salient_x and is_salient_y (the most salient miss).
    """

    recording: str
    recording_index: int
    row: int
    row_in_recording: int
    frame: int
    time_s: float
    n_truth: int
    n_ignored: int
    x: SystemSummary
    y: SystemSummary
    pedestrians: pd.DataFrame

    @property
    def missed(self) -> pd.DataFrame:
        """The pedestrians that X or Y misses."""
        table = self.pedestrians
        return table[~(table["found_x"] & table["found_y"])]


def frame_summary(result: Result, row: int) -> FrameSummary:
    """Summary of one frame, by its row in the frames table."""
    dataset, frames = result.dataset, result.dataset.frame_columns
    truth = dataset.truth
    boxes = gather_boxes(result, row, row + 1)
    rows = np.arange(truth.offsets[row], truth.offsets[row + 1])
    table = pd.DataFrame(
        {
            "track": result.tracks.track[rows],
            "height_px": truth.h[rows],
            "distance_m": truth.distance_m[rows],
            "k": result.k_truth.k[rows],
            "is_relevant": boxes.truth.is_relevant,
            "found_x": boxes.truth.state_x == TruthState.MATCHED,
            "found_y": boxes.truth.state_y == TruthState.MATCHED,
            "is_salient_x": boxes.truth.is_salient_x,
            "is_salient_y": boxes.truth.is_salient_y,
        }
    )[~truth.ignore[rows]]
    recording = int(frames.recording[row])
    return FrameSummary(
        recording=str(dataset.recordings["name"].iloc[recording]),
        recording_index=recording,
        row=row,
        row_in_recording=row - int(frames.first[recording]),
        frame=int(frames.frame[row]),
        time_s=float(dataset.frames["time_s"].iloc[row]),
        n_truth=int(result.n_truth[row]),
        n_ignored=int(np.count_nonzero(truth.ignore[rows])),
        x=_system_summary(result.x, boxes.x.state, row),
        y=_system_summary(result.y, boxes.y.state, row),
        pedestrians=table.sort_values("height_px", ascending=False, kind="stable").reset_index(
            drop=True
        ),
    )


def _system_summary(system: SystemResult, state: np.ndarray, row: int) -> SystemSummary:
    return SystemSummary(
        name=system.name,
        similarity=float(system.similarity[row]),
        similarity_window=float(system.similarity_window[row]),
        n_det=int(system.n_det[row]),
        matched=int(system.matched[row]),
        false_alarms=int(system.false_alarms[row]),
        n_absorbed=int(np.count_nonzero(state == DetectionState.ABSORBED)),
    )
