"""Frames of a dataset that are in a training, by name and by fingerprint of their truth."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn
from nvcore.errors import InputError
from nvcore.wording import MOST_NAMED, did_you_mean, listed

MOST_HASHED: Final = 50_000_000
"""Boxes of which fingerprints are made for a training: some seconds of work, more than 1,000 whole
recordings take against 1,000 others. A model's file may come from a stranger, and list more."""
_PER_PART, _PER_HASH = 1, 20
"""What a part costs in a recording, and a fingerprint, in boxes."""
_OPEN_END: Final = 2**60
"""Beyond every frame number."""
_ELSEWHERE: Final = -1


class TrainingOverlap(NamedTuple):
    """Overlap of a dataset with the data of a training.

    Attributes
    ----------
    is_trained, is_namesake
        Frames of the training, and those of a recording of the same name with other ground truth;
        bool, shape (n_frames,).
    is_unchecked
        Frames of which the ground truth was not compared, bool, shape (n_frames,).
    has_part
        Recordings of which some frames are in it, bool, shape (n_recordings,).
    """

    is_trained: NDArray[np.bool_]
    is_namesake: NDArray[np.bool_]
    is_unchecked: NDArray[np.bool_]
    has_part: NDArray[np.bool_]


def training_overlap(dataset: Dataset, trained_on: Sequence[TrainedOn]) -> TrainingOverlap:
    """Find the overlap of a dataset with a training, by names of recordings and by ground truth.

    A part whose recording is not here is looked for in all of them by its fingerprint; one whose
    frames are all here under its name must have the same ground truth. Where that takes more than
    `MOST_HASHED` allows, the ground truth is not compared.
    """
    frames, names = dataset.frame_columns, dataset.recordings["name"].tolist()
    parts = _parts(trained_on, names)
    is_trained, is_namesake, is_unchecked = np.zeros((3, len(frames)), dtype=bool)
    has_part = np.zeros(len(names), dtype=bool)
    left = MOST_HASHED
    for number in range(len(names)):
        rows = frames.rows_of(number)
        places = (_ELSEWHERE, number) if left >= 0 else (number,)
        own = parts[parts["recording"].isin(places)]
        frame = frames.frame[rows]
        start = frame.searchsorted(own["first"].to_numpy())
        stop = np.maximum(start, frame.searchsorted(own["last"].to_numpy(), side="right"))
        n_frames = (own["last"] - own["first"] + 1).to_numpy()
        is_named = (own["recording"] == number).to_numpy()
        noted = own["fingerprint"].to_numpy()
        is_compared = ~is_named | ((noted != "") & (stop - start == n_frames))
        is_same = np.zeros(len(own), dtype=bool)
        left -= _PER_PART * len(own)
        prints, left = _fingerprints(dataset, number, start[is_compared], stop[is_compared], left)
        is_same[is_compared] = prints == noted[is_compared]
        is_own = np.where(is_compared, is_same, is_named)
        is_other = is_named & ~is_own & (left >= 0)
        is_trained[rows] = _is_covered(rows, start[is_own], stop[is_own])
        is_namesake[rows] = _is_covered(rows, start[is_other], stop[is_other])
        is_unchecked[rows] = left < 0
        has_part[number] = is_own.any()
    return TrainingOverlap(is_trained, is_namesake, is_unchecked, has_part)


def _parts(trained_on: Sequence[TrainedOn], names: Sequence[str]) -> pd.DataFrame:
    """Parts that may be here: number of the recording, fingerprint, first and last frame."""
    number_of = {name: number for number, name in enumerate(names)}
    parts = [
        (
            number_of.get(part.recording, _ELSEWHERE),
            part.fingerprint,
            _frame(part.first_frame, -_OPEN_END),
            _frame(part.last_frame, _OPEN_END),
        )
        for part in trained_on
        if part.fingerprint or part.recording in number_of
    ]
    table = pd.DataFrame(parts, columns=["recording", "fingerprint", "first", "last"])
    types = {"recording": np.int64, "fingerprint": object, "first": np.int64, "last": np.int64}
    return table.astype(types).drop_duplicates().sort_values(["first", "last"])


def _frame(number: int | None, unstated: int) -> int:
    return unstated if number is None else min(max(number, -_OPEN_END), _OPEN_END)


def _fingerprints(
    dataset: Dataset, number: int, start: NDArray[np.int64], stop: NDArray[np.int64], left: int
) -> tuple[NDArray[np.object_], int]:
    """Fingerprints of the truth in these rows of a recording, and what is left to be spent.

    Empty texts, and less than nothing left, if they cost more than is `left`.
    """
    rows = dataset.frame_columns.rows_of(number)
    offsets = dataset.truth.offsets[rows.start : rows.stop + 1]
    offsets = (offsets - offsets[0]).astype(np.int64)
    n_boxes = offsets[-1]
    ranges = offsets[start] * (n_boxes + 1) + offsets[stop]
    unique, range_of = np.unique(ranges, return_inverse=True)
    first, end = np.divmod(unique, n_boxes + 1)
    is_longest = np.diff(first, append=-1) != 0
    n_hashed = int((end - first)[is_longest].sum())
    if len(unique):
        left -= int(n_boxes) + n_hashed + _PER_HASH * len(unique)
    if left < 0 or not len(unique):
        return np.full(len(start), "", dtype=object), left
    prints = fingerprints_of_ranges(dataset, number, first, end)
    return np.array(prints, dtype=object)[range_of], left


