"""Meanings of the four numbers of a box, and correction of readings with a wrong meaning.

A reader assumes the meaning of its format, but a file may differ: corners instead of width and
height, the vertical axis first, or shares of the picture. A box that was read with the wrong
meaning still determines the numbers in the file, so correcting it does not need the file.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Final

from nvcore.common.errors import MissingFactError, SessionError

if TYPE_CHECKING:
    import numpy as np

    from nvcore.inputs.readers.base import Reading
    from nvcore.inputs.session import Session, Source

Sizes = Mapping[str, tuple[float, float]]
"""Width and height (px) of pictures, by recording; ``""``: of all others."""
Box = tuple["np.ndarray", "np.ndarray", "np.ndarray", "np.ndarray"]
"""Four numbers of each box, or its x, y, w, h in pixels; each of shape (n,)."""

KINDS: Final = {
    "sizes": (("left", "top", "width", "height"), ("top", "left", "height", "width")),
    "corners": (("left", "top", "right", "bottom"), ("top", "left", "bottom", "right")),
    "centres": (
        ("centre x", "centre y", "width", "height"),
        ("centre y", "centre x", "height", "width"),
    ),
}
"""Names of the four numbers in order, with the horizontal one of each pair first, or second."""
UNITS: Final = {
    "": (None, ""),
    "shares": (1.0, "shares of the picture (0 to 1)"),
    "percent": (100.0, "percent of the picture"),
    "thousandths": (1000.0, "thousandths of the picture"),
}
"""Width (or height) of the picture in each unit. None: pixels."""
YX: Final = "yx"
SCORE_FIRST: Final = "score"


@dataclass(frozen=True)
class BoxLayout:
    """Meaning of the numbers of a box.

    Attributes
    ----------
    kind
        A key of `KINDS`.
    is_yx
        Whether the vertical number of each pair comes first.
    unit
        A key of `UNITS`.
    is_score_first
        Whether the score is before the four numbers, not after them as the reader assumed.
    """

    kind: str = "sizes"
    is_yx: bool = False
    unit: str = ""
    is_score_first: bool = False

    def __str__(self) -> str:
        """Name the layout as session files and flags do, such as ``corners-yx-thousandths``."""
        words = (SCORE_FIRST * self.is_score_first, self.kind, YX * self.is_yx, self.unit)
        return "-".join(filter(None, words))

    @property
    def text(self) -> str:
        """Describe the layout: ``left, top, right, bottom in percent of the picture``."""
        text = ", ".join(KINDS[self.kind][self.is_yx])
        if self.is_score_first:
            text = f"score, {text}"
        return f"{text} in {UNITS[self.unit][1]}" if self.unit else text

    def numbers(self, box: Box, score: np.ndarray, size: Box | None) -> tuple[np.ndarray, ...]:
        """Convert a box in pixels and its score to the file's numbers (inverse of `boxes`)."""
        x, y, w, h = box
        if self.kind == "corners":
            w, h = x + w, y + h
        elif self.kind == "centres":
            x, y = x + w / 2, y + h / 2
        a, b, c, d = self._scaled((x, y, w, h), size, is_back=True)
        numbers = (b, a, d, c) if self.is_yx else (a, b, c, d)
        return (score, *numbers) if self.is_score_first else (*numbers, score)

    def boxes(self, numbers: tuple[np.ndarray, ...], size: Box | None) -> tuple[Box, np.ndarray]:
        """Convert the file's numbers to x, y, w, h (px) and the score.

        Parameters
        ----------
        size
            Width and height (px) of the picture of each box. None if the numbers are pixels.
        """
        score, a, b, c, d = numbers if self.is_score_first else (numbers[4], *numbers[:4])
        x, y, w, h = self._scaled((b, a, d, c) if self.is_yx else (a, b, c, d), size)
        if self.kind == "corners":
            w, h = w - x, h - y
        elif self.kind == "centres":
            x, y = x - w / 2, y - h / 2
        return (x, y, w, h), score

    def _scaled(self, box: Box, size: Box | None, *, is_back: bool = False) -> Box:
        whole = UNITS[self.unit][0]
        if whole is None:
            return box
        assert size is not None
        width, height = size[0] / whole, size[1] / whole
        if is_back:
            width, height = 1 / width, 1 / height
        x, y, w, h = box
        return x * width, y * height, w * width, h * height


