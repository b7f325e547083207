"""Findings on rows of the inputs that could not be used: the reason, and its severity."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.auditing.cases import file_name, place, spelled, without_doubles
from nvcore.common.findings import TRUTH_NAME, Cases, Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.dataset.provenance import is_in_ranges
from nvcore.inputs.session import Session
from nvcore.settings.objects import Objects

HARDLY: Final = 0.1
"""Share of a system's rows, and of the frames with pedestrians, below which hardly any is left."""


def audit_left_out(dataset: Dataset) -> list[Finding]:
    """Return the findings on `Dataset.left_out`, one by subject and kind.

    A system that ran on every frame of a sampled recording is not at fault, so its rows between
    listed frames only give a note.
    """
    lost = dataset.left_out.reset_index(drop=True)
    lost = lost[lost["subject"].isin([TRUTH_NAME, *dataset.systems])]
    findings: list[Finding] = []
    for subject, group in lost.groupby("subject", sort=False):
        name = str(subject)
        for reason, rows in group.groupby("reason", sort=False):
            if reason == "frame not listed":
                findings += _not_listed(dataset, name, rows)
            elif reason == "unknown recording":
                findings += _unknown_recording(dataset, name, rows)
            else:
                findings += _no_box(dataset, name, str(reason), rows)
    return findings


def _no_box(dataset: Dataset, subject: str, reason: str, rows: pd.DataFrame) -> list[Finding]:
    what = count_text(len(rows), "row is left out", "rows are left out")
    box = rows[[*"xywh"]].to_numpy(float)
    if np.all(np.isnan(box) if reason == "not a number" else box == 0):
        return _finding(
            dataset,
            Severity.WARNING if subject == TRUTH_NAME else Severity.NOTE,
            "empty-box",
            subject,
            rows,
            f"{what}: none of the numbers of a box is there.",
            "Nothing to do if they say that nothing is in these frames.",
        )
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


def _unknown_recording(dataset: Dataset, subject: str, rows: pd.DataFrame) -> list[Finding]:
    names = without_doubles(rows["recording"])
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
        f"The recordings are {spelled(dataset.recordings['name'])}: rename the files to match, or "
        "add the ground truth.",
    )


def _not_listed(dataset: Dataset, subject: str, rows: pd.DataFrame) -> list[Finding]:
    first, last, is_sampled = listed_ranges(dataset, rows["recording"])
    frame = rows["frame"].to_numpy()
    is_usual = (first < frame) & (frame < last) & is_sampled & (subject != TRUTH_NAME)
    nothing = _nothing_left(dataset, subject)
    is_wanted = ~is_usual & (not nothing) & _left_out_by_choice(dataset, subject, rows)
    is_odd = ~is_usual & ~is_wanted
    odd, chosen, between = (rows[is_one] for is_one in (is_odd, is_wanted, is_usual))
    message = (
        f"{count_text(len(odd), 'row is', 'rows are')} left out, in "
        f"{count_text(odd['frame'].nunique(), 'frame number')} not evaluated."
    )
    hardly = not nothing and _hardly_anything_left(dataset, subject, len(odd))
    if nothing or hardly:
        message += f" {'Hardly anything' if hardly else 'Nothing'} is left to compare."
    return [
        *_finding(
            dataset,
            Severity.ERROR if nothing or hardly else Severity.WARNING,
            "frame-not-listed",
            subject,
            odd,
            message,
            *_advice(dataset.objects, subject, frame[is_odd], first[is_odd], last[is_odd]),
        ),
        *_finding(
            dataset,
            Severity.NOTE,
            "left-out-by-choice",
            subject,
            chosen,
            f"{count_text(len(chosen), 'row is', 'rows are')} left out, in frames that are not "
            "among those given.",
            "Nothing to do if these frames were left out on purpose.",
            has_cases=False,
        ),
        *_finding(
            dataset,
            Severity.NOTE,
            "between-sampled-frames",
            subject,
            between,
            f"{count_text(len(between), 'row is', 'rows are')} left out, between the annotated "
            "frames of sampled recordings.",
            "Nothing to do if only every n-th frame is annotated; else check the frame list.",
            has_cases=False,
        ),
    ]


