"""Data page: check of chosen files, shown before anything is opened."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st
from pandas.util import hash_pandas_object

from nvcore.auditing.recordings import kitti_sizes
from nvcore.common.errors import MissingFactError, NvcoreError
from nvcore.common.wording import count_text
from nvcore.dataset.schema import NO_TRACK
from nvcore.dataset.sources import left_out_text
from nvcore.inputs.readers.base import Reading, Role
from nvcore.inputs.session import Source
from nvcore.settings.objects import PEDESTRIAN, Objects
from ui.confined.reading import find_confined, read_confined
from ui.session import store
from ui.session.workspace import Caching
from ui.shell.messages import error_text
from ui.widgets.text import plain

USUAL_IN_KITTI: Final = ("kitti-tracking", "kitti-object")
MOST_KEPT: Final = 40
"""Largest number of cached checks. The cache avoids reading files at every click."""
OF_BOX: Final = ["recording", "frame", "x", "y", "w", "h", "score"]
"""Columns by which boxes are compared."""


@dataclass(frozen=True, eq=False)
class FileCheck:
    """Content of one source, read by itself. It is compared by identity, to serve as a key.

    Attributes
    ----------
    trouble
        Reason why the source cannot be used, or "".
    unknown
        Facts missing in its files, out of ``size`` and ``fps``.
    reading
        The reading without its boxes.
    doubt
        Reason why the files may belong into another field, or "".
    sizes
        Sizes (px) of recordings whose files state none, if the boxes end at the edge of a picture
        of KITTI.
    boxed
        Recordings with boxes.
    boxes
        Number of boxes, and a hash that does not depend on their order.
    """

    trouble: str = ""
    unknown: frozenset[str] = frozenset()
    format: str = ""
    summary: str = ""
    reading: Reading | None = None
    doubt: str = ""
    sizes: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    boxed: frozenset[str] = frozenset()
    boxes: tuple[int, int] = (0, 0)

    @property
    def recordings(self) -> list[str]:
        """Names of the recordings. There are none if the files could not be read."""
        return [] if self.reading is None else self.reading.recordings["name"].tolist()


def check_files(
    key: Callable[[], Hashable],
    source: Source,
    *,
    role: Role,
    folder: Path,
    truth: FileCheck | None = None,
    objects: Objects = PEDESTRIAN,
) -> FileCheck:
    """Read a source by itself, cached by a key that covers its content and way of reading.

    Paths of the source start from `folder`. Errors of `key` become the check's trouble. Detections
    are read with the check of the ground truth.
    """
    known = None if truth is None else truth.reading
    try:
        # without a reading the truth makes no difference
        of_both = (key(), objects, None if known is None else truth)
    except NvcoreError as error:
        return FileCheck(trouble=error_text(error))
    return check_cache().cached(
        "files", of_both, lambda: _check(source, role, folder, known, objects), most=MOST_KEPT
    )


def check_cache() -> Caching:
    """Return the session's cache of checked files and pictures."""
    cache = store.FILE_CHECKS.setdefault(Caching())
    assert cache is not None
    return cache


