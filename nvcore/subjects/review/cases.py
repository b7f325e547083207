"""Cases of a comparison that a person looks at one by one: misses, false alarms, doubtful truth."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.findings import TRUTH_NAME, Finding
from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.metrics.false_alarms import link_alarms
from nvcore.tables.moments import encounter_moments

COLUMNS: Final = (
    *("case", "kind", "systems", "recording", "first_frame", "last_frame", "frame"),
    *("x", "y", "w", "h", "severity_s", "encounter", "finding"),
)


MOST_PLAYED: Final = 9
PLAYED_AROUND: Final = 2
"""Frames before and after that of a case which has no other."""


class CaseKind(StrEnum):
    """Kind of case."""

    MISS = "miss"
    FALSE_ALARM = "false alarm"
    TRUTH = "doubtful truth"


@dataclass(frozen=True, eq=False)
class CaseList:
    """Cases of a comparison.

    Attributes
    ----------
    table
        One row per case: case (identifier, the same for other settings and versions of a system),
        kind (`CaseKind`), systems (``x``, ``y`` or ``xy``: who misses or reports), recording,
        first_frame, last_frame, frame (the one to look at), x, y, w, h (box there, px), severity_s
        (of the worse miss, or duration of a false alarm; NaN of doubtful truth), encounter (row of
        the comparison's encounters, -1: none) and finding (its code, empty: none).
    boxes
        Rows of the dataset's boxes that each case is about.
    """

    table: pd.DataFrame
    boxes: tuple[np.ndarray, ...]

    def __len__(self) -> int:
        return len(self.table)


@dataclass(frozen=True)
class Shot:
    """Frames of a recording around the one to look at of a case.

    Attributes
    ----------
    rows
        Rows of the frames within the recording.
    boxes
        Box of the case in each of them: x, y, w, h, px.
    at
        Position of the frame to look at.
    """

    recording: int
    rows: list[int]
    boxes: list[list[float]]
    at: int


def shots(dataset: Dataset, cases: CaseList) -> list[Shot]:
    """Return up to `MOST_PLAYED` frames of each case, within a second of the one to look at.

    A case of a single frame has those around it as well, at the same place.
    """
    frames, frame_index = dataset.frame_columns, dataset.boxes["frame_index"].to_numpy()
    xywh = dataset.boxes[["x", "y", "w", "h"]].to_numpy(np.float64).round(1)
    found = []
    # a loop over cases, whose numbers of boxes differ
    for number, own in zip(cases.table["frame"].tolist(), cases.boxes, strict=True):
        at = int(np.flatnonzero(frames.frame[frame_index[own]] == number)[0])
        here = int(frame_index[own[at]])
        recording = int(frames.recording[here])
        first, end = (int(frames.first[recording + i]) for i in (0, 1))
        near = np.flatnonzero(np.abs(frame_index[own] - here) <= frames.fps[recording])
        if len(near) > 1:
            spread = np.linspace(near[0], near[-1], min(MOST_PLAYED, len(near))).round()
            chosen = own[np.union1d(spread.astype(np.int64), [at])]
            rows, boxes = frame_index[chosen], xywh[chosen]
        else:
            rows = np.arange(max(first, here - PLAYED_AROUND), min(end, here + PLAYED_AROUND + 1))
            boxes = np.repeat(xywh[own[[at]]], len(rows), axis=0)
        shown = int(np.searchsorted(rows, here))
        found.append(Shot(recording, (rows - first).tolist(), boxes.tolist(), shown))
    return found


def find_cases(result: Result, findings: Sequence[Finding] = ()) -> CaseList:
    """List the misses of X and Y, their false alarms, and truth boxes that the audit doubts.

    A miss is an encounter with severity above 0 for X or Y. A false alarm is a false-alert episode
    of one of them. Misses come first, the most severe first.

    Parameters
    ----------
    findings
        Findings of the audit of the comparison's data.
    """
    parts = [
        _misses(result),
        *(_false_alarms(result, letter) for letter in "xy"),
        _doubts(result.dataset, findings),
    ]
    table = pd.concat([part.table for part in parts], ignore_index=True)
    boxes = tuple(rows for part in parts for rows in part.boxes)
    is_first = ~table["case"].duplicated().to_numpy()
    return CaseList(
        table[is_first].reset_index(drop=True),
        tuple(rows for rows, is_kept in zip(boxes, is_first, strict=True) if is_kept),
    )


def _misses(result: Result) -> CaseList:
    encounters, truth = result.encounters, result.dataset.truth
    severity = {letter: of.failures["severity_s"].to_numpy() for letter, of in result.sides}
    worst = np.maximum(severity["x"], severity["y"])
    chosen = np.flatnonzero(worst > 0)
    chosen = chosen[np.argsort(-worst[chosen], kind="stable")]
    boxes = [encounters.order[slice(*encounters.offsets[e : e + 2])] for e in chosen]
    shown = encounter_moments(result)["shown_row"].to_numpy()[chosen]
    at = [
        rows[np.searchsorted(truth.frame_index[rows], row)]
        for rows, row in zip(boxes, shown, strict=True)
    ]
    systems = [
        "".join(letter for letter in "xy" if severity[letter][e] > 0) for e in chosen.tolist()
    ]
    return _list(
        result.dataset, CaseKind.MISS, truth, boxes, at, systems, worst[chosen], encounter=chosen
    )


def _false_alarms(result: Result, letter: str) -> CaseList:
    system = result.system(letter)
    detections, frames = result.dataset.system(system.name), result.dataset.frame_columns
    rows, episode = link_alarms(detections, system.matches.is_false_alarm, frames)
    order = np.argsort(episode, kind="stable")
    boxes = np.split(rows[order], np.cumsum(np.bincount(episode))[:-1]) if len(rows) else []
    largest = [own[np.argmax(detections.h[own])] for own in boxes]
    duration = system.episodes["duration_s"].to_numpy()
    made = _list(
        *(result.dataset, CaseKind.FALSE_ALARM, detections, boxes, largest),
        *([letter] * len(boxes), duration),
    )
    longest = np.argsort(-duration, kind="stable")
    return CaseList(
        made.table.iloc[longest].reset_index(drop=True), tuple(made.boxes[i] for i in longest)
    )


def _doubts(dataset: Dataset, findings: Iterable[Finding]) -> CaseList:
    truth, rows, codes = dataset.truth, [], []
    for finding in findings:
        if finding.subject == TRUTH_NAME and finding.cases and finding.cases.table == "boxes":
            rows += finding.cases.rows.tolist()
            codes += [finding.code] * len(finding.cases)
    boxes = [np.array([row], np.int64) for row in rows]
    return _list(
        *(dataset, CaseKind.TRUTH, truth, boxes, rows, [""] * len(rows)),
        np.full(len(rows), np.nan),
        finding=codes,
    )


def _list(
    dataset: Dataset,
    kind: CaseKind,
    columns: BoxColumns,
    boxes: Sequence[np.ndarray],
    shown: Sequence[int],
    systems: Sequence[str],
    severity_s: np.ndarray,
    *,
    encounter: np.ndarray | int = -1,
    finding: Sequence[str] | str = "",
) -> CaseList:
    """Return the cases about some boxes of one source, whose rows are in the order of frames."""
    frames, at = dataset.frame_columns, np.asarray(shown, np.int64)
    ends = np.array([(own[0], own[-1]) for own in boxes], np.int64).reshape(-1, 2)
    first, last = columns.frame_index[ends].T
    names = dataset.recordings["name"].to_numpy()[frames.recording[first]]
    table = pd.DataFrame(
        {
            "kind": kind.value,
            "systems": systems,
            "recording": names,
            "first_frame": frames.frame[first],
            "last_frame": frames.frame[last],
            "frame": frames.frame[columns.frame_index[at]],
            **{name: values[at] for name, values in zip("xywh", columns.xywh, strict=True)},
            "severity_s": severity_s,
            "encounter": encounter,
            "finding": finding,
        }
    )
    of_system = systems if kind is CaseKind.FALSE_ALARM else [""] * len(boxes)
    sides = np.stack([values[ends[:, 0]] for values in columns.xywh], axis=1).round(1)
    keys = zip(names, table["first_frame"], of_system, table["finding"], sides, strict=True)
    names_of_cases = [_identifier(kind, *of, *box.tolist()) for *of, box in keys]
    table["case"] = pd.Series(names_of_cases, dtype="str")
    return CaseList(table[list(COLUMNS)], tuple(columns.first_row + own for own in boxes))


def _identifier(*parts: object) -> str:
    """Return ten hexadecimal digits of what makes a case the same in another comparison."""
    text = "\n".join(map(str, parts))
    return hashlib.sha256(text.encode()).hexdigest()[:10]
