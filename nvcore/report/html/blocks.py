"""What a section of the report consists of; the template draws each kind of block."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.objects import Objects
from nvcore.wording import minus, one_line, shortened

MAX_ROWS = 200
"""Most rows of a table that are shown."""
MAX_PRINTED: Final = 12
"""Most rows of a table on paper, unless it says otherwise."""
IN_THE_FILE: Final = "in the HTML file"
"""Where a reader of the paper finds what is not printed."""
MAX_CELL = 400
MAX_NOTE = 3000
"""Most characters of a cell, and of the note below a table; an ellipsis replaces the rest."""


_SIGN: Final = re.compile(r"(?<![\w.])-(?=\.?\d)")
"""The sign of a number; not that of an exponent, nor a hyphen in a name."""


@dataclass(frozen=True)
class Intro:
    """What a reader has to know before the content of a section: templates, until they are `said`.

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

    def said(self, objects: Objects, **values: object) -> Intro:
        """The introduction with the words for these objects, and with these values."""
        texts = (self.what, self.how, self.best, self.limits)
        return Intro(*(objects.say(text, **values) for text in texts))

    def parts(self) -> list[tuple[str, str]]:
        """What stands in the appendix, each part with its label."""
        parts = (("How it comes about", self.how), ("What it does not say", self.limits))
        return [(label, text) for label, text in parts if text]

    @property
    def in_short(self) -> str:
        """What it is about and which way is better: what stands in the section itself."""
        best = f" Best: {self.best[:1].lower()}{self.best[1:]}" if self.best else ""
        return f"{self.what}{best}"


@dataclass(frozen=True)
class Sentences:
    """Paragraphs; if `is_strong`, the first stands out."""

    kind: ClassVar[str] = "sentences"
    texts: tuple[str, ...]
    is_strong: bool = False


@dataclass(frozen=True)
class Topics:
    """Topics, each with what is to be said on it."""

    kind: ClassVar[str] = "points"
    points: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Table:
    """A table of texts; use `table` to make one.

    Attributes
    ----------
    title
        Caption.
    head, rows
        Texts, as many in each row as in the head.
    right
        Columns aligned to the right: numbers.
    note
        Text below the table; empty: none.
    printed
        Most rows on paper.
    rest
        Where the others are, after "12 more:".
    """

    kind: ClassVar[str] = "table"
    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    right: frozenset[int]
    note: str
    printed: int = MAX_PRINTED
    rest: str = IN_THE_FILE


@dataclass(frozen=True)
class Chart:
    """A Plotly figure and, for those who cannot see it, its description.

    Attributes
    ----------
    name
        Identifier within the page.
    figure
        In the light theme.
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
    measures
        Similarity of both systems, in words.
    jpeg
        The picture.
    is_wide
        Whether it fills a row of its own.
    why_blank
        Why the boxes are drawn on an empty background; empty: they are drawn on the picture.
    boxes
        The pedestrians of the frame and what each costs; None: nobody is there.
    """

    title: str
    place: str
    text: str
    measures: str
    jpeg: bytes
    is_wide: bool = False
    why_blank: str = ""
    boxes: Table | None = None


@dataclass(frozen=True)
class Photos:
    """Frames, two in a row; the first `printed` on paper, three in a row."""

    kind: ClassVar[str] = "photos"
    photos: tuple[Photo, ...]
    printed: ClassVar[int] = 6


@dataclass(frozen=True)
class Fold:
    """Blocks that the screen shows at a click, and paper if they were unfolded before.

    Attributes
    ----------
    title
        What they are.
    where
        Where a reader of the paper finds them.
    """

    kind: ClassVar[str] = "fold"
    title: str
    blocks: tuple[Sentences | Table | Chart, ...]
    where: str = IN_THE_FILE


Block = Sentences | Topics | Table | Chart | Photos | Fold


@dataclass(frozen=True)
class Section:
    """A heading, its introduction, and its blocks."""

    anchor: str
    title: str
    intro: Intro | None
    blocks: tuple[Block, ...]


def true_minus(text: str) -> str:
    """The text with a minus for each hyphen that is the sign of a number, and in X - Y.

    Examples
    --------
    >>> true_minus("X - Y of nir-2: -0.2, -3e-05")
    'X − Y of nir-2: −0.2, −3e-05'
    """
    return _SIGN.sub(minus("-"), text).replace("X - Y", "X − Y")


def charts_of(blocks: Sequence[Block]) -> Iterator[Chart]:
    """The charts among the blocks, folded ones too."""
    for block in blocks:
        if isinstance(block, Fold):
            yield from charts_of(block.blocks)
        elif isinstance(block, Chart):
            yield block


def table(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    right: Sequence[int] = (),
    note: str = "",
    most: int = MAX_ROWS,
    printed: int = MAX_PRINTED,
    rest: str = IN_THE_FILE,
) -> Table:
    """A table of any values as text; invisible characters are shown as escapes.

    Parameters
    ----------
    right
        Columns of numbers: aligned to the right, with a minus for a hyphen before a digit.
    """
    notes = [note] if note else []
    if len(rows) > most:
        notes.append(f"The first {most:,} of {len(rows):,} rows are shown.")
    cells = tuple(
        tuple(_cell(cell, is_number=column in right) for column, cell in enumerate(row))
        for row in rows[:most]
    )
    text = shortened(" ".join(notes), MAX_NOTE)
    return Table(title, tuple(head), cells, frozenset(right), text, printed, rest)


def _cell(cell: object, *, is_number: bool) -> str:
    # a number and its unit stay on one line
    text = shortened(one_line(str(cell)), MAX_CELL).replace(" pp", "\N{NO-BREAK SPACE}pp")
    return true_minus(text) if is_number else text


@dataclass(frozen=True)
class SectionOf:
    """A section that a subject adds, after the encounters.

    Attributes
    ----------
    anchor
        Of the section; its numbers are of X and Y as set.
    make
        The section of a comparison.
    applies
        Whether a comparison has it.
    """

    anchor: str
    make: Callable[[Result], Section]
    applies: Callable[[Result], bool] = lambda _: True
