"""Rows of the inputs that could not be placed: what was wrong with them, and how bad that is."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.auditing.cases import (
    TRUTH_NAME,
    file_name,
    place,
    spelled,
    without_doubles,
)
from nvcore.dataset import Dataset
from nvcore.findings import Cases, Finding, Severity
from nvcore.schema import DETECTABILITY
from nvcore.wording import count_text


def audit_left_out(dataset: Dataset) -> list[Finding]:
    """Findings on `Dataset.left_out`, one by subject and kind.

    A system that ran on every frame of a sampled recording is no fault: its rows between listed
    frames give a note.
    """
    lost = dataset.left_out.reset_index(drop=True)
    lost = lost[lost["subject"] != DETECTABILITY]  # see nvcore.auditing.detectability
    findings: list[Finding] = []
    for subject, group in lost.groupby("subject", sort=False):
        name = str(subject)
        for reason, rows in group.groupby("reason", sort=False):
            if reason == "frame not listed":
                findings += _not_listed(dataset, name, rows)
            elif reason == "unknown recording":
                findings.append(_unknown_recording(dataset, name, rows))
            else:
                findings.append(_no_box(dataset, name, str(reason), rows))
    return findings


def _no_box(dataset: Dataset, subject: str, reason: str, rows: pd.DataFrame) -> Finding:
    what = count_text(len(rows), "row is left out", "rows are left out")
    if reason == "not a number":
        code = "not-a-number"
        message = f"{what}: a coordinate is no finite number."
        advice = "Correct or remove the rows; find out why whatever wrote the file wrote NaN."
    else:
        code = "no-area"
        message = f"{what}: the width or height is 0 or less."
        advice = (
            "Check the order of the columns (width and height, or right and bottom edge?), then "
            "correct or remove the rows."
        )
    return _finding(dataset, Severity.ERROR, code, subject, rows, message, advice)


def _unknown_recording(dataset: Dataset, subject: str, rows: pd.DataFrame) -> Finding:
    names = without_doubles(rows["recording"])
    spellings = spelled(dataset.recordings["name"])
    message = (
        f"{count_text(len(rows), 'row is', 'rows are')} left out, of "
        f"{count_text(len(names), 'recording')} without ground truth ({spelled(names)})."
    )
    nothing = _nothing_left(dataset, subject)
    if nothing:
        message += " Nothing is left to compare."
    return _finding(
        dataset,
        Severity.ERROR if nothing else Severity.WARNING,
        "unknown-recording",
        subject,
        rows,
        message,
        f"The recordings are {spellings}: rename the files to match, or add the ground truth.",
    )


def _not_listed(dataset: Dataset, subject: str, rows: pd.DataFrame) -> list[Finding]:
    first, last, is_sampled = _listed_ranges(dataset, rows["recording"])
    frame = rows["frame"].to_numpy()
    inside = (first < frame) & (frame < last)
    is_usual = inside & is_sampled & (subject != TRUTH_NAME)
    findings = []
    if not is_usual.all():
        odd = rows[~is_usual]
        numbers = without_doubles(odd["frame"])
        message = (
            f"{count_text(len(odd), 'row is', 'rows are')} left out, in "
            f"{count_text(len(numbers), 'frame number')} not evaluated."
        )
        nothing = _nothing_left(dataset, subject)
        if nothing:
            message += " Nothing is left to compare."
        findings.append(
            _finding(
                dataset,
                Severity.ERROR if nothing else Severity.WARNING,
                "frame-not-listed",
                subject,
                odd,
                message,
                _advice(subject, frame[~is_usual], first[~is_usual], last[~is_usual]),
            )
        )
    if is_usual.any():
        between = rows[is_usual]
        findings.append(
            _finding(
                dataset,
                Severity.NOTE,
                "between-sampled-frames",
                subject,
                between,
                f"{count_text(len(between), 'row is', 'rows are')} left out, between the annotated "
                "frames of sampled recordings.",
                "Nothing to do if only every n-th frame is annotated; else check the frame list.",
                has_cases=False,
            )
        )
    return findings


def _advice(subject: str, frame: np.ndarray, first: np.ndarray, last: np.ndarray) -> str:
    outside = np.minimum(frame - first, 0) + np.maximum(frame - last, 0)
    if np.all(outside == -1):
        return (
            "They stand just before the first evaluated frame: the file may count frames from 0 "
            "where the ground truth counts from 1. Correct the frame base, or set offset_frames."
        )
    if np.all(outside == 1):
        return (
            "They stand just after the last evaluated frame: the file may count frames from 1 "
            "where the ground truth counts from 0. Correct the frame base, or set offset_frames."
        )
    advice = (
        "Check the frame list (--frames) and that the file counts frames as the ground truth does."
    )
    if subject != TRUTH_NAME:
        advice += (
            " If nobody was there in these frames and that was checked, list them with --frames: "
            "these detections then count as false alarms."
        )
    return advice


def _listed_ranges(
    dataset: Dataset, names: pd.Series[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """First and last listed frame of each row's recording, and whether that is sampled."""
    frames = dataset.frame_columns
    assert len(frames), "rows are only left out of recordings that have frames"
    start, stop = frames.first[:-1], frames.first[1:] - 1
    first, last = frames.frame[start], frames.frame[stop]
    is_sampled = last - first > stop - start
    code = pd.Index(dataset.recordings["name"]).get_indexer(pd.Index(names))
    return first[code], last[code], is_sampled[code]


def _nothing_left(dataset: Dataset, subject: str) -> bool:
    if subject == TRUTH_NAME:
        return not len(dataset.truth)
    return subject in dataset.systems and not len(dataset.system(subject))


def _finding(
    dataset: Dataset,
    severity: Severity,
    code: str,
    subject: str,
    rows: pd.DataFrame,
    message: str,
    advice: str,
    *,
    has_cases: bool = True,
) -> Finding:
    first = rows.iloc[0]
    file, line = int(first["file"]), int(first["line"])
    name = file_name(dataset, file, line)
    n_files = rows["file"].nunique()
    if n_files > 1:
        message += f" They stand in {n_files} files."
    return Finding(
        severity=severity,
        code=code,
        subject=subject,
        count=len(rows),
        message=message,
        advice=advice,
        file=name,
        example=place(first["recording"], int(first["frame"]), line=line, file=name),
        # usual rows may be most of the input: nobody looks them up one by one
        cases=Cases("left_out", rows.index.to_numpy()) if has_cases else None,
    )