def _is_covered(
    rows: slice, start: NDArray[np.int64], stop: NDArray[np.int64]
) -> NDArray[np.bool_]:
    """Return True for the rows of a recording that are in one of these ranges."""
    n = rows.stop - rows.start
    changes = np.bincount(start, minlength=n + 1) - np.bincount(stop, minlength=n + 1)
    is_covered: NDArray[np.bool_] = np.cumsum(changes)[:n] > 0
    return is_covered


def trained_part(
    dataset: Dataset,
    recording: str,
    first_frame: int | None = None,
    last_frame: int | None = None,
) -> TrainedOn:
    """Return a recording, or a part of its frames, as a part of a training.

    Parameters
    ----------
    dataset
        Of the training; its truth gives the fingerprint.
    recording
        Name of the recording.
    first_frame, last_frame
        The frames, both included; None: its first and last evaluated ones.

    Raises
    ------
    InputError
        If there is no such recording, or it has no such frames.
    """
    names = dataset.recordings["name"].tolist()
    if recording not in names:
        known = f"they are {listed(names, most=MOST_NAMED)}"
        raise InputError(
            f"there is no recording {recording!r}; {did_you_mean(recording, names, known)}"
        )
    part = TrainedOn("", recording, first_frame, last_frame)
    rows = rows_of_part(dataset, names.index(recording), part)
    if rows.start == rows.stop:
        raise InputError(f"recording {recording!r} has no evaluated frame in that part")
    frames = dataset.frame_columns.frame[rows]
    fingerprint = part_fingerprint(dataset, rows)
    return TrainedOn(fingerprint, recording, int(frames[0]), int(frames[-1]))


def rows_of_part(dataset: Dataset, number: int, part: TrainedOn) -> slice:
    """Return the rows of the frames table of a part, given the number of its recording."""
    frames = dataset.frame_columns
    rows = frames.rows_of(number)
    own = frames.frame[rows]
    start, stop = 0, len(own)
    if part.first_frame is not None:
        start = int(own.searchsorted(part.first_frame))
    if part.last_frame is not None:
        stop = int(own.searchsorted(part.last_frame, side="right"))
    return slice(rows.start + start, rows.start + max(start, stop))


def truth_fingerprint(
    frame: NDArray[np.int64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    w: NDArray[np.float64],
    h: NDArray[np.float64],
) -> str:
    """Return the sha256 of the boxes of a recording's ground truth, whatever their order.

    Coordinates count in hundredths of a pixel: the same truth in another format has the same
    fingerprint. No box gives an empty text: nothing can be known by it.

    Parameters
    ----------
    frame
        Frame number of each box, shape (n,).
    x, y, w, h
        Left, top, width, height, px, shape (n,).
    """
    rows = _fingerprint_rows(frame, x, y, w, h)
    return hashlib.sha256(rows.tobytes()).hexdigest() if len(rows) else ""


def _fingerprint_rows(
    frame: NDArray[np.int64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    w: NDArray[np.float64],
    h: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Return the rows behind `truth_fingerprint`: frame and sides of each box, (n, 5), by frame."""
    hundredths = [np.rint(100 * side).astype("<i8") for side in (x, y, w, h)]
    rows = np.column_stack([np.asarray(frame).astype("<i8"), *hundredths])
    ordered: NDArray[np.int64] = rows[np.lexsort(rows.T[::-1])]
    return ordered


def part_fingerprint(dataset: Dataset, rows: slice) -> str:
    """Return the `truth_fingerprint` of the boxes in these rows of the frames table."""
    boxes = dataset.truth.of_frames(rows.start, rows.stop)
    return truth_fingerprint(dataset.frame_columns.frame[boxes.frame_index], *boxes.xywh)


def fingerprints_of_ranges(
    dataset: Dataset, number: int, start: NDArray[np.int64], stop: NDArray[np.int64]
) -> list[str]:
    """Return the `part_fingerprint` of many parts of a recording, in one pass if they begin alike.

    Parameters
    ----------
    start, stop
        Rows of the truth of each part, relative to the recording's first box, shape (n,), ordered
        by start, then stop.
    """
    frames = dataset.frame_columns
    own = frames.rows_of(number)
    boxes = dataset.truth.of_frames(own.start, own.stop)
    content = _fingerprint_rows(frames.frame[boxes.frame_index], *boxes.xywh)
    fingerprints = []
    begin = done = -1
    for first, end in zip(start.tolist(), stop.tolist(), strict=True):
        if first != begin:
            digest, begin, done = hashlib.sha256(), first, first
        digest.update(content[done:end].tobytes())
        done = end
        fingerprints.append(digest.hexdigest() if end > first else "")
    return fingerprints
