"""Detection of recordings with the same truth: copied, cut, shifted, or nearly the same."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from nvcore.dataset.near_copies import find_near_copies

if TYPE_CHECKING:
    from nvcore.dataset import Dataset

LEAST_BOXES: Final = 20
"""Fewest shared boxes of copies. Neighbours in place and time share single boxes by chance."""
LEAST_SHARE: Final = 0.5
"""Least share of the smaller recording's boxes that the other one must have."""
GRAIN_PX: Final = 0.01
"""Boxes that differ by less are equal, because files are written with few decimals."""


@dataclass(frozen=True)
class Copy:
    """Two recordings with the same boxes of the truth, or nearly the same.

    Attributes
    ----------
    first, second
        Rows of the recordings table, ``first < second``.
    n_shared
        Number of boxes with the same place and size in frames that are `shift_frames` apart. Of
        near copies, after a transform, and with small errors.
    share
        Shared boxes as a share of those of the recording with fewer boxes.
    shift_frames
        Frame number in the second recording minus that in the first.
    relation
        What makes the second one differ, such as ``mirrored``; empty if the boxes are the same.
    """

    first: int
    second: int
    n_shared: int
    share: float
    shift_frames: int
    relation: str = ""


def find_copies(dataset: Dataset) -> tuple[Copy, ...]:
    """Find recordings whose truth is that of another one, or a part of it, or nearly so.

    Each is paired with one that has the same boxes, so that all copies of one recording are linked.
    Boxes are compared by place and size, to `GRAIN_PX`, and by frame number, up to a shift. Near
    copies (`nvcore.dataset.near_copies`) are looked for among recordings that this does not link.
    """
    n_all = len(dataset.recordings)
    if n_all < 2 or len(dataset.truth) < LEAST_BOXES:
        return ()
    recording = dataset.frame_columns.recording[dataset.truth.frame_index].astype(np.int64)
    n_boxes = np.bincount(recording, minlength=n_all)
    copies = [*_same_boxes(dataset, recording, n_boxes)]
    linked = [(copy.first, copy.second) for copy in copies]
    for first, second, share, shift, relation in find_near_copies(dataset, n_boxes, linked):
        n_shared = round(share * int(min(n_boxes[first], n_boxes[second])))
        copies.append(Copy(first, second, n_shared, share, shift, relation))
    return tuple(copies)


def _same_boxes(dataset: Dataset, recording: np.ndarray, n_boxes: np.ndarray) -> tuple[Copy, ...]:
    """Find recordings with boxes that are equal to `GRAIN_PX`."""
    truth, frames = dataset.truth, dataset.frames
    key = _hashed(truth.xywh)
    ordered = np.sort(key)
    repeated = ordered[1:][ordered[1:] == ordered[:-1]]
    if len(repeated) < LEAST_BOXES:
        return ()
    # most boxes have no equal, so almost none of them needs sorting
    begins_repeated = np.zeros(1 << 20, dtype=bool)
    begins_repeated[repeated >> np.uint64(44)] = True
    rows = np.flatnonzero(begins_repeated[key >> np.uint64(44)])
    key, recording = key[rows], recording[rows]
    frame = frames["frame"].to_numpy()[truth.frame_index[rows]]
    order = np.lexsort((frame, recording, key))
    key, recording, frame = key[order], recording[order], frame[order]
    is_pair = (key[1:] == key[:-1]) & (recording[1:] != recording[:-1])
    at = np.flatnonzero(is_pair)
    if len(at) < LEAST_BOXES:
        return ()
    links = np.column_stack([recording[at], recording[at + 1], frame[at + 1] - frame[at]])
    unique, counts = np.unique(links, axis=0, return_counts=True)
    copies: dict[tuple[int, int], Copy] = {}
    for (first, second, shift), n_shared in zip(unique.tolist(), counts.tolist(), strict=True):
        share = n_shared / min(n_boxes[first], n_boxes[second])
        known = copies.get((first, second))
        if n_shared < LEAST_BOXES or share < LEAST_SHARE:
            continue
        if known is None or known.n_shared < n_shared:
            copies[first, second] = Copy(first, second, n_shared, float(share), shift)
    return tuple(copies.values())


def _hashed(sides: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return a hash of each box, uint64, (n,). Boxes equal to `GRAIN_PX` have equal hashes."""
    key = np.zeros(len(sides[0]), np.uint64)
    for side in sides:
        key ^= np.round(side / GRAIN_PX).astype(np.int64).view(np.uint64)
        key *= np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return key


def open_copies(dataset: Dataset) -> tuple[Copy, ...]:
    """Return the copies that are not settled by stated units of both recordings."""
    has_unit = dataset.recordings["unit"].to_numpy() != ""
    return tuple(
        copy for copy in dataset.copies if not (has_unit[copy.first] and has_unit[copy.second])
    )


def units_of(dataset: Dataset) -> np.ndarray:
    """Return the name of each recording's unit, object, shape (n_recordings,).

    Empty means that the recording is a unit of its own. Recordings of one unit are not independent:
    they are stated to belong to one unit, or have the same truth (or nearly) without both having a
    stated unit.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    table = dataset.recordings[["name", "unit"]].astype(object)
    stated: dict[str, int] = {}
    links = [(stated.setdefault(unit, row), row) for row, unit in enumerate(table["unit"]) if unit]
    links += [(copy.first, copy.second) for copy in open_copies(dataset)]
    ends = np.array(links, np.int64).reshape(-1, 2).T
    graph = coo_array((np.ones(len(links)), tuple(ends)), shape=(len(table), len(table)))
    table["group"] = connected_components(graph, directed=False)[1]
    stating = table[table["unit"] != ""]
    called = dict(table.groupby("group")["name"].first())
    called |= dict(stating.groupby("group")["unit"].first())
    is_shared = table["group"].duplicated(keep=False) | (table["unit"] != "")
    return np.where(is_shared, table["group"].map(called).astype(object), "")