def _left_out_by_choice(dataset: Dataset, subject: str, rows: pd.DataFrame) -> np.ndarray:
    """Return which rows are in frames that exist but were not selected, bool, shape (n,).

    A frame is known to exist from the truth or from the record of the detector's run.
    """
    settings, is_wanted = dataset.settings, np.zeros(len(rows), dtype=bool)
    if not isinstance(settings, Session):
        return is_wanted
    names = dataset.recordings["name"].tolist()
    entries, number_of = settings.entries(names), {name: i for i, name in enumerate(names)}
    record, frame = dataset.provenance.get(subject), rows["frame"].to_numpy()
    for name, places in rows.groupby("recording", sort=False).indices.items():
        entry = entries.get(str(name))
        if settings.frames is None and (entry is None or entry.frames is None):
            continue
        is_wanted[places] = _is_of_truth(dataset, number_of[str(name)], frame[places])
        if record is not None:
            is_wanted[places] |= is_in_ranges(frame[places], record.frames.get(str(name), ()))
    return is_wanted


def _is_of_truth(dataset: Dataset, number: int, frame: np.ndarray) -> np.ndarray:
    """Return which frames lie between the first and last truth box, evaluated or not, (n,).

    None do if the evaluated frames begin and end one frame off the truth, as if counted
    differently.
    """
    rows = dataset.frame_columns.rows_of(number)
    listed = dataset.frame_columns.frame[rows]
    boxes = dataset.truth.of_frames(rows.start, rows.stop)
    of_truth = dataset.unlisted_frames(str(dataset.recordings["name"].iloc[number]))
    of_truth = np.concatenate([of_truth, dataset.frame_columns.frame[boxes.frame_index]])
    if not len(of_truth):
        return np.zeros(len(frame), dtype=bool)
    low, high = of_truth.min(), of_truth.max()
    is_shifted = abs(listed[0] - low) == 1 and listed[0] - low == listed[-1] - high
    is_within: np.ndarray = (low <= frame) & (frame <= high) & (not is_shifted)
    return is_within


def _advice(
    objects: Objects, subject: str, frame: np.ndarray, first: np.ndarray, last: np.ndarray
) -> tuple[str, tuple[Step, ...]]:
    outside = np.minimum(frame - first, 0) + np.maximum(frame - last, 0)
    if np.all(outside == -1):
        return (
            "They stand just before the first evaluated frame: the file may count frames from 0 "
            "where the ground truth counts from 1. Correct the frame base, or set offset_frames."
        ), ()
    if np.all(outside == 1):
        return (
            "They stand just after the last evaluated frame: the file may count frames from 1 "
            "where the ground truth counts from 0. Correct the frame base, or set offset_frames."
        ), ()
    advice = (
        "Check the list of evaluated frames, and that the file counts frames as the ground truth "
        "does."
    )
    if subject != TRUTH_NAME:
        advice += objects.say(
            " If {nobody} was there in these frames and that was checked, list them, too: these "
            "detections then count as false alarms."
        )
    return advice, (Step(Remedy.FRAMES),)


def listed_ranges(
    dataset: Dataset, names: pd.Series[str]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return first and last listed frame of each row's recording, and whether it is sampled."""
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


def _hardly_anything_left(dataset: Dataset, subject: str, n_lost: int) -> bool:
    """Whether a system keeps less than a tenth of its rows and of the frames with pedestrians."""
    if subject not in dataset.systems:
        return False
    system = dataset.system(subject)
    has_truth, has_own = (np.diff(boxes.offsets) > 0 for boxes in (dataset.truth, system))
    are_few = np.count_nonzero(has_truth & has_own) < HARDLY * np.count_nonzero(has_truth)
    return bool(are_few and len(system) < HARDLY * (len(system) + n_lost))


def _finding(
    dataset: Dataset,
    severity: Severity,
    code: str,
    subject: str,
    rows: pd.DataFrame,
    message: str,
    advice: str,
    steps: tuple[Step, ...] = (),
    *,
    has_cases: bool = True,
) -> list[Finding]:
    """Return a finding about rows with the first as example, or none without rows."""
    if rows.empty:
        return []
    first = rows.iloc[0]
    file, line = int(first["file"]), int(first["line"])
    name = file_name(dataset, file, line)
    n_files = rows["file"].nunique()
    if n_files > 1:
        message += f" They stand in {n_files} files."
    return [
        Finding(
            severity=severity,
            code=code,
            subject=subject,
            count=len(rows),
            message=message,
            advice=advice,
            steps=steps,
            file=name,
            example=place(first["recording"], int(first["frame"]), line=line, file=name),
            # rows between listed frames may be most of the input, and nobody looks at each of them
            cases=Cases("left_out", rows.index.to_numpy()) if has_cases else None,
        )
    ]
