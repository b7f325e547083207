"""Summary of one frame: its pedestrians, the systems that miss them, and the cost of each box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import DetectionState, TruthState
from nvcore.metrics.proximity import in_use
from nvcore.metrics.similarity import border_of, miss_terms
from nvcore.tables.boxes.states import gather_boxes


class Words(NamedTuple):
    """Label and meaning of a column on screen and in the report."""

    label: str
    meaning: str


_TERM: Final = (
    "k × the smaller of border and nearest, as a share of half the width. The largest of the frame "
    "is D(G, S), and alpha times it is what {letter} loses to misses here."
)
_NEAREST: Final = (
    "Distance to the nearest detection of {letter}; strict pairing: to the match. –: there is none."
)
PEDESTRIAN_WORDS: Final[dict[str, Words]] = {
    "track": Words("{short}", "Track of the {one}."),
    "missed_by": Words("missed by", "Who misses this {one}; empty: nobody."),
    "term_x": Words("term X", _TERM.format(letter="X")),
    "term_y": Words("term Y", _TERM.format(letter="Y")),
    "cost": Words(
        "cost",
        "What missing this {one} costs, k × border as a share of half the width; 1: straight "
        "ahead and near. Counts where the {one} is missed and k is at least 0.5.",
    ),
    "k": Words(
        "k", "Proximity weight, 0 far to 1 near; from 0.5 on a miss counts in the encounter."
    ),
    "border_px": Words(
        "border (px)",
        "The most that missing this {one} can count for: by traffic context between the "
        "distance to the picture's nearer side and half the width.",
    ),
    "nearest_px_x": Words("near X (px)", _NEAREST.format(letter="X")),
    "nearest_px_y": Words("near Y (px)", _NEAREST.format(letter="Y")),
    "height_px": Words("height (px)", "Height of the box."),
}
"""Columns of `FrameSummary.pedestrians` that are shown, in their order."""

DETECTION_WORDS: Final[dict[str, Words]] = {
    "system": Words("of", "Which system's detection it is."),
    "outcome": Words("outcome", "Whether it matches {a_one} or is a false alarm."),
    "term": Words(
        "term",
        "k × the smaller of border and nearest, as a share of half the width. The largest of a "
        "system is D(S, G), and (1 − alpha) times it is what the frame loses to false alarms.",
    ),
    "k": Words("k", "Proximity weight of the detection, 0 far to 1 near."),
    "border_px": Words("border (px)", "The most that this detection can count for."),
    "nearest_px": Words("near (px)", "Distance to the nearest {one}. –: {nobody} is there."),
    "score": Words("score", "Score of the detection. –: it has none."),
}
"""Columns of `FrameSummary.detections`, in their order."""


MISSED_BY: Final = np.array(["", "Y", "X", "X and Y"], dtype=object)
"""Systems that miss a pedestrian, indexed by 2 if X does plus 1 if Y does."""
OUTCOME: Final = np.array(["match", "false"], dtype=object)


@dataclass(frozen=True)
class SystemSummary:
    """Results of one system in one frame.

    Attributes
    ----------
    name
        Name of the system.
    similarity, similarity_window
        Similarity of this frame and its moving mean, 0..1, 1 is best.
    n_det, matched, false_alarms
        Numbers of detections that count, matched pedestrians, and detections that match nobody.
    n_absorbed
        Number of detections on ignore regions, which do not count.
    loss_miss, loss_false
        Loss of the frame to misses and to false alarms, 0 is best. Similarity is 1 minus both.
    """

    name: str
    similarity: float
    similarity_window: float
    n_det: int
    matched: int
    false_alarms: int
    n_absorbed: int
    loss_miss: float
    loss_false: float


@dataclass(frozen=True, eq=False)
class FrameSummary:
    """Results of both systems in one frame, with its pedestrians and detections.

    Attributes
    ----------
    recording, recording_index
        Name and row of the recording.
    row, row_in_recording
        Row of the frames table, and within the recording.
    frame, time_s
        Frame number; seconds since the recording's first listed frame.
    n_truth, n_ignored
        Numbers of pedestrians, and of boxes that the truth ignores.
    x, y
        The two systems.
    pedestrians
        Table sorted by largest term, with columns track, height_px, distance_m (NaN unknown),
        proximity
        weight k, is_relevant (``k >= 0.5``), is_matched_x and is_matched_y, missed_by
        (``X and Y``, ``X``, ``Y`` or empty), is_salient_x and is_salient_y (the most salient
        miss), border_px, nearest_px_x and nearest_px_y (infinite: no detection), term_x and term_y
        (own term of D(G, S) as a share of W/2, 0 is best), cost (of a miss, 0 to 1).
    detections
        Table of counted detections sorted by largest term, with columns system (``X`` or ``Y``),
        outcome
        (``match`` or ``false``), term (own term of D(S, G) as a share of W/2, 0 is best), k,
        border_px, nearest_px (infinite: no pedestrian), score (NaN: none).
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
    detections: pd.DataFrame


