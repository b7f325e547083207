"""Findings on boxes outside the picture, repeated boxes, and track ids used twice."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.auditing.cases import BoxSource
from nvcore.common.findings import Finding, Remedy, Severity, Step
from nvcore.common.wording import count_text
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import NO_TRACK
from nvcore.dataset.sources import ReadAs
from nvcore.inputs.box_layouts import parse_layout
from nvcore.metrics.encounters import encounters_of
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.pairs import mark_repeats

REUSE_S: Final = 5.0
"""Time in seconds after which an unseen pedestrian is unlikely to be the same person ..."""
REUSE_FRAMES: Final = 10
"""... if it also spans more listed frames than this (annotation may be sampled)."""
MANY_OUTSIDE: Final = 0.1
"""Least share of boxes wholly or mostly outside the picture that suggests a wrong picture size."""
MOST_OUTSIDE: Final = 0.5
"""Least share of the truth's boxes outside that proves a wrong picture size or box layout."""
FRACTION_EXTENT: Final = 1.5
"""Boxes whose edges all stay below this are fractions of the picture, not pixels."""
THOUSAND: Final = 1000
"""Boxes outside the picture whose edges all stay below this may be in thousandths of it."""
CROWDED: Final = 1000
"""Boxes of a frame above which repeats are found by hashing, because comparing pairs is slow."""
HAIR_PX: Final = 1e-3
"""Narrower boxes may lose their width in rounding."""


def audit_geometry(source: BoxSource) -> list[Finding]:
    """Report boxes wholly or mostly outside the picture, and boxes in fractions of the picture."""
    boxes = source.boxes
    if not len(boxes):
        return []
    frames = source.dataset.frame_columns
    has_box = np.diff(source.starts) > 0
    smallest = min(frames.width[has_box].min(), frames.height[has_box].min())
    furthest, suspects = -np.inf, []
    for block, recordings in source.blocks():
        x, y, w, h = (column[block] for column in (boxes.x, boxes.y, boxes.w, boxes.h))
        right, bottom = x + w, y + h
        furthest = max(furthest, right.max(), bottom.max())
        n_boxes = np.diff(source.starts[recordings.start : recordings.stop + 1])
        is_odd = (x < 0) | (y < 0) | (np.minimum(w, h) < HAIR_PX)
        is_odd |= right > np.repeat(frames.width[recordings], n_boxes)
        is_odd |= bottom > np.repeat(frames.height[recordings], n_boxes)
        suspects.append(block.start + np.flatnonzero(is_odd))
    was = parse_layout(source.dataset.read_as.get(source.name, ReadAs()).boxes)
    if smallest > 10 and furthest <= FRACTION_EXTENT:
        return source.findings(
            Severity.ERROR,
            "boxes-in-fractions",
            np.arange(len(boxes)),
            f"No box reaches beyond {furthest:.3g} px: the coordinates "
            "are fractions of the picture, not pixels.",
            "Multiply x and w by the width and y and h by the height of the picture, or say what "
            "they are.",
            is_of_all=True,
            steps=(Step(Remedy.BOXES, str(replace(was, unit="shares")), source.name),),
        )
    # boxes that may not lie entirely inside; the others have their whole area inside
    rows = np.concatenate(suspects)
    x, y, w, h = boxes.x[rows], boxes.y[rows], boxes.w[rows], boxes.h[rows]
    recording = frames.recording[boxes.frame_index[rows]]
    across = np.minimum(x + w, frames.width[recording]) - np.maximum(x, 0)
    down = np.minimum(y + h, frames.height[recording]) - np.maximum(y, 0)
    is_outside = (across <= 0) | (down <= 0)
    is_off = np.where(is_outside, 0, across * down) / (w * h) < 0.5
    n_off = int(np.count_nonzero(is_off))
    if source.is_truth and n_off > MOST_OUTSIDE * len(boxes):
        steps = [Step(Remedy.SIZE)]
        if furthest <= THOUSAND:
            steps.append(Step(Remedy.BOXES, str(replace(was, unit="thousandths"))))
        return source.findings(
            Severity.ERROR,
            "outside-picture",
            rows[is_off],
            f"{n_off} of {count_text(len(boxes), 'box', 'boxes')} lie with more "
            "than half of their area outside the picture: its size, or what the numbers of a box "
            "were taken for, is wrong.",
            "See at which resolution the boxes were made, or in which unit.",
            steps=tuple(steps),
        )
    are_many = n_off > MANY_OUTSIDE * len(boxes)
    return _stray(source, rows[is_outside], rows[~is_outside & is_off], are_many=are_many)


