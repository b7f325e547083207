"""State lanes: how each system did with every pedestrian of a recording, as runs over time."""

from __future__ import annotations

from enum import StrEnum
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result, SystemResult
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.schema import NO_TRACK

LANE_COLUMNS: Final = (
    "encounter", "track", "system", "state", "first_row", "last_row", "start_s", "stop_s",
)  # fmt: skip


class LaneState(StrEnum):
    """What a system made of a pedestrian in one frame."""

    IGNORED = "ignored"
    """The ground truth says not to judge the pedestrian here."""
    NOT_RELEVANT = "not_relevant"
    """Too far away to count."""
    MISSED = "missed"
    """Near enough to count, and not matched."""
    MATCHED = "matched"
    """Near enough to count, and matched."""


# the larger code names a frame in which one track stands twice
_CODES: Final = tuple(LaneState)
_IGNORED, _NOT_RELEVANT, _MISSED, _MATCHED = range(len(_CODES))


def lanes_table(result: Result, recording: int) -> pd.DataFrame:
    """One row per run of frames in which a system makes the same of a pedestrian.

    Frames in which the pedestrian is not annotated belong to no run and end the one before.

    Parameters
    ----------
    recording
        Row of the recordings table.

    Returns
    -------
    Columns `LANE_COLUMNS`: encounter (row of ``result.encounters``), track, system (``"x"`` or
    ``"y"``), state (`LaneState`), first_row and last_row (of the frames table, inclusive), start_s
    and stop_s (the end of the last frame's time step), seconds. Sorted by encounter, system and
    time. A recording without pedestrians: no rows.
    """
    time_s = result.dataset.frames["time_s"].to_numpy()
    step_s = result.dataset.frames["step_s"].to_numpy()
    rows, encounter, at = _annotated(result, recording)
    runs = []
    for which, (_, system) in enumerate(result.sides):
        found = _runs(rows, encounter, at, _codes(result, system, rows))
        runs.append((*found, np.full(len(found[0]), which)))
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
        },
        columns=list(LANE_COLUMNS),
    )


def miss_starts(result: Result, recording: int, system: SystemResult) -> np.ndarray:
    """Frame rows in which a relevant pedestrian begins to be missed by one system.

    int64, increasing, unique; rows of the frames table.
    """
    rows, encounter, at = _annotated(result, recording)
    _, code, first, _ = _runs(rows, encounter, at, _codes(result, system, rows))
    return np.unique(first[code == _MISSED])


def _annotated(result: Result, recording: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Truth rows that belong to encounters of a recording, their encounters and frame rows.

    Sorted by encounter and frame; with the ignored boxes of the encounters' tracks.
    """
    encounters, truth = result.encounters, result.dataset.truth
    e0, e1 = np.searchsorted(encounters.recording, [recording, recording + 1])
    member = slice(encounters.offsets[e0], encounters.offsets[e1])
    rows = encounters.order[member]
    encounter = np.repeat(np.arange(e0, e1), np.diff(encounters.offsets[e0 : e1 + 1]))
    at = encounters.frame_index[member]
    t0, t1 = truth.offsets[result.dataset.frame_columns.first[[recording, recording + 1]]]
    track = result.tracks.track
    ignored = t0 + np.flatnonzero(truth.ignore[t0:t1] & (track[t0:t1] != NO_TRACK))
    if len(ignored) and e1 > e0:
        of = e0 + np.searchsorted(encounters.track[e0:e1], track[ignored])
        is_known = encounters.track[np.minimum(of, e1 - 1)] == track[ignored]
        ignored, of = ignored[is_known], of[is_known]
        rows = np.concatenate([rows, ignored])
        encounter = np.concatenate([encounter, of])
        at = np.concatenate([at, truth.frame_index[ignored]])
        order = np.lexsort((at, encounter))
        rows, encounter, at = rows[order], encounter[order], at[order]
    return rows, encounter, at


def _codes(result: Result, system: SystemResult, rows: np.ndarray) -> np.ndarray:
    """Index into `_CODES` of each of some truth rows."""
    code = np.where(system.matches.truth_det[rows] >= 0, _MATCHED, _MISSED)
    code[result.k_truth.k[rows] < RELEVANT_K] = _NOT_RELEVANT
    code[result.dataset.truth.ignore[rows]] = _IGNORED
    return code


def _runs(
    rows: np.ndarray, encounter: np.ndarray, at: np.ndarray, code: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Encounter, code, first and last frame row of every run."""
    if not len(rows):
        nothing = np.empty(0, np.int64)
        return nothing, nothing, nothing, nothing
    is_new = (encounter[1:] != encounter[:-1]) | (at[1:] != at[:-1])
    starts = np.flatnonzero(np.concatenate([[True], is_new]))
    code = np.maximum.reduceat(code, starts)
    encounter, at = encounter[starts], at[starts]
    ends = (encounter[1:] != encounter[:-1]) | (at[1:] != at[:-1] + 1) | (code[1:] != code[:-1])
    first = np.flatnonzero(np.concatenate([[True], ends]))
    last = np.concatenate([first[1:] - 1, [len(at) - 1]])
    return encounter[first], code[first], at[first], at[last]
