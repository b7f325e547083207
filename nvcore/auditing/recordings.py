"""Findings on image sizes, frame rates and frame lists that do not fit the boxes."""

from __future__ import annotations

from itertools import pairwise
from typing import Final

import numpy as np

from nvcore.auditing.cases import all_sources, recording_findings
from nvcore.auditing.transform_search import SIZES
from nvcore.common.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.dataset import Dataset
from nvcore.inputs.session.proposals import KITTI_SIZES

MIN_BOXES: Final = 200
"""Fewest boxes that should reach most of the picture."""
REACHED_SHARE: Final = 0.6
"""Share of width and height below which boxes seem to belong to a smaller picture."""
EDGE_SLACK: Final = 1.03
"""Largest factor by which boxes at the edge reach beyond the picture."""
KITTI_SLACK_PX: Final = 1.5
"""Largest difference of right edges that count as equal."""
MIN_AT_EDGE: Final = 5
"""Fewest boxes ending at a position that is taken for the edge of the picture."""
FPS_RANGE: Final = (0.1, 240.0)
"""Plausible frame rates. Others are mistakes."""
MIN_STEPS: Final = 10
"""Fewest steps between frames whose evenness is no chance."""
LIKE_TIMES: Final = "frame-numbers-like-times"
SAME_PERIOD: Final = 0.03
"""Largest relative difference between a step and the time from frame to frame."""
LEAST_STEP: Final = 10
"""Least usual step for which numbers may be times: milliseconds at 100 Hz."""
STEP_JITTER: Final = 0.1
"""Largest relative difference between a step and the usual one that counts as near ..."""
NEAR_SHARE: Final = 0.9
"""... which must apply to this share of the steps."""
MIN_EMPTY: Final = 20
"""Fewest listed frames without any box, at the beginning or end, that are worth a look ..."""
EMPTY_SHARE: Final = 0.25
"""... if they are also this share of the recording."""


def audit_size(dataset: Dataset) -> list[Finding]:
    """Report a picture size that is far larger than the extent of all boxes.

    Boxes of the truth and of all systems count. Recordings of the same size are checked together,
    so that a recording whose people keep to one corner is not reported.
    """
    frames = dataset.frame_columns
    sizes, size_of = np.unique(
        np.column_stack([frames.width, frames.height]), axis=0, return_inverse=True
    )
    n_boxes, reach = np.zeros(len(sizes), np.int64), np.zeros((len(sizes), 2))
    for source in all_sources(dataset):
        boxes = source.boxes
        for rows, recordings in source.blocks():
            starts = source.starts[recordings.start : recordings.stop + 1]
            has_box = starts[1:] > starts[:-1]
            group, first = size_of.reshape(-1)[recordings][has_box], starts[:-1][has_box]
            np.add.at(n_boxes, group, np.diff(starts)[has_box])
            right, bottom = boxes.x[rows] + boxes.w[rows], boxes.y[rows] + boxes.h[rows]
            for axis, ends in enumerate((right, bottom)):
                furthest = np.maximum.reduceat(ends, first - rows.start)  # no segment is empty
                np.maximum.at(reach[:, axis], group, furthest)
    # coordinates in fractions of the picture have a separate finding
    is_odd = (n_boxes >= MIN_BOXES) & (reach <= REACHED_SHARE * sizes).all(axis=1)
    is_odd &= reach.max(axis=1) > 2
    findings = []
    for i in np.flatnonzero(is_odd):  # a loop over the few different sizes
        (right_most, lowest), (W, H) = reach[i], sizes[i]
        names = dataset.recordings["name"][size_of.reshape(-1) == i]
        findings.append(
            Finding(
                severity=Severity.WARNING,
                code="size-too-large",
                subject=TRUTH_NAME,
                count=int(n_boxes[i]),
                message=(
                    f"No box reaches beyond x = {right_most:.0f} of {W:g} and y = {lowest:.0f} of "
                    f"{H:g}."
                ),
                advice=(
                    f"Check the image size{_fitting(reach[i], sizes[i])}: lateral position and "
                    "proximity depend on it."
                ),
                steps=(Step(Remedy.SIZE),),
                example=f"recording {names.iloc[0]}",
            )
        )
    return findings