def _stray(
    source: BoxSource, outside: np.ndarray, mostly: np.ndarray, *, are_many: bool
) -> list[Finding]:
    """Report boxes wholly outside the picture, and boxes mostly outside."""
    steps = (Step(Remedy.SIZE),) if are_many else ()
    advice = source.dataset.objects.say(
        "Nothing to do if boxes of {people} at the picture's edge are drawn in full; their lateral "
        "position is taken at the edge."
    )
    return [
        *source.findings(
            Severity.WARNING,
            "outside-picture",
            outside,
            f"{count_text(len(outside), 'box lies', 'boxes lie')} wholly outside the picture.",
            "That is too many for stray boxes: check the image size, and at which resolution the "
            "boxes were made."
            if are_many
            else "Remove the boxes, or check the image size.",
            steps=steps,
        ),
        *source.findings(
            Severity.NOTE,
            "mostly-outside-picture",
            mostly,
            f"{count_text(len(mostly), 'box has', 'boxes have')} more than half of the area "
            "outside the picture.",
            advice + " So many are unusual: check the image size first." * are_many,
            steps=steps,
        ),
    ]


def audit_doubles(source: BoxSource) -> list[Finding]:
    """Report equal boxes in one frame (only pedestrians in the truth)."""
    boxes = source.boxes
    takes_part = ~(boxes.ignore & source.is_truth)
    people = boxes if takes_part.all() else boxes.only(takes_part)
    doubles = np.flatnonzero(takes_part)[repeated_rows(people)]
    return source.findings(
        Severity.WARNING,
        "duplicate-box",
        doubles,
        f"{count_text(len(doubles), 'box repeats', 'boxes repeat')} another one of the same frame "
        "exactly.",
        "Remove the repeats: one of the two can never be detected."
        if source.is_truth
        else "Remove the repeats (two files of one recording?): each counts as a false alarm.",
    )


def audit_tracks(source: BoxSource) -> list[Finding]:
    """Report track ids of the truth that occur twice in a frame or again after a long gap."""
    boxes = source.boxes
    _, encounters = encounters_of(source.dataset)
    # boxes of each track by frame, without tracks created by linking
    rows = encounters.order
    has_track = boxes.track[rows] != NO_TRACK
    if not has_track.all():
        rows = rows[has_track]
    if not len(rows):
        return []
    frame_index, code = boxes.frame_index[rows], encounters.encounter_of[rows]
    is_same = (code[1:] == code[:-1]) & (frame_index[1:] == frame_index[:-1])
    doubles, objects = np.sort(rows[1:][is_same]), source.dataset.objects
    return [
        *source.findings(
            Severity.ERROR,
            "duplicate-track",
            doubles,
            f"{count_text(len(doubles), 'box has', 'boxes have')} a track id that another "
            f"{objects.singular} of the same frame has, too (first: id "
            f"{boxes.track[doubles[0]] if len(doubles) else ''}).",
            objects.say(
                "Give every {one} of a recording an id of its own: two {people} under one id "
                "count as one encounter."
            ),
        ),
        *_reused(source, rows, code),
    ]


def _reused(source: BoxSource, rows: np.ndarray, code: np.ndarray) -> list[Finding]:
    """Report tracks that go on after a long gap, from their rows by track and frame."""
    boxes, time_s = source.boxes, source.dataset.frames["time_s"].to_numpy()
    frame_of = boxes.frame_index[rows]
    again = 1 + np.flatnonzero(
        (code[1:] == code[:-1]) & (frame_of[1:] - frame_of[:-1] - 1 > REUSE_FRAMES)
    )
    again = again[time_s[frame_of[again]] - time_s[frame_of[again - 1]] > REUSE_S]

    def longest_gap_s(at: int) -> float:
        """Return the longest gap since the track's previous box, including its ignored boxes."""
        between = slice(boxes.offsets[frame_of[at - 1]], boxes.offsets[frame_of[at] + 1])
        is_own = boxes.track[between] == boxes.track[rows[at]]
        return float(np.diff(time_s[boxes.frame_index[between][is_own]]).max())

    # a loop over the few long gaps
    again = np.array([at for at in again if longest_gap_s(at) > REUSE_S], dtype=np.int64)
    if not len(again):
        return []
    n_tracks = len(np.unique(code[again]))
    again = again[np.argsort(rows[again])]
    gap, first = longest_gap_s(again[0]), rows[again]
    return source.findings(
        Severity.WARNING,
        "track-reused",
        first,
        f"{count_text(n_tracks, 'track id is', 'track ids are')} used again after more than "
        f"{REUSE_S:g} s without a box (first: id {int(boxes.track[first[0]])}, after {gap:.1f} s).",
        source.dataset.objects.say(
            "If it is {somebody} else, give a new id: otherwise both are one encounter, and the "
            "time between them counts as its duration."
        ),
        count=n_tracks,
    )


def repeated_rows(boxes: BoxColumns) -> np.ndarray:
    """Return the rows of boxes that are equal to an earlier one of their frame."""
    if np.diff(boxes.offsets).max(initial=0) > CROWDED:  # the kernel compares all pairs of a frame
        table = pd.DataFrame(dict(zip("fxywh", (boxes.frame_index, *boxes.xywh), strict=True)))
        return np.flatnonzero(table.duplicated())
    is_repeat = np.zeros(len(boxes), bool)
    over_ranges(mark_repeats, len(boxes.offsets) - 1, boxes.arrays, is_repeat)
    return np.flatnonzero(is_repeat)
