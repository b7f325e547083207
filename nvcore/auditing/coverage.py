"""Findings on frames and recordings without truth or detections that probably should have some."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.auditing.cases import BoxSource, recording_findings
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.dataset import Dataset
from nvcore.dataset.columns import BoxColumns
from nvcore.inputs.evaluated_frames import nth

PART_CODE: Final = "detections-in-part-of-recording"
MIN_REGULAR: Final = 10
"""Fewest frames with boxes for which a regular step between them is no chance."""
MIN_SILENT: Final = 20
"""Fewest listed frames of silence at the beginning or end that are worth a look ..."""
SILENT_SHARE: Final = 0.1
"""... if they are also this share of the recording."""
BUSY_SHARE: Final = 0.5
"""Least share of frames with detections of a system for which silence is unusual."""


def audit_truth_coverage(dataset: Dataset) -> list[Finding]:
    """Report missing pedestrians, recordings without any, and annotation sparser than frames."""
    truth, frames, objects = dataset.truth, dataset.frame_columns, dataset.objects
    counts = ~truth.ignore
    if not counts.any():
        why = f": all {len(truth):,} boxes are ignore regions" if len(truth) else ""
        return [
            Finding(
                severity=Severity.ERROR,
                code="no-pedestrian",
                subject=TRUTH_NAME,
                count=len(truth),
                message=f"There is no {objects.singular} in the ground truth{why}.",
                advice=objects.say(
                    "Check which classes count as {many} and that this is the ground truth: "
                    "without {many} nothing can be missed."
                ),
                steps=(Step(Remedy.CLASSES, "", TRUTH_NAME),),
            )
        ]
    has_truth = frames_with(truth, counts)
    # a frame with only an ignore region has been annotated, too
    steps = regular_steps(frames_with(truth), frames.first)
    return [
        *_about_recordings(
            dataset,
            Severity.NOTE,
            "recording-without-pedestrians",
            TRUTH_NAME,
            np.flatnonzero(~_any_per_recording(has_truth, frames.first)),
            f"no {objects.singular}",
            objects.say(
                "Nothing to do if {nobody} is there: every detection in them is a false alarm. "
                "Else add the annotation, or leave the recordings out."
            ),
        ),
        *_about_recordings(
            dataset,
            Severity.WARNING,
            "truth-every-nth-frame",
            TRUTH_NAME,
            np.flatnonzero(steps > 1),
            f"ground truth in every {_first_step(steps, steps > 1)} evaluated frame only",
            "If only those frames were annotated, evaluate no others: in these every detection "
            "counts as a false alarm.",
            (Step(Remedy.FRAMES),),
        ),
    ]


def audit_system_coverage(source: BoxSource) -> list[Finding]:
    """Report recordings and frames without detections of a system although there is truth."""
    dataset, frames = source.dataset, source.dataset.frame_columns
    truth, objects = dataset.truth, dataset.objects
    has_truth, has_box = frames_with(truth, ~truth.ignore), frames_with(source.boxes)
    truth_in = _any_per_recording(has_truth, frames.first)
    box_in = _any_per_recording(has_box, frames.first)
    if not len(source.boxes):
        return [
            Finding(
                severity=Severity.ERROR,
                code="no-detections",
                subject=source.name,
                count=len(box_in),
                message="There is no detection in any evaluated frame: nothing can be compared.",
                advice="Check its files, and that they count frames as the ground truth does.",
                steps=(Step(Remedy.ACCEPT, "no-detections"),),
            )
        ]
    steps = regular_steps(has_box, frames.first)
    is_sparse = (steps > 1) & (steps != regular_steps(has_truth, frames.first))
    return [
        *_about_recordings(
            dataset,
            Severity.WARNING,
            "recording-without-detections",
            source.name,
            np.flatnonzero(truth_in & ~box_in),
            f"{objects.plural} and no detection",
            "If a file is missing, add it; if the system found nothing there, this is right.",
        ),
        *_about_recordings(
            dataset,
            Severity.WARNING,
            "detections-every-nth-frame",
            source.name,
            np.flatnonzero(is_sparse),
            f"detections in every {_first_step(steps, is_sparse)} evaluated frame only",
            objects.say(
                "If the system ran on those frames only, evaluate both systems on them: in all "
                "others it misses {everybody}."
            ),
            (Step(Remedy.FRAMES),),
        ),
        *_silent_ends(source, has_box),
    ]


def _silent_ends(source: BoxSource, has_box: np.ndarray) -> list[Finding]:
    """Report long silence before the first or after the last detection of a recording.

    Only pedestrians as tall as the system's usual detection count, because others may just be too
    far away.
    """
    dataset, frames, boxes = source.dataset, source.dataset.frame_columns, source.boxes
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
        usual = np.median(boxes.h[boxes.rows_of(start[r], stop[r])])
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
    return _about_recordings(
        dataset,
        Severity.WARNING,
        PART_CODE,
        source.name,
        odd,
        f"detections in a part only (first: frames {number[lo[first]]} to "
        f"{number[hi[first] - 1]} of {number[start[first]]} to {number[stop[first] - 1]}), "
        f"although there are near {dataset.objects.plural} in the rest",
        dataset.objects.say(
            "If the system ran on that part only, evaluate both systems on it: in the rest it "
            "misses {everybody}."
        ),
        (Step(Remedy.FRAMES),),
    )


def frames_with(boxes: BoxColumns, is_member: np.ndarray | None = None) -> np.ndarray:
    """Return whether each frame has a box, or one that is a member, bool, shape (n_frames,)."""
    if is_member is None or is_member.all():
        has: np.ndarray = np.diff(boxes.offsets) > 0
    else:
        has = np.zeros(len(boxes.offsets) - 1, np.bool_)
        has[boxes.frame_index[is_member]] = True
    return has


def regular_steps(has: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Return n for each recording if only every n-th listed frame is true, else 1.

    It is also 1 if there are too few such frames.

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
    # ignore the gap between two recordings, which must not change the divisor
    gaps[lo[1:][(lo[1:] > 0) & (lo[1:] < len(boxed_frames))] - 1] = 0
    edges = np.column_stack([lo[enough], hi[enough]]).ravel()
    steps[enough] = np.gcd.reduceat(np.append(gaps, [0, 0]), edges)[::2]
    return steps


def _any_per_recording(has: np.ndarray, first: np.ndarray) -> np.ndarray:
    total = np.concatenate([[0], np.cumsum(has)])
    some: np.ndarray = total[first[1:]] > total[first[:-1]]
    return some


def _first_step(steps: np.ndarray, is_sparse: np.ndarray) -> str:
    """Return the step of the first sparse recording as an ordinal."""
    return nth(steps[np.argmax(is_sparse)])


def _about_recordings(
    dataset: Dataset,
    severity: Severity,
    code: str,
    subject: str,
    recordings: np.ndarray,
    what: str,
    advice: str,
    steps: tuple[Step, ...] = (),
) -> list[Finding]:
    """Call `recording_findings` with the first frame, if there is one, as example."""
    first_frames = dataset.frame_columns.first
    frame_index = None
    if len(recordings) and first_frames[recordings[0]] < first_frames[recordings[0] + 1]:
        frame_index = int(first_frames[recordings[0]])
    return recording_findings(
        *(dataset, severity, code, subject, recordings, what, advice),
        frame_index=frame_index,
        steps=steps,
    )
