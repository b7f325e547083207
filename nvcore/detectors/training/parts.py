"""Parts of recordings that a detector is trained on, and where they are in a dataset."""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn
from nvcore.errors import InputError
from nvcore.wording import MOST_NAMED, did_you_mean, listed


def trained_part(
    dataset: Dataset,
    recording: str,
    first_frame: int | None = None,
    last_frame: int | None = None,
) -> TrainedOn:
    """What to note of a training on a recording, or on a part of its frames.

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
    """Rows of the frames table that are of a part, if the recording of this number is its own."""
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
    """sha256 over the boxes of a recording's ground truth, in whatever order they come.

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
    """What `truth_fingerprint` is taken of: frame and sides of each box, shape (n, 5), by frame."""
    hundredths = [np.rint(100 * side).astype("<i8") for side in (x, y, w, h)]
    rows = np.column_stack([np.asarray(frame).astype("<i8"), *hundredths])
    ordered: NDArray[np.int64] = rows[np.lexsort(rows.T[::-1])]
    return ordered


def part_fingerprint(dataset: Dataset, rows: slice) -> str:
    """`truth_fingerprint` of the boxes in these rows of the frames table."""
    boxes = dataset.truth.of_frames(rows.start, rows.stop)
    return truth_fingerprint(dataset.frame_columns.frame[boxes.frame_index], *boxes.xywh)


def fingerprints_of_ranges(
    dataset: Dataset, number: int, start: NDArray[np.int64], stop: NDArray[np.int64]
) -> list[str]:
    """`part_fingerprint` of many parts of a recording; those that begin alike cost one pass.

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
