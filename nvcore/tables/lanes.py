"""State lanes: each system's outcome for every pedestrian of a recording, as runs over time."""

from __future__ import annotations

from enum import StrEnum
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import NO_TRACK
from nvcore.metrics.encounters import RELEVANT_K


class LaneState(StrEnum):
    """Outcome of a system for a pedestrian in one frame."""

    IGNORED = "ignored"
    """The ground truth says not to judge the pedestrian here."""
    NOT_RELEVANT = "not_relevant"
    """Too far away to count."""
    MISSED = "missed"
    """Near enough to count, and not matched."""
    MATCHED = "matched"
    """Near enough to count, and matched."""


# where a track occurs twice in a frame, the larger code counts
_CODES: Final = tuple(LaneState)
_IGNORED, _NOT_RELEVANT, _MISSED, _MATCHED = range(len(_CODES))


def lanes_table(result: Result, recording: int) -> pd.DataFrame:
    """Return one row per run of frames with the same state of a system for a pedestrian.

    Frames in which the pedestrian is not annotated belong to no run and end the previous one.

    Parameters
    ----------
    recording
        Row of the recordings table.

    Returns
    -------
    Columns encounter (row of ``result.encounters``), track, system (``"x"`` or
    ``"y"``), state (`LaneState`), first_row and last_row (of the frames table, inclusive), start_s
    and stop_s (the end of the last frame's time step), seconds. Sorted by encounter, system and
    time. A recording without pedestrians: no rows.
    """
    time_s = result.dataset.frames["time_s"].to_numpy()
    step_s = result.dataset.frames["step_s"].to_numpy()
    rows, encounter, frame_row = _annotated_rows(result, recording)
    runs = []
    for side, (_, system) in enumerate(result.sides):
        run = _runs(rows, encounter, frame_row, _codes(result, system, rows))
        runs.append((*run, np.full(len(run[0]), side)))
    of, code, first, last, number = (np.concatenate(part) for part in zip(*runs, strict=True))
    order = np.argsort(2 * of + number, kind="stable")
    of, code, first, last, number = (part[order] for part in (of, code, first, last, number))
    return pd.DataFrame(
        {
            "encounter": of,
            "track": result.encounters.track[of],
            "system": np.array(["x", "y"], dtype=object)[number],
            "state": np.array([state.value for state in _CODES], dtype=object)[code],
            "first_row": first,
            "last_row": last,
            "start_s": time_s[first],
            "stop_s": time_s[last] + step_s[last],
        }
    )


def miss_starts(result: Result, recording: int, system: SystemResult) -> np.ndarray:
    """Return the frame rows in which one system begins to miss a relevant pedestrian.

    int64, increasing, unique; rows of the frames table.
    """
    rows, encounter, frame_row = _annotated_rows(result, recording)
    _, code, first, _ = _runs(rows, encounter, frame_row, _codes(result, system, rows))
    return np.unique(first[code == _MISSED])


def _annotated_rows(result: Result, recording: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the truth rows of a recording's encounters, with their encounters and frame rows.

    They are sorted by encounter and frame, and include the ignored boxes of the encounters' tracks.
    """
    encounters, truth = result.encounters, result.dataset.truth
    e0, e1 = np.searchsorted(encounters.recording, [recording, recording + 1])
    member = slice(encounters.offsets[e0], encounters.offsets[e1])
    rows = encounters.order[member]
    encounter = np.repeat(np.arange(e0, e1), np.diff(encounters.offsets[e0 : e1 + 1]))
    frame_row = encounters.frame_index[member]
    t0, t1 = truth.offsets[result.dataset.frame_columns.first[[recording, recording + 1]]]
    track = result.tracks.track
    ignored_rows = t0 + np.flatnonzero(truth.ignore[t0:t1] & (track[t0:t1] != NO_TRACK))
    if len(ignored_rows) and e1 > e0:
        of = e0 + np.searchsorted(encounters.track[e0:e1], track[ignored_rows])
        is_known = encounters.track[np.minimum(of, e1 - 1)] == track[ignored_rows]
        ignored_rows, of = ignored_rows[is_known], of[is_known]
        rows = np.concatenate([rows, ignored_rows])
        encounter = np.concatenate([encounter, of])
        frame_row = np.concatenate([frame_row, truth.frame_index[ignored_rows]])
        order = np.lexsort((frame_row, encounter))
        rows, encounter, frame_row = rows[order], encounter[order], frame_row[order]
    return rows, encounter, frame_row


def _codes(result: Result, system: SystemResult, rows: np.ndarray) -> np.ndarray:
    """Return the index into `_CODES` of each truth row."""
    code = np.where(system.matches.truth_det[rows] >= 0, _MATCHED, _MISSED)
    code[result.k_truth.k[rows] < RELEVANT_K] = _NOT_RELEVANT
    code[result.dataset.truth.ignore[rows]] = _IGNORED
    return code


def _runs(
    rows: np.ndarray, encounter: np.ndarray, frame_row: np.ndarray, code: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return encounter, code, first and last frame row of every run."""
    if not len(rows):
        empty = np.empty(0, np.int64)
        return empty, empty, empty, empty
    is_new = (encounter[1:] != encounter[:-1]) | (frame_row[1:] != frame_row[:-1])
    starts = np.flatnonzero(np.concatenate([[True], is_new]))
    code = np.maximum.reduceat(code, starts)
    encounter, frame_row = encounter[starts], frame_row[starts]
    ends = (
        (encounter[1:] != encounter[:-1])
        | (frame_row[1:] != frame_row[:-1] + 1)
        | (code[1:] != code[:-1])
    )
    first = np.flatnonzero(np.concatenate([[True], ends]))
    last = np.concatenate([first[1:] - 1, [len(frame_row) - 1]])
    return encounter[first], code[first], frame_row[first], frame_row[last]
