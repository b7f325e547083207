"""Systems that match not a single pedestrian: what was tried, and what each would give."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from nvcore.auditing.cases import BoxSource
from nvcore.auditing.coverage import frames_with
from nvcore.auditing.layouts import FIT_IOU, find_layouts
from nvcore.auditing.overlaps import MAX_SHIFT, Correction, Sample, take_sample
from nvcore.auditing.scales import scale_candidates
from nvcore.columns import BoxColumns
from nvcore.dataset import Dataset
from nvcore.dataset.sources import left_out_text
from nvcore.findings import TRUTH_NAME, Finding, Remedy, Severity, Step
from nvcore.metrics.matching import Matches
from nvcore.wording import count_text

CODE: Final = "no-match"
MIN_BOXES: Final = 5
"""Fewer pedestrians may be missed by anybody."""
MOST_FRAMES: Final = 0.5
"""Share of the frames with pedestrians in which a system has to detect something."""


def audit_no_match(
    dataset: Dataset,
    systems: Sequence[BoxSource],
    counting: Sequence[BoxColumns],
    matches: Sequence[Matches],
) -> list[Finding]:
    """An error if no system matches anybody, a warning if one of two does not.

    Parameters
    ----------
    systems
        Those compared; one if there is no other.
    counting
        Their detections that pass the thresholds.

    Notes
    -----
    Only systems that detect something in half of the frames with pedestrians: one that is silent
    has other findings. One system alone that matches nobody is an error, too: nothing else tells
    that the files were read as they were meant. Where boxes overlap as they are, and the setting of
    matching asks for more, it is a warning.
    """
    of_truth = frames_with(dataset.truth, ~dataset.truth.ignore)
    n = int(np.count_nonzero(~dataset.truth.ignore))
    if n < MIN_BOXES:
        return []
    blind = [
        (system, boxes)
        for system, boxes, matched in zip(systems, counting, matches, strict=True)
        if not matched.is_matched.any() and np.mean(frames_with(boxes)[of_truth]) >= MOST_FRAMES
    ]
    if not blind:
        return []
    names = [system.name for system, _ in blind]
    are_all, objects = len(blind) == len(systems), dataset.objects
    if are_all and len(systems) == 2:
        subject, who = TRUTH_NAME, f"Neither system matches a single {objects.singular}"
        message = f"{who}, although both detect something in most frames."
    else:
        subject, who = names[0], f"{names[0]} matches not a single {objects.singular}"
        message = f"{who}, although it detects something in most frames."
    layouts = find_layouts(dataset)
    left_out = _classes_left_out(dataset, [TRUTH_NAME, *names])
    if left_out:
        message += f" Left out as other classes: {'; '.join(left_out.values())}."
    samples = [take_sample(dataset, boxes) for _, boxes in blind]
    as_they_are = [_fitting(sample, [Correction()]) for sample in samples]
    tried = [("as they are", as_they_are)]
    if are_read := any(as_they_are):
        advice = "The setting of matching asks for more: see match, iou and the classes."
    elif layouts:
        advice = "The error about the numbers of the boxes says what to do."
    else:
        advice = (
            f"Look at a frame with {objects.plural}: are these the classes, frames and boxes that "
            "were meant, and the same recording?"
        )
    if not are_read:
        tried += _tried(dataset, samples, names, n)
    message += (
        f" Tried, with how many of {count_text(n, objects.singular, objects.plural)} then overlap "
        f"a box of {' and '.join(names)} by an IoU of {FIT_IOU:g} or more: "
        + "; ".join(f"{what} {' and '.join(map(str, values))}" for what, values in tried)
        + "."
    )
    is_error = are_all and not are_read
    steps = [] if layouts or are_read else [Step(Remedy.CLASSES, "", name) for name in left_out]
    if is_error:
        steps.append(Step(Remedy.ACCEPT, CODE))
    return [
        Finding(
            severity=Severity.ERROR if is_error else Severity.WARNING,
            code=CODE,
            subject=subject,
            count=n,
            message=message,
            advice=advice,
            steps=tuple(steps),
        )
    ]


def _classes_left_out(dataset: Dataset, subjects: Sequence[str]) -> dict[str, str]:
    """What each source has of other classes, in words; none that has nothing else."""
    texts = {}
    for subject in subjects:
        read_as = dataset.read_as.get(subject)
        classes = [] if read_as is None else [p for p in read_as.left_out if p.kind == "class"]
        if classes:
            texts[subject] = f"{subject} {left_out_text(classes)}"
    return texts


def _tried(
    dataset: Dataset, samples: Sequence[Sample], names: Sequence[str], n: int
) -> list[tuple[str, list[int]]]:
    """What each likely cause would give of each system, in the order in which they were tried."""
    layouts = find_layouts(dataset)
    step = samples[0].frame_step()
    shifts = [k * step for k in range(-MAX_SHIFT, MAX_SHIFT + 1) if k]
    moved = [Correction(offset_frames=shift) for shift in shifts]
    scaled = [[Correction(scale=scale) for scale in scale_candidates(sample)] for sample in samples]
    of_boxes = [layouts.get(name, layouts.get(TRUTH_NAME)) for name in names]
    return [
        (
            f"moved by up to {count_text(max(shifts), 'frame')}",
            [_fitting(sample, moved) for sample in samples],
        ),
        (
            "other meanings of a box's numbers",
            [0 if fit is None else round(n * fit.n_fitting / fit.n) for fit in of_boxes],
        ),
        (
            "pictures of another size",
            [_fitting(*of_one) for of_one in zip(samples, scaled, strict=True)],
        ),
    ]


def _fitting(sample: Sample, corrections: Sequence[Correction]) -> int:
    """Most pedestrians that one of the corrections makes fit, of all, as the sample tells."""
    best = max(
        (np.count_nonzero(sample.overlaps(c).iou >= FIT_IOU) for c in corrections), default=0
    )
    return int(best) * sample.step