def audit_kitti_size(dataset: Dataset) -> list[Finding]:
    """Report recordings of KITTI whose given size differs from that at which boxes end.

    KITTI's files hold no size, its recordings differ in size, and boxes of the truth are cut off at
    the right edge of the picture.
    """
    inputs = dataset.inputs
    formats = inputs["format"][inputs["subject"] == TRUTH_NAME] if "format" in inputs else ()
    if not any(str(name).startswith("kitti") for name in formats):
        return []
    recordings, truth = dataset.recordings, dataset.truth
    recording = dataset.frame_columns.recording[truth.frame_index]
    own = kitti_sizes(recording, truth.x + truth.w, len(recordings))
    given = recordings[["width", "height"]].to_numpy(dtype=float)
    odd = np.flatnonzero((own[:, 0] > 0) & (np.abs(given - own)[:, 0] > KITTI_SLACK_PX))
    if not len(odd):
        return []
    (W, H), (width, height) = given[odd[0]], own[odd[0]]
    return recording_findings(
        dataset,
        Severity.WARNING,
        "kitti-size",
        TRUTH_NAME,
        odd,
        f"a picture size that the truth contradicts (first: given {W:g}x{H:g}, its boxes end at "
        f"the edge of {width:g}x{height:g})",
        "Recordings of KITTI differ in size: look at the pictures, and give one size for all or "
        "one for each recording.",
        steps=(Step(Remedy.SIZE), Step(Remedy.OPTION, "", "recordings")),
    )


def kitti_sizes(recording: np.ndarray, right: np.ndarray, n_recordings: int) -> np.ndarray:
    """Return the KITTI picture size at whose right edge each recording's boxes end, px, 0 unknown.

    Parameters
    ----------
    recording, right
        Number of the recording and right edge (px) of each box, shape (n,).

    Returns
    -------
    float64, shape (n_recordings, 2): width and height.
    """
    own = np.zeros((n_recordings, 2))
    for row in range(n_recordings):  # a loop over recordings: at most hundreds
        rights = right[recording == row]
        reach = rights.max(initial=0.0)
        if np.count_nonzero(rights >= reach - KITTI_SLACK_PX) >= MIN_AT_EDGE:
            near = (size for size in KITTI_SIZES if abs(reach - size[0]) <= KITTI_SLACK_PX)
            own[row] = next(near, (0, 0))
    return own


