"""What a section of the report consists of; the template draws each kind of block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import plotly.graph_objects as go

from nvcore.wording import one_line, shortened

MAX_ROWS = 200
"""Rows of a table that are shown."""
MAX_CELL = 400
MAX_NOTE = 3000
"""Signs of a cell, and of what stands below a table; the rest is cut off with an ellipsis."""


@dataclass(frozen=True)
class Intro:
    """What a reader has to know before the figures of a section.

    Attributes
    ----------
    what
        What it is about.
    how
        How the number comes about, the formula in words.
    best
        Which way is better.
    limits
        What it does not say.
    """

    what: str
    how: str = ""
    best: str = ""
    limits: str = ""

    def parts(self) -> list[tuple[str, str]]:
        """The parts that say something, each with its label."""
        labels = ("What it is", "How it comes about", "Best", "What it does not say")
        texts = (self.what, self.how, self.best, self.limits)
        return [(label, text) for label, text in zip(labels, texts, strict=True) if text]


@dataclass(frozen=True)
class Sentences:
    """Paragraphs; `is_strong`: the first one stands out."""

    kind: ClassVar[str] = "sentences"
    texts: tuple[str, ...]
    is_strong: bool = False


@dataclass(frozen=True)
class Table:
    """A table of texts; made by `table`.

    Attributes
    ----------
    title
        Caption.
    head, rows
        Texts, as many in each row as in the head.
    right
        Columns that are aligned to the right: numbers.
    note
        What stands below; empty: nothing.
    """

    kind: ClassVar[str] = "table"
    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    right: frozenset[int]
    note: str


@dataclass(frozen=True)
class Chart:
    """A figure of Plotly and, for who cannot see it, its words.

    Attributes
    ----------
    name
        Identifier within the page.
    figure
        Light theme.
    words
        What it shows, in a sentence.
    """

    kind: ClassVar[str] = "chart"
    name: str
    figure: go.Figure
    words: str


@dataclass(frozen=True)
class Photo:
    """One frame with its boxes.

    Attributes
    ----------
    title
        Why it is shown, in a few words.
    place
        Recording, frame and time.
    text
        What happens there.
    figures
        Similarity of both systems.
    jpeg
        The picture.
    is_wide
        Whether it takes a row of its own.
    why_blank
        Why the boxes are on an empty ground; empty: they are on the picture.
    """

    title: str
    place: str
    text: str
    figures: str
    jpeg: bytes
    is_wide: bool = False
    why_blank: str = ""


@dataclass(frozen=True)
class Photos:
    """Frames, two in a row."""

    kind: ClassVar[str] = "photos"
    photos: tuple[Photo, ...]


Block = Sentences | Table | Chart | Photos


@dataclass(frozen=True)
class Section:
    """A heading, its introduction, and what follows."""

    anchor: str
    title: str
    intro: Intro | None
    blocks: tuple[Block, ...]


def table(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    right: Sequence[int] = (),
    note: str = "",
    most: int = MAX_ROWS,
) -> Table:
    """A table of anything as text; signs that cannot be seen are shown as escapes."""
    told = [note] if note else []
    if len(rows) > most:
        told.append(f"The first {most:,} of {len(rows):,} rows are shown.")
    shown = tuple(tuple(_cell(cell) for cell in row) for row in rows[:most])
    return Table(title, tuple(head), shown, frozenset(right), shortened(" ".join(told), MAX_NOTE))


def _cell(cell: object) -> str:
    # a number and its unit stay on one line
    return shortened(one_line(str(cell)), MAX_CELL).replace(" pp", "\N{NO-BREAK SPACE}pp")