@st.spinner("Reading the files")
def _check(
    source: Source, role: Role, folder: Path, known: Reading | None, objects: Objects
) -> FileCheck:
    name = summary = ""
    try:
        there = find_confined(source, folder, role)
        name, summary = there.format, f"{there.title}: {count_text(len(there.paths), 'file')}"
        if role == "detections" and known is None:  # some formats cannot be read without it
            return FileCheck(format=name, summary=summary)
        reading = read_confined(
            source, role=role, folder=folder, size=_size(known), truth=known, objects=objects
        )
    except MissingFactError as error:
        if not error.facts:
            return FileCheck(trouble=error_text(error))
        # formats that need the size never hold a frame rate
        rate = {"fps"} if role == "truth" else ()
        return FileCheck(unknown=frozenset((*error.facts, *rate)), format=name, summary=summary)
    except NvcoreError as error:
        return FileCheck(trouble=error_text(error))
    frames = reading.boxes["frame"]
    unknown = _unknown(reading) if role == "truth" else frozenset()
    n_recordings = count_text(len(reading.recordings), "recording")
    summary = f"{there.title}: {n_recordings}, {count_text(len(frames), 'box', 'boxes')}"
    if len(frames):
        summary += f" in frames {frames.min()} to {frames.max()}"
    if n_ignored := int(reading.boxes["ignore"].sum()):
        summary += f", {n_ignored:,} of them to be ignored"
    doubt = (_doubt_of_truth if role == "truth" else _doubt_of_detections)(reading)
    sizes = _edge_sizes(reading) if name in USUAL_IN_KITTI and "size" in unknown else {}
    return FileCheck(
        unknown=unknown,
        format=name,
        summary=summary,
        reading=_light(reading),
        doubt=doubt,
        sizes=sizes,
        boxed=frozenset(reading.boxes["recording"].unique()),
        boxes=(len(frames), int(hash_pandas_object(reading.boxes[OF_BOX], index=False).sum())),
    )


def _edge_sizes(reading: Reading) -> dict[str, tuple[int, int]]:
    """Return sizes of recordings by the edge at which their boxes end, for known edges."""
    names, boxes = reading.recordings["name"].tolist(), reading.boxes
    number = pd.Index(names).get_indexer(pd.Index(boxes["recording"].astype(object)))
    sizes = kitti_sizes(number, (boxes["x"] + boxes["w"]).to_numpy(), len(names))
    return {
        name: (int(width), int(height))
        for name, (width, height) in zip(names, sizes.tolist(), strict=True)
        if width > 0
    }


def _doubt_of_truth(reading: Reading) -> str:
    """Return why ground truth looks like detections."""
    for finding in reading.findings:
        if finding.code == "truth-with-scores":
            return (
                f"This looks like a system's detections: {finding.count:,} of its rows have a "
                "score. Check that ground truth and detections are not swapped."
            )
    return ""


def _doubt_of_detections(reading: Reading) -> str:
    """Return why detections look like ground truth."""
    boxes = reading.boxes
    scores, tracks = boxes["score"].dropna(), boxes["track"]
    if not len(boxes) or not np.isin(scores, (0, 1)).all() or not (tracks != NO_TRACK).all():
        return ""
    return (
        "This looks like ground truth: every box has a track id, none a score. Check that ground "
        "truth and detections are not swapped; a tracker's output may look so, too."
    )


def _light(reading: Reading) -> Reading:
    """Copy a reading without its boxes. A view would keep the whole table in memory."""
    images = None if reading.images is None else reading.images.copy()
    return replace(reading, boxes=reading.boxes.iloc[:0].copy(), images=images, annotated=None)


def _unknown(reading: Reading) -> frozenset[str]:
    table = reading.recordings
    is_unknown = {"size": table[["width", "height"]].isna(), "fps": table[["fps"]].isna()}
    return frozenset(name for name, cells in is_unknown.items() if cells.to_numpy().any())


def _size(truth: Reading | None) -> tuple[int, int] | None:
    """Return the size that the ground truth states for all recordings, or None."""
    if truth is None:
        return None
    sizes = truth.recordings[["width", "height"]].dropna().drop_duplicates().to_numpy()
    if len(sizes) != 1:
        return None
    return int(sizes[0, 0]), int(sizes[0, 1])


def draw_file_check(check: FileCheck | None) -> None:
    """Draw the content of a field's files, or why they cannot be used."""
    if check is None:
        return
    if check.trouble:
        st.error(plain(check.trouble), icon=":material/error:")
    elif check.summary:
        st.caption(f"Read as {plain(check.summary)}.")
        if check.reading is not None and (left_out := left_out_text(check.reading.left_out)):
            st.caption(f"Left out: {plain(left_out)}.")
    if check.doubt:
        st.warning(plain(check.doubt), icon=":material/swap_vert:")
