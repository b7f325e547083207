"""Tables of measures as HTML: whole at any width, selectable, and read aloud row by row."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from nvcore.measures.entry import Better
from nvcore.measures.table import measure_of
from nvcore.params import SETTINGS
from nvcore.tables.scorecard import ScoreRow
from nvcore.wording import (
    ARROWS,
    difference,
    minus,
    number,
    one_line,
    rounded_form,
)
from ui.session import state

MEANS_LITTLE: Final = " *"
"""Mark of a measure that means little where most encounters are one frame long."""
HEAD: Final = ("X", "Y", "X − Y")
SHORTER: Final = {".4f": ".3f"}
"""Formats of values whose interval is not known."""


@dataclass(frozen=True)
class MeasureRow:
    """One row of a table of measures.

    Attributes
    ----------
    label
        Name of the measure, as plain text like all else.
    cells
        Its values, as many in each row.
    better
        Whose value is better, ``x`` or ``y``: the first or the second cell is marked.
    level
        1 for a part of the row above.
    marks
        Footnotes, such as ``a b``.
    hint
        What the measure is, shown when the mouse is over its name.
    lines
        CSS borders that stand before the name as samples of the lines of systems.
    colours
        Of the two systems of this row, where they are not X and Y; else empty.
    key, form
        Of the measure, and the format of its values, where the first cells are its X, Y and
        X - Y: the browser writes them anew while a slider moves. Else empty.
    is_marked
        Whether it then marks the better value, too.
    """

    label: str
    cells: tuple[str, ...]
    better: str = ""
    level: int = 0
    marks: str = ""
    hint: str = ""
    lines: tuple[str, ...] = ()
    colours: tuple[str, ...] = ()
    key: str = ""
    form: str = ""
    is_marked: bool = False


def value_hooks(key: str, form: str, *, is_marked: bool) -> str:
    """Attributes of a row or a tile by which the browser finds a measure."""
    better = f' data-better="{measure_of(key).better}"' if is_marked else ""
    return f' data-measure="{escape(key, quote=True)}" data-form="{form}"{better}'


def stamp_html() -> str:
    """Of which settings numbers are, for the browser: it says so while a slider shows others."""
    params = state.params()
    values = {name: getattr(params, name) for name in SETTINGS}
    numbers = {name: value for name, value in values.items() if isinstance(value, float)}
    return f'<p class="nv-of" data-of="{escape(json.dumps(numbers), quote=True)}"></p>'


def with_arrow(label: str, better: Better | str) -> str:
    """The label, and which way is better."""
    return label + ARROWS[better]


def score_row(row: ScoreRow, *, width: float = math.nan, is_short: bool = False) -> MeasureRow:
    """A row of the scorecard.

    Parameters
    ----------
    width
        Of the difference's 95 % interval: decimals below it are left out; NaN: none is known.
    is_short
        Whether most encounters are one frame long.
    """
    form = SHORTER.get(row.form, row.form) if math.isnan(width) else rounded_form(row.form, width)
    values = tuple(number(value, form) for value in (row.x, row.y))
    return MeasureRow(
        label=with_arrow(row.label, row.better)
        + (MEANS_LITTLE if row.needs_tracks and is_short else ""),
        cells=(*values, minus(difference(row.x, row.y, form))),
        better=row._replace(form=form).winner,
        level=row.level,
        hint=state.say(measure_of(row.key).meaning) if row.key else "",
        key=row.key,
        form=form,
        is_marked=not row.is_doubtful,
    )


def measures_html(
    rows: Sequence[MeasureRow],
    *,
    key: str,
    head: Sequence[str] = HEAD,
    first: str = "Measure",
    note: str = "",
) -> str:
    """The table as HTML; its class is `key`. A note stands below it."""
    heads = "".join(f'<th scope="col">{_text(cell)}</th>' for cell in head)
    body = "".join(_row(row) for row in rows)
    below = f'<p class="nv-note">{_text(note)}</p>' if note else ""
    return (
        f'<div class="nv-wide">{stamp_html()}<table class="nv-measures nv-{key}">'
        f'<thead><tr><th scope="col">{_text(first)}</th>{heads}</tr></thead>'
        f"<tbody>{body}</tbody></table>{below}</div>"
    )


def _row(row: MeasureRow) -> str:
    marks = f"<sup>{_text(row.marks)}</sup>" if row.marks else ""
    level = ' class="part"' if row.level else ""
    hint = f' title="{_text(row.hint)}"' if row.hint else ""
    cells = "".join(
        f'<td class="{letter}{" better" if row.better == letter else ""}">{_text(cell)}</td>'
        if letter
        else f"<td>{_text(cell)}</td>"
        for cell, letter in zip(row.cells, ("x", "y", *[""] * len(row.cells)), strict=False)
    )
    lines = "".join(f'<span class="line" style="border-top:{line}"></span>' for line in row.lines)
    named = zip("xy", row.colours, strict=False)
    style = "".join(f"--nv-{letter}:{colour};" for letter, colour in named)
    own = f' style="{style}"' if style else ""
    head = f'<th scope="row"{level}{hint}>{lines}{_text(row.label)}{marks}</th>'
    hooks = value_hooks(row.key, row.form, is_marked=row.is_marked) if row.key else ""
    return f"<tr{own}{hooks}>{head}{cells}</tr>"


def _text(text: str) -> str:
    return escape(one_line(text))
