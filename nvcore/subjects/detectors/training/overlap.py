"""Frames of a dataset that a training used, by name and by fingerprint of their truth."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.dataset.provenance import TrainedOn

MOST_HASHED: Final = 50_000_000
"""Maximum number of boxes to hash for a training. This takes some seconds and is more than
comparing 1,000 whole recordings with 1,000 others needs. A stranger's model file may list more.
"""
_PER_PART, _PER_HASH = 1, 20
"""Cost of a part in a recording, and of a fingerprint, in boxes."""
_OPEN_END: Final = 2**60
"""Frame number beyond all others."""
_ELSEWHERE: Final = -1


class TrainingOverlap(NamedTuple):
    """Overlap of a dataset with the data of a training.

    Attributes
    ----------
    is_trained, is_namesake
        Frames of the training, and frames of a recording of the same name with other ground truth;
        bool, shape (n_frames,).
    is_unchecked
        Frames whose ground truth was not compared, bool, shape (n_frames,).
    has_part
        Recordings with some frames in the training, bool, shape (n_recordings,).
    """

    is_trained: NDArray[np.bool_]
    is_namesake: NDArray[np.bool_]
    is_unchecked: NDArray[np.bool_]
    has_part: NDArray[np.bool_]


def training_overlap(dataset: Dataset, trained_on: Sequence[TrainedOn]) -> TrainingOverlap:
    """Find the overlap of a dataset with a training, by names of recordings and by ground truth.

    If a part's recording is missing here, all recordings are searched for its fingerprint. If all
    its frames are here under its name, the ground truth must be the same. Beyond the budget
    `MOST_HASHED` the ground truth is not compared.
    """
    frames, names = dataset.frame_columns, dataset.recordings["name"].tolist()
    parts = _parts(trained_on, names)
    is_trained, is_namesake, is_unchecked = np.zeros((3, len(frames)), dtype=bool)
    has_part = np.zeros(len(names), dtype=bool)
    left: float = MOST_HASHED
    for number in range(len(names)):
        rows = frames.rows_of(number)
        places = (_ELSEWHERE, number) if left >= 0 else (number,)
        own = parts[parts["recording"].isin(places)]
        start, stop = _rows_of(dataset, number, own)
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
    """Return the parts that may be here: recording number, fingerprint, first and last frame."""
    number_of = {name: number for number, name in enumerate(names)}
    parts = [
        (
            number_of.get(part.recording, _ELSEWHERE),
            part.fingerprint,
            -_OPEN_END if part.first_frame is None else part.first_frame,
            _OPEN_END if part.last_frame is None else part.last_frame,
        )
        for part in trained_on
        if part.fingerprint or part.recording in number_of
    ]
    table = pd.DataFrame(parts, columns=["recording", "fingerprint", "first", "last"])
    types = {"recording": np.int64, "fingerprint": object, "first": np.int64, "last": np.int64}
    return table.astype(types).drop_duplicates().sort_values(["first", "last"])


def _rows_of(
    dataset: Dataset, number: int, parts: pd.DataFrame
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the rows of each part within a recording, as start and stop."""
    own = dataset.frame_columns.frame[dataset.frame_columns.rows_of(number)]
    start = own.searchsorted(parts["first"].to_numpy())
    return start, np.maximum(start, own.searchsorted(parts["last"].to_numpy(), side="right"))


def _fingerprints(
    dataset: Dataset, number: int, start: NDArray[np.int64], stop: NDArray[np.int64], left: float
) -> tuple[NDArray[np.object_], float]:
    """Return the fingerprints of the truth in these rows of a recording, and the remaining budget.

    A fingerprint is the sha256 of the boxes in any order, or empty if there are none. Coordinates
    are rounded to hundredths of a pixel, so that the same truth in another format has the same
    fingerprint. If the cost exceeds `left`, all are empty and the budget is negative.
    """
    frames = dataset.frame_columns
    rows = frames.rows_of(number)
    boxes = dataset.truth.of_frames(rows.start, rows.stop)
    n_boxes = len(boxes.x)
    ranges = boxes.offsets[start] * (n_boxes + 1) + boxes.offsets[stop]
    unique, range_of = np.unique(ranges, return_inverse=True)
    first, end = np.divmod(unique, n_boxes + 1)
    is_longest = np.diff(first, append=-1) != 0  # shorter ranges are hashed on the way
    if len(unique):
        left -= n_boxes + int((end - first)[is_longest].sum()) + _PER_HASH * len(unique)
    if left < 0 or not len(unique):
        return np.full(len(start), "", dtype=object), left
    hundredths = [np.rint(100 * side).astype("<i8") for side in boxes.xywh]
    content = np.column_stack([frames.frame[boxes.frame_index].astype("<i8"), *hundredths])
    content = content[np.lexsort(content.T[::-1])]
    prints = []
    begin = done = -1
    for box, stop_box in zip(first.tolist(), end.tolist(), strict=True):
        if box != begin:
            digest, begin, done = hashlib.sha256(), box, box
        digest.update(content[done:stop_box].tobytes())
        done = stop_box
        prints.append(digest.hexdigest() if stop_box > box else "")
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
    dataset: Dataset, recording: str, first_frame: int | None = None, last_frame: int | None = None
) -> TrainedOn:
    """Return a recording, or some of its evaluated frames (both ends included), as trained on."""
    names = dataset.recordings["name"].tolist()
    number = names.index(recording)
    parts = _parts([TrainedOn("", recording, first_frame, last_frame)], names)
    start, stop = _rows_of(dataset, number, parts)
    (fingerprint,), _ = _fingerprints(dataset, number, start, stop, np.inf)
    frames = dataset.frame_columns
    own = frames.frame[frames.rows_of(number)][start[0] : stop[0]]
    return TrainedOn(fingerprint, recording, int(own[0]), int(own[-1]))
