"""Tables of measures as HTML: complete at any width, selectable, and accessible row by row."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Final

from nvcore.common.wording import ARROWS, difference, minus, number, one_line, rounded_form
from nvcore.comparison.measures.entry import Better
from nvcore.comparison.measures.table import measure_of
from nvcore.settings.params import SETTINGS
from nvcore.tables.scorecard import ScoreRow
from ui.session import state

MEANS_LITTLE: Final = " *"
"""Mark of a measure that means little if most encounters are one frame long."""
HEAD: Final = ("X", "Y", "X − Y")
SHORTER: Final = {".4f": ".3f"}
"""Formats of values without a known interval."""


@dataclass(frozen=True)
class MeasureRow:
    """Row of a table of measures.

    Attributes
    ----------
    label
        Name of the measure. All texts are plain.
    cells
        Values of the measure. All rows have the same number of cells.
    better
        System with the better value, ``x`` or ``y``, whose cell (first or second) is marked.
    level
        1 for a component of the row above.
    marks
        Footnotes, such as ``a b``.
    hint
        Description of the measure, shown while the mouse is over its name.
    lines
        CSS borders before the name as samples of the systems' lines.
    colours
        Colours of the two systems of this row if they are not X and Y, else empty.
    key, form
        Key of the measure and format of its values, if the first cells are its X, Y and X - Y. The
        browser then updates them while a slider moves. Empty otherwise.
    is_marked
        Whether the browser also marks the better value.
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
    """Return the HTML attributes by which the browser finds a measure's row or tile."""
    better = f' data-better="{measure_of(key).better}"' if is_marked else ""
    return f' data-measure="{escape(key, quote=True)}" data-form="{form}"{better}'


def stamp_html() -> str:
    """Return an element that tells the browser which settings the numbers belong to."""
    params = state.params()
    values = {name: getattr(params, name) for name in SETTINGS}
    numbers = {name: value for name, value in values.items() if isinstance(value, float)}
    return f'<p class="nv-of" data-of="{escape(json.dumps(numbers), quote=True)}"></p>'


def with_arrow(label: str, better: Better | str) -> str:
    """Return the label with an arrow in the better direction."""
    return label + ARROWS[better]


def score_row(row: ScoreRow, *, width: float = math.nan, is_short: bool = False) -> MeasureRow:
    """Return a row of the scorecard.

    Parameters
    ----------
    width
        Width of the difference's 95 % interval, which limits the decimals. NaN: unknown.
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
    """Return the table as HTML with `key` as its class, and a note below."""
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
