"""Sections of a report: notes, tables and figures for terminal, HTML report and pages.

A section is made of notes, tables whose cells are texts, and figures that are drawn only where
they can be shown. `Section.worded` renders its notes, and every medium draws the blocks in its own
way. Texts of blocks are plain text, which the medium escapes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import pandas as pd

from nvcore.common.wording import minus, number, one_line, shortened
from nvcore.comparison.compare import Result
from nvcore.notes import Note, has_form, say
from nvcore.settings.objects import Objects

if TYPE_CHECKING:
    import plotly.graph_objects as go

MAX_ROWS: Final = 200
"""Maximum number of rows of a table."""
MAX_PRINTED: Final = 12
"""Default maximum number of rows on paper."""
IN_THE_FILE: Final = "in the HTML file"
"""Location of the other rows for a reader of the paper."""
MAX_CELL: Final = 400
MAX_NOTE: Final = 3000
"""Maximum number of characters of a cell, and of the note below a table."""

_SIGN: Final = re.compile(r"(?<![\w.])-(?=\.?\d)")
"""The sign of a number, not that of an exponent or a hyphen in a name."""

Text = Note | str
"""A note, or plain text that is shown as it is."""
Row = Mapping[Any, Any]
Cell = str | Callable[[Row], object] | tuple[str | Callable[[Row], Any], str]
"""Content of a column: a text by name or function, or a number by name or function and format.

An empty format leaves the value as it is and aligns it to the right.
"""
Columns = dict[str, Cell]
"""Content of columns by their headings."""


@dataclass(frozen=True)
class Paragraphs:
    """Texts, each shown as a paragraph."""

    kind: ClassVar[str] = "paragraphs"
    texts: tuple[Text, ...]


@dataclass(frozen=True)
class Topics:
    """Pairs of a label and a text."""

    kind: ClassVar[str] = "topics"
    topics: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Table:
    """A table of texts, made by `table` or `listing`.

    Attributes
    ----------
    title
        Caption. Title and head are templates with words for the objects.
    head, rows
        Texts, as many in each row as in the head.
    right
        Indices of the columns that are aligned to the right: numbers.
    notes
        Texts below the table.
    printed
        Maximum number of rows on paper.
    rest
        Location of the other rows, after "12 more:".
    marks
        Footnote marks of the rows, such as "a c", which follow the first cell. Empty: no marks.
    hints
        Explanations of the rows, templates with words for the objects. Empty: no explanations.
    """

    kind: ClassVar[str] = "table"
    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    right: frozenset[int]
    notes: tuple[Text, ...] = ()
    printed: int = MAX_PRINTED
    rest: str = IN_THE_FILE
    marks: tuple[str, ...] = ()
    hints: tuple[str, ...] = ()

    @property
    def note(self) -> str:
        """Notes joined to one text, after they were rendered."""
        return shortened(" ".join(str(text) for text in self.notes), MAX_NOTE)


@dataclass(frozen=True)
class Chart:
    """Figure with a description for people who cannot see it.

    Attributes
    ----------
    name
        Identifier within the page.
    draw
        Return the figure in the light theme. The light core has no Plotly, so draw with
        ``nvcore.figures``, which is imported at first use.
    words
        Content of the figure, in one sentence.
    """

    kind: ClassVar[str] = "chart"
    name: str
    draw: Callable[[], go.Figure]
    words: str


@dataclass(frozen=True)
class Photo:
    """One frame with its boxes, as a picture with captions.

    Attributes
    ----------
    title
        Reason for showing the frame, in a few words.
    place
        Recording, frame and time.
    text
        Event in the frame.
    measures
        Similarity of both systems, in words.
    jpeg
        The picture.
    is_wide
        True if the picture fills a row of its own.
    why_blank
        Reason for an empty background. Empty if the boxes are drawn on a picture.
    boxes
        Pedestrians of the frame with what each costs. None if nobody is there.
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
    """Frames in rows of two on screen, three in print. Only the first `printed` are printed."""

    kind: ClassVar[str] = "photos"
    photos: tuple[Photo, ...]
    printed: ClassVar[int] = 6


@dataclass(frozen=True)
class Fold:
    """Blocks that unfold on a click. Print contains them only if they are unfolded.

    Attributes
    ----------
    title
        Label; a template with words for the objects.
    where
        Location of the blocks for a reader of the paper.
    """

    kind: ClassVar[str] = "fold"
    title: str
    blocks: tuple[Block, ...]
    where: str = IN_THE_FILE


Block = Paragraphs | Topics | Table | Chart | Photos | Fold


@dataclass(frozen=True)
class Section:
    """A heading, an introduction, and blocks.

    Attributes
    ----------
    anchor
        Identifier within the page.
    title
        Heading; a template with words for the objects.
    about
        Introduction. The form ``text`` describes the topic, ``best`` the good values, ``how`` the
        computation, and ``limits`` the limits of the numbers.
    """

    anchor: str
    title: str
    about: Note | None
    blocks: tuple[Block, ...]

    def worded(self, objects: Objects) -> WordedSection:
        """Render titles, notes and the introduction."""
        blocks = worded(self.blocks, objects)
        parts = {} if self.about is None else _parts(self.about, objects)
        return WordedSection(self.anchor, objects.say(self.title), parts, blocks)