def frame_summary(result: Result, row: int) -> FrameSummary:
    """Summarize the frame at this row of the frames table."""
    dataset, frames = result.dataset, result.dataset.frame_columns
    n_ignored = int(np.count_nonzero(dataset.truth.ignore[dataset.truth.rows_of(row, row + 1)]))
    recording = int(frames.recording[row])
    return FrameSummary(
        recording=str(dataset.recordings["name"].iloc[recording]),
        recording_index=recording,
        row=row,
        row_in_recording=row - int(frames.first[recording]),
        frame=int(frames.frame[row]),
        time_s=float(dataset.frames["time_s"].iloc[row]),
        n_truth=int(result.n_truth[row]),
        n_ignored=n_ignored,
        x=_system_summary(result, result.x, row),
        y=_system_summary(result, result.y, row),
        pedestrians=_pedestrians(result, row),
        detections=_detections(result, row),
    )


def _pedestrians(result: Result, row: int) -> pd.DataFrame:
    dataset, frames = result.dataset, result.dataset.frame_columns
    rows, truth = dataset.truth.rows_of(row, row + 1), result.weighed_truth.of_frames(row, row + 1)
    k = result.k_truth.k[rows]
    boxes = gather_boxes(result, row, row + 1).truth
    edge_weight = in_use(result.params, "edge_weight", frames)
    half_width = frames.half_width[row]
    nearest = {letter: system.nearest.truth[rows] for letter, system in result.sides}
    terms = {
        letter: miss_terms(truth, result.k_miss[rows], nearest_px, frames, edge_weight) / half_width
        for letter, nearest_px in nearest.items()
    }
    is_matched_x, is_matched_y = (
        state == TruthState.MATCHED for state in (boxes.state_x, boxes.state_y)
    )
    worse = np.maximum(terms["x"], terms["y"])
    rows_by_term = np.lexsort([-k, -worse])
    return _table(
        {
            "track": result.tracks.track[rows],
            "height_px": truth.h,
            "distance_m": truth.distance_m,
            "k": k,
            "is_relevant": boxes.is_relevant,
            "is_matched_x": is_matched_x,
            "is_matched_y": is_matched_y,
            "missed_by": MISSED_BY[2 * ~is_matched_x + ~is_matched_y],
            "is_salient_x": boxes.is_salient_x,
            "is_salient_y": boxes.is_salient_y,
            "border_px": border_of(truth, frames, edge_weight),
            "nearest_px_x": nearest["x"],
            "nearest_px_y": nearest["y"],
            "term_x": terms["x"],
            "term_y": terms["y"],
            "cost": result.cost[rows],
        },
        rows_by_term[~truth.ignore[rows_by_term]],
    )


def _table(columns: Mapping[str, np.ndarray], rows: np.ndarray) -> pd.DataFrame:
    """Make a table of the selected rows of some columns.

    Selecting rows before making the table is quicker.
    """
    return pd.DataFrame({name: values[rows] for name, values in columns.items()})


def _detections(result: Result, row: int) -> pd.DataFrame:
    frames = result.dataset.frame_columns
    edge_weight = in_use(result.params, "edge_weight", frames)
    half_width = frames.half_width[row]
    parts = []
    for letter, system in result.sides:
        detections = result.dataset.system(system.name)
        rows, boxes = detections.rows_of(row, row + 1), detections.of_frames(row, row + 1)
        state = system.matches.state[rows]
        border_px = border_of(boxes, frames, edge_weight)
        k, nearest_px = system.weights.k[rows], system.nearest.detections[rows]
        parts.append(
            {
                "system": np.full(len(boxes), letter.upper(), dtype=object),
                "outcome": OUTCOME[np.where(state == DetectionState.MATCHED, 0, 1)],
                "term": k * np.minimum(border_px, nearest_px) / half_width,
                "k": k,
                "border_px": border_px,
                "nearest_px": nearest_px,
                "score": boxes.score,
                "state": state,
            }
        )
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    is_counted = np.isin(columns.pop("state"), (DetectionState.MATCHED, DetectionState.FALSE_ALARM))
    rows_by_term = np.argsort(-columns["term"], kind="stable")
    return _table(columns, rows_by_term[is_counted[rows_by_term]])


def _system_summary(result: Result, system: SystemResult, row: int) -> SystemSummary:
    frames, alpha = result.dataset.frame_columns, result.params.alpha
    state = system.matches.state[result.dataset.system(system.name).rows_of(row, row + 1)]
    # only of this frame, as `SystemResult.loss_miss` would compute all frames
    half_width = frames.half_width[row]
    return SystemSummary(
        name=system.name,
        similarity=float(system.similarity[row]),
        similarity_window=float(system.similarity_window[row]),
        n_det=int(system.n_det[row]),
        matched=int(system.matched[row]),
        false_alarms=int(system.false_alarms[row]),
        n_absorbed=int(np.count_nonzero(state == DetectionState.ABSORBED)),
        loss_miss=float(alpha * system.distances.d_miss[row] / half_width),
        loss_false=float((1 - alpha) * system.distances.d_false[row] / half_width),
    )
