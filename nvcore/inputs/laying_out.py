"""Boxes of a reading made anew where their source says that its numbers mean another thing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from nvcore.errors import MissingFactError, SessionError
from nvcore.inputs.layouts import SCORE_FIRST, parse_layout
from nvcore.inputs.readers.base import Reading
from nvcore.inputs.session import Session, Source

Sizes = Mapping[str, tuple[float, float]]
"""Width and height (px) of pictures, by recording; ``""``: of all others."""


def sizes_given(session: Session) -> Sizes:
    """The sizes that a session gives."""
    sizes: dict[str, tuple[float, float]] = {
        entry.name: (entry.width, entry.height)
        for entry in session.recordings
        if entry.width is not None and entry.height is not None
    }
    common = session.common_size
    return sizes if common is None else {**sizes, "": common}


def laid_out(reading: Reading, source: Source, given: Sizes, truth: Reading | None) -> Reading:
    """The reading with its boxes as `Source.boxes` says that they are written.

    Parameters
    ----------
    given
        Sizes that go before those of the readings.
    truth
        Whose sizes help where the reading has none; None: it is the truth.

    Raises
    ------
    MissingFactError
        If the numbers are shares of pictures whose size nobody says.
    SessionError
        If the score should stand first in files that name their fields.
    """
    if source.boxes is None or source.boxes == reading.layout:
        return reading
    was, wanted = parse_layout(reading.layout), parse_layout(source.boxes)
    if wanted.is_score_first and not reading.has_score_beside:
        raise SessionError(
            f"boxes: {SCORE_FIRST}- is for rows in which the score may stand before the box; the "
            f"format of {source.path[0]} leaves no choice"
        )
    boxes = reading.boxes
    size = None
    is_same_order = was.is_score_first == wanted.is_score_first
    if was.unit == wanted.unit and is_same_order:  # the size makes no difference
        was, wanted = replace(was, unit=""), replace(wanted, unit="")
    else:
        names = boxes["recording"].array
        of_names = _sizes(names.categories, given, reading, truth)
        width, height = of_names[names.codes].T
        if np.isnan(width).any():
            raise MissingFactError(
                f"each box is {wanted.text}: the size of the pictures is needed",
                file=source.path[0],
                facts=("size",),
            )
        size = width, height, width, height
    x, y, w, h, score = (boxes[name].to_numpy() for name in (*"xywh", "score"))
    box, score = wanted.boxes(was.numbers((x, y, w, h), score, size), size)
    facts = reading.conversion, f"each box read as {parse_layout(source.boxes).text}"
    return replace(
        reading,
        boxes=boxes.assign(**dict(zip("xywh", box, strict=True)), score=score),
        conversion="; ".join(filter(None, facts)),
        layout=source.boxes,
        is_laid_out=True,
    )


def _sizes(
    names: Iterable[str], given: Sizes, reading: Reading, truth: Reading | None
) -> np.ndarray:
    """Width and height of the pictures of recordings, NaN unknown; shape (n, 2)."""
    known = dict(given)
    if "" not in given:
        for table in (reading.recordings, *([] if truth is None else [truth.recordings])):
            columns = table[["name", "width", "height"]].dropna()
            for name, width, height in columns.itertuples(index=False):
                known.setdefault(name, (width, height))
    alike = {*known.values()}
    others = given.get("", alike.pop() if len(alike) == 1 else (np.nan, np.nan))
    return np.array([known.get(name, others) for name in names], float).reshape(-1, 2)