def parse_layout(text: str) -> BoxLayout:
    """Parse the name of a layout in a session file or a flag.

    Raises
    ------
    SessionError
        If it is none.

    Examples
    --------
    >>> parse_layout("corners-yx-thousandths").text
    'top, left, bottom, right in thousandths of the picture'
    """
    pattern = rf"(score-)?({'|'.join(KINDS)})(-yx)?(?:-({'|'.join(filter(None, UNITS))}))?"
    match = re.fullmatch(pattern, text.strip().lower())
    if match is None:
        raise SessionError(
            f"boxes: expected {', '.join(KINDS)}, behind it -yx where the vertical number comes "
            f"first, and -{', -'.join(filter(None, UNITS))} where they are such, as in "
            f"corners-yx-shares; found {text!r}"
        )
    score, kind, yx, unit = match.groups(default="")
    return BoxLayout(kind, bool(yx), unit, bool(score))


def layouts(units: Iterable[str], orders: Iterable[bool]) -> list[BoxLayout]:
    """List all layouts with these units and with the score before (True) or after the box."""
    sides = product(units, KINDS, (False, True), orders)
    return [BoxLayout(kind, is_yx, unit, is_first) for unit, kind, is_yx, is_first in sides]


def sizes_given(session: Session) -> Sizes:
    """Return the picture sizes that a session gives."""
    sizes: dict[str, tuple[float, float]] = {
        entry.name: (entry.width, entry.height)
        for entry in session.recordings
        if entry.width is not None and entry.height is not None
    }
    common = session.common_size
    return sizes if common is None else {**sizes, "": common}


def with_layout(reading: Reading, source: Source, given: Sizes, truth: Reading | None) -> Reading:
    """Return the reading with its boxes interpreted as `Source.boxes` says.

    Parameters
    ----------
    given
        Sizes that take precedence over those of the readings.
    truth
        Truth with sizes for recordings without one. None: the reading is the truth.

    Raises
    ------
    MissingFactError
        If the numbers are shares of pictures of unknown size.
    SessionError
        If the score should stand first in files that name their fields.
    """
    if source.boxes is None or source.boxes == reading.layout:
        return reading
    import numpy as np  # not at the top: a session file is read without it

    was, wanted = parse_layout(reading.layout), parse_layout(source.boxes)
    if wanted.is_score_first and not reading.has_score_beside:
        raise SessionError(
            f"boxes: {SCORE_FIRST}- is for rows in which the score may stand before the box; the "
            f"format of {source.path[0]} leaves no choice"
        )
    boxes = reading.boxes
    size = None
    if (was.unit, was.is_score_first) == (wanted.unit, wanted.is_score_first):
        # the size makes no difference
        was, wanted = replace(was, unit=""), replace(wanted, unit="")
    else:
        names = boxes["recording"].array
        of_names = _sizes(names.categories, given, reading, truth)
        width, height = np.array(of_names, float).reshape(-1, 2)[names.codes].T
        if np.isnan(width).any():
            raise MissingFactError(
                f"each box is {wanted.text}: the size of the pictures is needed",
                file=source.path[0],
                facts=("size",),
            )
        size = width, height, width, height
    x, y, w, h, score = (boxes[name].to_numpy() for name in (*"xywh", "score"))
    box, score = wanted.boxes(was.numbers((x, y, w, h), score, size), size)
    fact = f"each box read as {parse_layout(source.boxes).text}"
    return replace(
        reading,
        boxes=boxes.assign(**dict(zip("xywh", box, strict=True)), score=score),
        conversion="; ".join(filter(None, (reading.conversion, fact))),
        layout=source.boxes,
        is_laid_out=True,
    )


def _sizes(
    names: Iterable[str], given: Sizes, reading: Reading, truth: Reading | None
) -> list[tuple[float, float]]:
    """Return the width and height (px) of the pictures of recordings, NaN if unknown."""
    known = dict(given)
    if "" not in given:
        for table in (reading.recordings, *([] if truth is None else [truth.recordings])):
            columns = table[["name", "width", "height"]].dropna()
            for name, width, height in columns.itertuples(index=False):
                known.setdefault(name, (width, height))
    alike = {*known.values()}
    others = given.get("", alike.pop() if len(alike) == 1 else (math.nan, math.nan))
    return [known.get(name, others) for name in names]