@dataclass(frozen=True)
class WordedSection:
    """Section whose texts are plain strings. `about` contains the parts of the introduction."""

    anchor: str
    title: str
    about: Mapping[str, str]
    blocks: tuple[Block, ...]

    @property
    def in_short(self) -> str:
        """Summary of what the section shows and which values are good."""
        return " ".join(self.about[part] for part in ("text", "best") if part in self.about)

    @property
    def details(self) -> list[tuple[str, str]]:
        """Other parts of the introduction, each as a label and a text."""
        labels = {"how": "How it comes about", "limits": "What it does not say"}
        return [(label, self.about[part]) for part, label in labels.items() if part in self.about]


def _parts(about: Note, objects: Objects) -> dict[str, str]:
    forms = [form for form in ("text", "best", "how", "limits") if has_form(about, form)]
    return {form: say(about, objects, form) for form in forms}


def worded(blocks: Iterable[Block], objects: Objects) -> tuple[Block, ...]:
    """Render the titles and notes in blocks as plain strings."""
    return tuple(_worded(block, objects) for block in blocks)


def worded_texts(texts: Iterable[Text], objects: Objects) -> tuple[str, ...]:
    """Render the notes among texts as sentences."""
    return tuple(say(text, objects) if isinstance(text, Note) else text for text in texts)


def _worded(block: Block, objects: Objects) -> Block:
    if isinstance(block, Paragraphs):
        return Paragraphs(worded_texts(block.texts, objects))
    if isinstance(block, Table):
        head, hints = (tuple(map(objects.say, of)) for of in (block.head, block.hints))
        title, notes = objects.say(block.title), worded_texts(block.notes, objects)
        return replace(block, title=title, head=head, hints=hints, notes=notes)
    if isinstance(block, Fold):
        title = objects.say(block.title)
        return replace(block, title=title, blocks=worded(block.blocks, objects))
    return block


@dataclass(frozen=True)
class SectionOf:
    """A section that a subject adds to the report after the encounters.

    Attributes
    ----------
    anchor
        Identifier of the section. Its numbers are of X and Y as set.
    make
        Return the section of a comparison.
    applies
        Return whether a comparison has the section.
    """

    anchor: str
    make: Callable[[Result], Section]
    applies: Callable[[Result], bool] = lambda _: True


def about(key: str, result: Result, **values: Any) -> Note:
    """Return a section's introduction, with settings and the line styles of X and Y as values."""
    scheme = result.scheme("light")
    return Note(key, params=result.params, x=scheme.style("x"), y=scheme.style("y"), **values)


def charts_of(blocks: Sequence[Block]) -> Iterator[Chart]:
    """Yield the charts among the blocks, including folded ones."""
    for block in blocks:
        if isinstance(block, Fold):
            yield from charts_of(block.blocks)
        elif isinstance(block, Chart):
            yield block


def listing(
    title: str,
    rows: pd.DataFrame | Sequence[Row],
    columns: Columns,
    *,
    notes: Iterable[Text] = (),
    most: int = MAX_ROWS,
    printed: int = MAX_PRINTED,
    rest: str = IN_THE_FILE,
) -> Table:
    """Build a table from records. `columns` maps each heading to its content, see `Cell`.

    Examples
    --------
    >>> listing("Speeds", [{"who": "X", "v": 1.5}], {"System": "who", "m/s": ("v", ".2f")}).rows
    (('X', '1.50'),)
    """
    records = rows.to_dict("records") if isinstance(rows, pd.DataFrame) else rows
    right = [i for i, cell in enumerate(columns.values()) if isinstance(cell, tuple)]
    cells = [[_content(row, cell) for cell in columns.values()] for row in records]
    return table(
        title,
        tuple(columns),
        cells,
        right=right,
        notes=notes,
        most=most,
        printed=printed,
        rest=rest,
    )


def _content(row: Row, cell: Cell) -> object:
    source, form = cell if isinstance(cell, tuple) else (cell, "")
    value: Any = row[source] if isinstance(source, str) else source(row)
    return number(value, form) if form else value


def of_both(head: str, name: str, form: str | None = None) -> Columns:
    """Return two columns, for X and for Y, by replacing ``{}`` in heading and column name.

    Examples
    --------
    >>> of_both("Impact {} (km/h)", "impact_kmh_{}", ".0f")
    {'Impact X (km/h)': ('impact_kmh_x', '.0f'), 'Impact Y (km/h)': ('impact_kmh_y', '.0f')}
    """
    of: Columns = {}
    for letter in "xy":
        column = name.format(letter)
        of[head.format(letter.upper())] = spaced(column) if form is None else (column, form)
    return of


def spaced(name: str) -> Callable[[Row], str]:
    """Return a function that reads this column of a row, replacing underscores by spaces."""
    return lambda row: str(row[name]).replace("_", " ")


def table(
    title: str,
    head: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    right: Iterable[int] = (),
    notes: Iterable[Text] = (),
    most: int = MAX_ROWS,
    printed: int = MAX_PRINTED,
    rest: str = IN_THE_FILE,
) -> Table:
    """Build a table from values of any type, converted to text with invisible characters escaped.

    Parameters
    ----------
    right
        Indices of the columns of numbers.
    """
    if len(rows) > most:
        notes = [*notes, f"The first {most:,} of {len(rows):,} rows are shown."]
    cells = tuple(
        tuple(shortened(one_line(str(cell)), MAX_CELL) for cell in row) for row in rows[:most]
    )
    return Table(title, tuple(head), cells, frozenset(right), tuple(notes), printed, rest)


def true_minus(text: str) -> str:
    """Replace hyphens by minus signs in negative numbers and in "X - Y".

    Examples
    --------
    >>> true_minus("X - Y of nir-2: -0.2, -3e-05")
    'X − Y of nir-2: −0.2, −3e-05'
    """
    return _SIGN.sub(minus("-"), text).replace("X - Y", "X − Y")
