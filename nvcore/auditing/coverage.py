"""Frames and recordings in which the truth or a system says nothing, and probably should."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.auditing.cases import (
    TRUTH_NAME,
    Audited,
    counted,
    place_of_frame,
    spelled,
)
from nvcore.dataset import Dataset, offsets_of
from nvcore.findings import Finding, Severity
from nvcore.inputs.evaluated_frames import nth

MIN_REGULAR: Final = 10
"""Frames with boxes from which on a regular step between them is no chance."""
MIN_SILENT: Final = 20
"""Listed frames of silence at the beginning or end that are worth a look ..."""
SILENT_SHARE: Final = 0.1
"""... if they are this share of the recording, too."""
BUSY_SHARE: Final = 0.5
"""A system that detects something in fewer of its frames is silent at times anyway."""


def audit_truth_coverage(dataset: Dataset) -> list[Finding]:
    """No pedestrian at all, recordings without one, annotation sparser than the frame list."""
    truth, frames = dataset.truth, dataset.frame_columns
    counts = ~truth.ignore
    if not counts.any():
        message = "There is no pedestrian in the ground truth."
        if len(truth):
            message = (
                f"There is no pedestrian in the ground truth: all {len(truth):,} boxes are ignore "
                "regions."
            )
        return [
            Finding(
                severity=Severity.ERROR,
                code="no-pedestrian",
                subject=TRUTH_NAME,
                count=len(truth),
                message=message,
                advice=(
                    "Check which classes count as pedestrians (--classes) and that this is the "
                    "ground truth: without pedestrians nothing can be missed."
                ),
            )
        ]
    findings = []
    has_truth = frames_with(truth.frame_index[counts], dataset)
    without = np.flatnonzero(~_any_per_recording(has_truth, frames.first))
    if len(without):
        findings.append(
            _about_recordings(
                dataset,
                severity=Severity.NOTE,
                code="recording-without-pedestrians",
                subject=TRUTH_NAME,
                recordings=without,
                what="no pedestrian",
                advice=(
                    "Nothing to do if nobody is there: every detection in them is a false alarm. "
                    "Else add the annotation, or leave the recordings out."
                ),
            )
        )
    # a frame with an ignore region only has been annotated, too
    steps = regular_steps(frames_with(truth.frame_index, dataset), frames.first)
    sparse = np.flatnonzero(steps > 1)
    if len(sparse):
        findings.append(
            _about_recordings(
                dataset,
                severity=Severity.WARNING,
                code="truth-every-nth-frame",
                subject=TRUTH_NAME,
                recordings=sparse,
                what=f"ground truth in every {nth(steps[sparse[0]])} evaluated frame only",
                advice=(
                    "If only those frames were annotated, give the frame list (--frames "
                    "first:last:step): in all others every detection counts as a false alarm."
                ),
            )
        )
    return findings


def audit_system_coverage(audited: Audited) -> list[Finding]:
    """Recordings and frames without detections of a system although there is truth."""
    dataset, frames = audited.dataset, audited.dataset.frame_columns
    truth = dataset.truth
    has_truth = frames_with(truth.frame_index[~truth.ignore], dataset)
    has_box = frames_with(audited.boxes.frame_index, dataset)
    truth_in = _any_per_recording(has_truth, frames.first)
    box_in = _any_per_recording(has_box, frames.first)
    if not len(audited.boxes):
        return [
            Finding(
                severity=Severity.ERROR,
                code="no-detections",
                subject=audited.name,
                count=len(box_in),
                message="There is no detection in any evaluated frame: nothing can be compared.",
                advice="Check its files, and that they count frames as the ground truth does.",
            )
        ]
    findings = []
    silent = np.flatnonzero(truth_in & ~box_in)
    if len(silent):
        findings.append(
            _about_recordings(
                dataset,
                severity=Severity.WARNING,
                code="recording-without-detections",
                subject=audited.name,
                recordings=silent,
                what="pedestrians and no detection",
                advice=(
                    "If a file is missing, add it; if the system found nothing there, this is "
                    "right."
                ),
            )
        )
    steps = regular_steps(has_box, frames.first)
    truth_steps = regular_steps(has_truth, frames.first)
    sparse = np.flatnonzero((steps > 1) & (truth_steps != steps))
    if len(sparse):
        findings.append(
            _about_recordings(
                dataset,
                severity=Severity.WARNING,
                code="detections-every-nth-frame",
                subject=audited.name,
                recordings=sparse,
                what=f"detections in every {nth(steps[sparse[0]])} evaluated frame only",
                advice=(
                    "If the system ran on those frames only, evaluate both systems on them "
                    "(--frames first:last:step): in all others it misses everybody."
                ),
            )
        )
    return findings + _silent_ends(audited, has_box)


def _silent_ends(audited: Audited, has_box: np.ndarray) -> list[Finding]:
    """Long silence before the first or after the last detection of a recording.

    Pedestrians that are merely too far away do not count: only those as tall as the system's
    usual detection.
    """
    dataset, frames, boxes = audited.dataset, audited.dataset.frame_columns, audited.boxes
    start, stop = frames.first[:-1], frames.first[1:]
    boxed_frames = np.flatnonzero(has_box)
    n_before, n_until = np.searchsorted(boxed_frames, start), np.searchsorted(boxed_frames, stop)
    has_any = n_until > n_before
    lo = np.where(has_any, boxed_frames[np.minimum(n_before, len(boxed_frames) - 1)], start)
    hi = np.where(has_any, boxed_frames[np.maximum(n_until, 1) - 1] + 1, stop)
    is_busy = has_any & (n_until - n_before >= BUSY_SHARE * (hi - lo))
    least = np.maximum(MIN_SILENT, SILENT_SHARE * (stop - start))
    candidates = np.flatnonzero(is_busy & ((lo - start >= least) | (stop - hi >= least)))
    truth = dataset.truth
    partial = []
    for r in candidates:  # a loop over the few recordings with a silent end
        usual = np.median(boxes.h[boxes.offsets[start[r]] : boxes.offsets[stop[r]]])
        rows = np.arange(truth.offsets[start[r]], truth.offsets[stop[r]])
        tall = np.unique(truth.frame_index[rows[~truth.ignore[rows] & (truth.h[rows] >= usual)]])
        n_tall = np.searchsorted(tall, lo[r]), len(tall) - np.searchsorted(tall, hi[r])
        n_silent = lo[r] - start[r], stop[r] - hi[r]
        if any(
            silent >= least[r] and n >= MIN_SILENT // 2
            for silent, n in zip(n_silent, n_tall, strict=True)
        ):
            partial.append(r)
    if not partial:
        return []
    odd = np.array(partial)
    number = frames.frame
    first = odd[0]
    return [
        _about_recordings(
            dataset,
            severity=Severity.WARNING,
            code="detections-in-part-of-recording",
            subject=audited.name,
            recordings=odd,
            what=(
                f"detections in a part only (first: frames {number[lo[first]]} to "
                f"{number[hi[first] - 1]} of {number[start[first]]} to {number[stop[first] - 1]}), "
                "although there are near pedestrians in the rest"
            ),
            advice=(
                "If the system ran on that part only, evaluate both systems on it (--frames "
                "first:last): in the rest it misses everybody."
            ),
        )
    ]


def frames_with(frame_index: np.ndarray, dataset: Dataset) -> np.ndarray:
    """Whether each frame has one of the boxes; bool, shape (n_frames,)."""
    has: np.ndarray = np.diff(offsets_of(frame_index, len(dataset.frames))) > 0
    return has


def regular_steps(has: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Per recording n, if only every n-th listed frame is true; 1 where irregular or too few.

    Parameters
    ----------
    has
        bool, shape (n_frames,).
    first
        First frame of each recording, shape (n_recordings + 1,).
    """
    steps = np.ones(len(first) - 1, np.int64)
    boxed_frames = np.flatnonzero(has)
    lo, hi = np.searchsorted(boxed_frames, first[:-1]), np.searchsorted(boxed_frames, first[1:])
    enough = hi - lo >= MIN_REGULAR
    if not enough.any():
        return steps
    gaps = np.diff(boxed_frames)
    # the gap between two recordings says nothing: it must not change the divisor
    gaps[lo[1:][(lo[1:] > 0) & (lo[1:] < len(boxed_frames))] - 1] = 0
    edges = np.column_stack([lo[enough], hi[enough]]).ravel()
    steps[enough] = np.gcd.reduceat(np.append(gaps, [0, 0]), edges)[::2]
    return steps


def _any_per_recording(has: np.ndarray, first: np.ndarray) -> np.ndarray:
    total = np.concatenate([[0], np.cumsum(has)])
    some: np.ndarray = total[first[1:]] > total[first[:-1]]
    return some


def _about_recordings(
    dataset: Dataset,
    severity: Severity,
    code: str,
    subject: str,
    recordings: np.ndarray,
    what: str,
    advice: str,
) -> Finding:
    names = dataset.recordings["name"].iloc[recordings]
    frame_index = int(dataset.frame_columns.first[recordings[0]])
    is_empty = frame_index == dataset.frame_columns.first[recordings[0] + 1]
    return Finding(
        severity=severity,
        code=code,
        subject=subject,
        count=len(recordings),
        message=(
            f"{counted(len(recordings), 'recording has', 'recordings have')} {what}: "
            f"{spelled(names)}."
        ),
        advice=advice,
        example=f"recording {names.iloc[0]}" if is_empty else place_of_frame(dataset, frame_index),
    )
