"""Boxes outside the picture, repeated boxes, and track ids used twice."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd

from nvcore.auditing.cases import BoxSource
from nvcore.findings import Finding, Severity
from nvcore.metrics.kernels.encounters import group_rows
from nvcore.schema import NO_TRACK
from nvcore.wording import count_text

REUSE_S: Final = 5.0
"""A pedestrian unseen for longer than this, in seconds, is unlikely to be the same person ..."""
REUSE_FRAMES: Final = 10
"""... if unseen in more listed frames than this, too (annotation may be sampled)."""
MANY_OUTSIDE: Final = 0.1
"""Share of boxes wholly or mostly outside the picture that points to a wrong picture size."""
FRACTION_EXTENT: Final = 1.5
"""Boxes whose edges all stay below this are fractions of the picture, not pixels."""
HASH_FACTOR: Final = np.uint64(0x9E3779B97F4A7C15)
"""2**64 divided by the golden ratio: spreads neighbouring values over all 64 bits."""


def audit_geometry(source: BoxSource) -> list[Finding]:
    """Boxes wholly or mostly outside the picture, boxes in fractions of the picture."""
    boxes = source.boxes
    if not len(boxes):
        return []
    frames = source.dataset.frame_columns
    W, H = frames.width[source.recording], frames.height[source.recording]
    right, bottom = boxes.x + boxes.w, boxes.y + boxes.h
    if min(W.min(), H.min()) > 10 and max(right.max(), bottom.max()) <= FRACTION_EXTENT:
        return source.findings(
            Severity.ERROR,
            "boxes-in-fractions",
            np.arange(len(boxes)),
            f"No box reaches beyond {max(right.max(), bottom.max()):.3g} px: the coordinates "
            "are fractions of the picture, not pixels.",
            "Multiply x and w by the width and y and h by the height of the picture, or read "
            "the file as YOLO text.",
        )
    across = np.minimum(right, W) - np.maximum(boxes.x, 0)
    down = np.minimum(bottom, H) - np.maximum(boxes.y, 0)
    is_outside = (across <= 0) | (down <= 0)
    inside_share = np.where(is_outside, 0, across * down) / (boxes.w * boxes.h)
    is_off = inside_share < 0.5
    are_many = int(np.count_nonzero(is_off)) > MANY_OUTSIDE * len(boxes)
    return [
        *_outside(source, np.flatnonzero(is_outside), are_many=are_many),
        *_mostly_outside(source, np.flatnonzero(~is_outside & is_off), are_many=are_many),
    ]


def _outside(source: BoxSource, rows: np.ndarray, *, are_many: bool) -> list[Finding]:
    advice = "Remove the boxes, or check the image size."
    if are_many:
        advice = (
            "That is too many for stray boxes: check the image size (--size), and at which "
            "resolution the boxes were made."
        )
    message = f"{count_text(len(rows), 'box lies', 'boxes lie')} wholly outside the picture."
    return source.findings(Severity.WARNING, "outside-picture", rows, message, advice)


def _mostly_outside(source: BoxSource, rows: np.ndarray, *, are_many: bool) -> list[Finding]:
    advice = (
        "Nothing to do if boxes of people at the picture's edge are drawn in full; their lateral "
        "position is taken at the edge."
    )
    if are_many:
        advice = f"Check the image size (--size) first: so many are unusual. {advice}"
    what = count_text(len(rows), "box has", "boxes have")
    message = f"{what} more than half of the area outside the picture."
    return source.findings(Severity.NOTE, "mostly-outside-picture", rows, message, advice)


def audit_doubles(source: BoxSource) -> list[Finding]:
    """The same box twice in one frame (of the truth, pedestrians only)."""
    boxes = source.boxes
    rows = np.flatnonzero(~boxes.ignore) if source.is_truth else np.arange(len(boxes))
    columns = (boxes.frame_index, boxes.x, boxes.y, boxes.w, boxes.h)
    doubles = repeated_rows(rows, tuple(column[rows] for column in columns))
    what = count_text(len(doubles), "box repeats", "boxes repeat")
    message = f"{what} another one of the same frame exactly."
    if source.is_truth:
        advice = "Remove the repeats: one of the two can never be detected."
    else:
        advice = "Remove the repeats (two files of one recording?): each counts as a false alarm."
    return source.findings(Severity.WARNING, "duplicate-box", doubles, message, advice)


def audit_tracks(source: BoxSource) -> list[Finding]:
    """Track ids of the truth: twice in one frame, or used again after a long gap."""
    boxes = source.boxes
    rows = np.flatnonzero(~boxes.ignore & (boxes.track != NO_TRACK))
    if not len(rows):
        return []
    findings: list[Finding] = []
    frame_index, track = boxes.frame_index[rows], boxes.track[rows]
    doubles = repeated_rows(rows, (frame_index, track))
    if len(doubles):
        first = int(boxes.track[doubles[0]])
        findings += source.findings(
            Severity.ERROR,
            "duplicate-track",
            doubles,
            f"{count_text(len(doubles), 'box has', 'boxes have')} a track id that another "
            f"pedestrian of the same frame has, too (first: id {first}).",
            "Give every pedestrian of a recording an id of its own: two people under one id "
            "count as one encounter.",
        )
    return findings + _reused(source, rows)


def _reused(source: BoxSource, rows: np.ndarray) -> list[Finding]:
    boxes, frames = source.boxes, source.dataset.frame_columns
    time_s = source.dataset.frames["time_s"].to_numpy()
    track = boxes.track[rows]
    lowest, span = int(track.min()), int(track.max()) - int(track.min()) + 1
    key = frames.recording[boxes.frame_index[rows]].astype(np.int64) * span + (track - lowest)
    code = pd.factorize(key)[0].astype(np.int64)
    order = group_rows(code, np.bincount(code).astype(np.int64))
    frame_of = boxes.frame_index[rows[order]]
    code = code[order]
    is_reused = (
        (code[1:] == code[:-1])
        & (frame_of[1:] - frame_of[:-1] - 1 > REUSE_FRAMES)
        & (time_s[frame_of[1:]] - time_s[frame_of[:-1]] > REUSE_S)
    )
    again = np.flatnonzero(is_reused) + 1
    if not len(again):
        return []
    n_tracks = len(np.unique(code[again]))
    again = again[np.argsort(order[again])]
    gap = float(time_s[frame_of[again[0]]] - time_s[frame_of[again[0] - 1]])
    first = rows[order[again]]
    return source.findings(
        Severity.WARNING,
        "track-reused",
        first,
        f"{count_text(n_tracks, 'track id is', 'track ids are')} used again after more than "
        f"{REUSE_S:g} s without a box (first: id {int(boxes.track[first[0]])}, after {gap:.1f} s).",
        "If it is somebody else, give a new id: otherwise both are one encounter, and the time "
        "between them counts as its duration.",
        count=n_tracks,
    )


def repeated_rows(rows: np.ndarray, columns: tuple[np.ndarray, ...]) -> np.ndarray:
    """Those rows that agree in every column with an earlier one, in their order.

    Parameters
    ----------
    rows
        What to return, increasing, shape (n,).
    columns
        int64 or float64, each of shape (n,).
    """
    # sorting one 64-bit hash a row is several times faster than sorting the rows themselves;
    # only rows whose hash occurs twice are compared in full
    hashed = np.zeros(len(rows), np.uint64)
    for column in columns:
        bits = (column + 0.0 if column.dtype.kind == "f" else column).view(np.uint64)
        hashed ^= bits
        hashed *= HASH_FACTOR
        hashed ^= hashed >> np.uint64(29)
    in_order = np.sort(hashed)
    twice = np.unique(in_order[1:][in_order[1:] == in_order[:-1]])
    if not len(twice):
        return rows[:0]
    suspects = np.flatnonzero(np.isin(hashed, twice))
    table = pd.DataFrame({i: column[suspects] for i, column in enumerate(columns)})
    repeats: np.ndarray = rows[suspects[table.duplicated().to_numpy()]]
    return repeats
