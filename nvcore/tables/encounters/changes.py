"""Changes from the old version of a system (X) to the new one (Y), case by case."""

from __future__ import annotations

from enum import StrEnum
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import Category
from nvcore.metrics.false_alarms import link_alarms
from nvcore.metrics.kernels.checks import best_overlaps
from nvcore.metrics.linking import LINK_IOU
from nvcore.tables.column import RECORDING, CellKind, Column
from nvcore.tables.moments import encounter_moments


class Change(StrEnum):
    """Kinds of changes, the worst first. The gate counts them under their names in lower case."""

    NEWLY_MISSED = "newly missed"
    NEWLY_FALSE = "newly false"
    FIXED = "fixed"
    GONE = "gone"
    UNCHANGED = "unchanged"


_OF_CATEGORY: Final = {
    Category.X_ONLY.value: Change.NEWLY_MISSED.value,
    Category.Y_ONLY.value: Change.FIXED.value,
}
"""Kinds of encounters. Others that count are unchanged."""
_TEXT, _INTEGER, _NUMBER = CellKind.TEXT, CellKind.INTEGER, CellKind.NUMBER
_SEVERITY: Final = "version's failure: seconds of {a_one} missed straight ahead and near."
_ALARM: Final = "a false alarm"

CHANGE_COLUMNS: Final[tuple[Column, ...]] = (
    Column("kind", _TEXT, "", f"Kind of change: {', '.join(f'`{kind}`' for kind in Change)}."),
    Column("about", _TEXT, "", "`encounter`, or `false alarm`: a false-alert episode."),
    RECORDING,
    Column("track", _INTEGER, "", "Track of the {one}, as in `encounters.csv`.", empty=_ALARM),
    Column("first_frame", _INTEGER, "", "Its first frame."),
    Column("last_frame", _INTEGER, "", "Its last frame."),
    Column("duration_s", _NUMBER, "s", "Time from its first to its last frame."),
    Column("severity_s_old", _NUMBER, "s", f"Severity of the old {_SEVERITY}", "low", _ALARM),
    Column("severity_s_new", _NUMBER, "s", f"Severity of the new {_SEVERITY}", "low", _ALARM),
    Column(
        "frame", _INTEGER, "", "Frame with the costliest miss, or the false alarm's tallest box."
    ),
)
"""Columns of ``changes.csv``."""
_NAMES: Final = [column.name for column in CHANGE_COLUMNS]


def changes_table(result: Result) -> pd.DataFrame:
    """Return a row per encounter that counts and per false-alert episode (`CHANGE_COLUMNS`).

    Rows are sorted by kind, the heaviest case first.
    """
    return located_changes(result)[_NAMES]


def count_changes(result: Result) -> dict[Change, int]:
    """Count the cases of each kind."""
    kinds = located_changes(result)["kind"].tolist()
    return {kind: kinds.count(kind.value) for kind in Change}


def located_changes(result: Result) -> pd.DataFrame:
    """Return `changes_table` with the places of its cases, computed once per result.

    Returns
    -------
    In addition: row (of the frames table, for `frame`), encounter (row of ``result.encounters``,
    or -1) and box (row of the detections of the version that has the false alarm, or -1), int64.
    """
    table: pd.DataFrame = result.keep("changes", lambda: _located(result))
    return table


def _located(result: Result) -> pd.DataFrame:
    cases = pd.concat([_encounters(result), _alarms(result)], ignore_index=True)
    frames, frame = result.dataset.frame_columns, result.dataset.frames["frame"].to_numpy()
    first, last = cases["first_row"].to_numpy(), cases["last_row"].to_numpy()
    recording = frames.recording[first]
    names = result.dataset.recordings["name"].to_numpy(dtype=object)
    cases = cases.assign(
        recording=names[recording],
        first_frame=frame[first],
        last_frame=frame[last],
        duration_s=(frames.passed[last + 1] - frames.passed[first]) / frames.fps[recording],
        frame=frame[cases["row"].to_numpy()],
    )
    heavier_s = cases[["severity_s_old", "severity_s_new"]].max(axis=1).fillna(cases["duration_s"])
    kinds = cases["kind"].map([*Change].index)
    order = np.lexsort((first, -heavier_s, cases["encounter"] < 0, kinds))
    return cases.iloc[order].reset_index(drop=True)[[*_NAMES, "row", "encounter", "box"]]


def _encounters(result: Result) -> pd.DataFrame:
    near, encounters = np.flatnonzero(result.is_near), result.encounters
    kinds = pd.Series(result.category[near], dtype=object).map(_OF_CATEGORY)
    return pd.DataFrame(
        {
            "kind": kinds.fillna(Change.UNCHANGED.value),
            "about": "encounter",
            "track": pd.array(encounters.track[near], dtype="Int64"),
            "first_row": encounters.first_row[near],
            "last_row": encounters.last_row[near],
            "severity_s_old": result.x.failures["severity_s"].to_numpy()[near],
            "severity_s_new": result.y.failures["severity_s"].to_numpy()[near],
            "row": encounter_moments(result)["shown_row"].to_numpy()[near],
            "encounter": near,
            "box": -1,
        }
    )


def _alarms(result: Result) -> pd.DataFrame:
    """Return the episodes of the new version, and those of the old one that it does not have.

    Two episodes are the same if boxes of both overlap (IoU >= 0.3) in at least one frame.
    """
    dataset, (old, new) = result.dataset, (result.x, result.y)
    boxes = [dataset.system(of.name).only(of.matches.is_false_alarm) for of in (old, new)]
    gone = _episodes(result, old, _overlap_any(*boxes), Change.GONE)
    gone = gone[gone["kind"] == Change.GONE.value]
    cases = [gone, _episodes(result, new, _overlap_any(*reversed(boxes)), Change.NEWLY_FALSE)]
    table = pd.concat(cases, ignore_index=True)
    track = pd.array([pd.NA] * len(table), dtype="Int64")
    severity_s = dict.fromkeys(("severity_s_old", "severity_s_new"), np.nan)
    return table.assign(about="false alarm", encounter=-1, track=track, **severity_s)


def _overlap_any(boxes: BoxColumns, others: BoxColumns) -> np.ndarray:
    """Return which boxes overlap one of the others in their frame, bool, shape (n,)."""
    iou, which = np.empty(len(boxes)), np.empty(len(boxes), np.int64)
    place = boxes.frame_index, boxes.xywh, others.offsets[:-1], others.offsets[1:], others.xywh
    best_overlaps(*place, (1.0, 1.0), (0.0, 0.0), iou, which)
    return iou >= LINK_IOU


def _episodes(
    result: Result, system: SystemResult, shared: np.ndarray, alone: Change
) -> pd.DataFrame:
    """Return a version's false-alert episodes, each with its tallest box.

    Parameters
    ----------
    shared
        Which of its false alarms overlap one of the other version; bool.
    alone
        Kind of the episodes that have none of these.
    """
    boxes = result.dataset.system(system.name)
    is_false, frames = system.matches.is_false_alarm, result.dataset.frame_columns
    rows, episode = link_alarms(boxes, is_false, frames)
    is_shared = np.isin(np.arange(len(system.episodes)), episode[shared])
    tallest = np.lexsort((rows, -boxes.h[rows], episode))
    box = rows[tallest[np.unique(episode[tallest], return_index=True)[1]]]
    kinds = np.where(is_shared, Change.UNCHANGED.value, alone.value).astype(object)
    found = {"kind": kinds, "row": boxes.frame_index[box], "box": box}
    return system.episodes[["first_row", "last_row"]].assign(**found)