def _fitting(reach: np.ndarray, size: np.ndarray) -> str:
    """Return a likely size that holds all boxes, as text, or "" if there is none."""
    right, bottom = reach / EDGE_SLACK
    # sizes that are wrong by a factor keep their aspect ratio, so try those first
    parts = [(int(size[0] // n), int(size[1] // n)) for n in (4, 3, 2)]
    usual = sorted(SIZES, key=lambda usual_size: usual_size[0] * usual_size[1])
    for width, height in (*parts, *usual):  # a loop over a few sizes
        if width >= right and height >= bottom:
            return f"; the boxes would fit {width}x{height}, for example"
    return ""


def audit_fps(dataset: Dataset) -> list[Finding]:
    """Report frame rates that no camera has."""
    fps = dataset.frame_columns.fps
    odd = np.flatnonzero((fps < FPS_RANGE[0]) | (fps > FPS_RANGE[1]))
    if not len(odd):
        return []
    return recording_findings(
        dataset,
        Severity.WARNING,
        "implausible-fps",
        TRUTH_NAME,
        odd,
        f"an implausible frame rate (first: {fps[odd[0]]:g} frames per second)",
        "Check the frame rate, which counts all frames of the camera, annotated or not: every time "
        "and every rate per hour depends on it.",
        steps=(Step(Remedy.RATE),),
    )


def audit_frame_steps(dataset: Dataset) -> list[Finding]:
    """Report frame numbers that rise like times.

    They rise in almost even steps (0, 33, 67, 100). It is an error if the steps equal the time
    between two frames in milliseconds, microseconds or nanoseconds. Both the listed frames and the
    frames with pedestrians are checked, as the list may have been made from the latter.
    """
    frames = dataset.frame_columns
    fps = dataset.recordings["fps"].to_numpy()
    has_box = np.diff(dataset.truth.offsets) > 0
    odd, steps_of, is_period = [], "", False
    for number, (start, stop) in enumerate(pairwise(frames.first)):  # a loop over recordings
        listed = frames.frame[start:stop]
        for numbers in (listed, listed[has_box[start:stop]]):
            steps = np.diff(numbers)
            if len(steps) < MIN_STEPS:
                continue
            usual = float(np.median(steps))
            is_near = np.abs(steps - usual) <= max(1.0, STEP_JITTER * usual)
            is_same = any(
                abs(usual * fps[number] / unit - 1) < SAME_PERIOD for unit in (1e3, 1e6, 1e9)
            )
            is_rising = usual >= LEAST_STEP and is_near.mean() >= NEAR_SHARE
            # gaps of whole steps are no jitter
            if is_rising and (is_same or np.ptp(steps[is_near]) > 0):
                steps_of = steps_of or ", ".join(map(str, numbers[:4]))
                odd.append(number)
                is_period |= is_same
                break
    if not odd:
        return []
    how = "in the steps of milliseconds at this frame rate" if is_period else "in nearly even steps"
    accept = (Step(Remedy.ACCEPT, LIKE_TIMES),) if is_period else ()
    return recording_findings(
        dataset,
        Severity.ERROR if is_period else Severity.WARNING,
        LIKE_TIMES,
        TRUTH_NAME,
        np.array(odd),
        f"frame numbers that rise {how} (first: {steps_of}), as times do",
        "If they are times, every length in seconds is wrong by the step: say that they are.",
        steps=(Step(Remedy.FRAME_NAMES, "times"), *accept),
    )


def audit_frame_list(dataset: Dataset) -> list[Finding]:
    """Report frames before the first or after the last box of truth and all systems."""
    frames = dataset.frame_columns
    start, stop = frames.first[:-1], frames.first[1:]
    boxed_frames = np.flatnonzero(sum(np.diff(source.offsets) for source in dataset.sources))
    lo, hi = np.searchsorted(boxed_frames, start), np.searchsorted(boxed_frames, stop)
    # recordings without any box have a separate finding
    annotated = np.flatnonzero(hi > lo)
    first, last = boxed_frames[lo[annotated]], boxed_frames[hi[annotated] - 1]
    least = np.maximum(MIN_EMPTY, EMPTY_SHARE * (stop - start)[annotated])
    n_before, n_after = first - start[annotated], stop[annotated] - 1 - last
    is_before, is_after = n_before >= least, n_after >= least
    odd = np.flatnonzero(is_before | is_after)
    if not len(odd):
        return []
    example, recording = odd[0], annotated[odd[0]]
    ends = ("before", first, is_before), ("after", last, is_after)
    where = [
        f"{word} frame {frames.frame[row[example]]}" for word, row, has in ends if has[example]
    ]
    empty_rows, say = np.where(is_before, start[annotated], last + 1)[odd], dataset.objects.say
    return recording_findings(
        dataset,
        Severity.WARNING,
        "frames-beyond-boxes",
        TRUTH_NAME,
        annotated[odd],
        f"no box of {say('{anybody}')} in a long part at the beginning or end (first: none "
        f"{' and none '.join(where)} of {frames.frame[start[recording]]} to "
        f"{frames.frame[stop[recording] - 1]})",
        say(
            "Check the list of evaluated frames: those without {anybody} count as perfect, and as "
            "recording time. Nothing to do if {nobody} was there."
        ),
        frame_index=int(empty_rows[0]),
        frame_rows=empty_rows,
        steps=(Step(Remedy.FRAMES),),
    )
