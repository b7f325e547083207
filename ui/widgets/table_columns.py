"""Columns of report tables on pages: headings, formats, help texts."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import Final

import pandas as pd
from pandas.api.types import is_bool_dtype

from nvcore.dataset.schema import CATEGORY_WORDS as WORDS
from nvcore.figures.encounters import CLASS_WORDS
from nvcore.tables.column import CellKind, Column
from nvcore.tables.columns import report_columns
from ui.session import state
from ui.subject import ColumnLook, subject_pages
from ui.widgets.table import TableColumn

CATEGORY_WORDS: Final = {kind.value: text for kind, text in WORDS.items()}
MISS_WORDS: Final = {kind.value: text for kind, text in CLASS_WORDS.items()}
YES_NO: Final = {True: "yes", False: "no"}
SIGNED: Final = "+.2f"
WHOLE: Final = ".0f"
LOOKS: Final[dict[str, ColumnLook]] = {
    "track": ColumnLook("{One}"),
    "category": ColumnLook(words=CATEGORY_WORDS.get),
    "n_relevant": ColumnLook("Frames that count"),
    "n_frames": ColumnLook("Annotated frames"),
    "miss_class": ColumnLook("miss class", words=MISS_WORDS.get),
    "coverage": ColumnLook(is_share=True),
    "lag_s": ColumnLook("lag (s)"),
    "gap_s": ColumnLook("gap (s)"),
    "tail_s": ColumnLook("tail (s)"),
    "severity_s": ColumnLook("severity (s)"),
    "lead_time_s": ColumnLook("Lead of X (s)", SIGNED),
    "peak_height": ColumnLook("Height (px)", WHOLE),
    "lateral_position": ColumnLook("Position", SIGNED),
    "peak_k": ColumnLook("Largest k"),
    "aspect_ratio": ColumnLook("Height / width"),
    "aspect_z": ColumnLook("Pose z-score", SIGNED),
    "occluded_share": ColumnLook("Occluded", is_share=True),
    "start_s": ColumnLook("Start (s)"),
    "duration_s": ColumnLook("Duration (s)"),
    "tau": ColumnLook("Ends at", is_share=True),
    "relevant_s": ColumnLook("Counts (s)"),
    "weight_s": ColumnLook("Weight (s)"),
    "rest_s": ColumnLook("Rest (s)"),
    "saliency_s": ColumnLook("Saliency (s)"),
    **dict(chain(*(subject.column_looks.items() for subject in subject_pages()))),
}
"""Formats of columns that differ from the default for name and kind, without system letter."""
MOST_ROWS: Final = 5000
"""Maximum number of rows sent to the browser. More would slow down every change."""


def heading(name: str) -> str:
    """Return a column's heading, such as "X lag (s)" for ``lag_s_x``."""
    base, letter = _split(name)
    words = state.say(LOOKS.get(base, ColumnLook()).heading or base.replace("_", " "))
    return f"{letter.upper()} {words}" if letter else words[0].upper() + words[1:]


def columns_of(file: str | Sequence[Column], *names: str) -> dict[str, TableColumn]:
    """Return the columns of a report's file for `draw_table`. Without names: all columns.

    Parameters
    ----------
    file
        Name of the file, or columns of another one.
    """
    known = report_columns()[file] if isinstance(file, str) else file
    columns = {column.name: column for column in known}
    return {name: _column(columns[name]) for name in names or columns}


def as_shown(table: pd.DataFrame) -> pd.DataFrame:
    """Convert values of a report's table to words, for use with `columns_of`.

    Booleans are "yes" and "no".
    """
    worded = {}
    for name in table:
        base, _ = _split(str(name))
        look = LOOKS.get(base, ColumnLook())
        if look.words is not None:
            worded[str(name)] = table[name].map(look.words, na_action="ignore")
        elif is_bool_dtype(table[name]):
            worded[str(name)] = table[name].map(YES_NO, na_action="ignore").astype(object)
    return table.assign(**worded)


def rows_told(n_rows: int, which: str) -> str:
    """Return a note if a table shows only some of its rows, such as the "first", else ""."""
    if n_rows <= MOST_ROWS:
        return ""
    return f"The {which} {MOST_ROWS:,} of {n_rows:,} are listed; Export has them all."


def category_words(value: str) -> str:
    """Return a Venn category in words."""
    return CATEGORY_WORDS[value]


def class_words(value: object) -> str | None:
    """Return a miss class in words, or None if there is none."""
    return MISS_WORDS[value] if isinstance(value, str) else None


def _split(name: str) -> tuple[str, str]:
    is_of_system = name.endswith(("_x", "_y"))
    return (name[:-2], name[-1]) if is_of_system else (name, "")


def _column(column: Column) -> TableColumn:
    base, _ = _split(column.name)
    text = column.meaning + (f" Empty: {column.empty}." if column.empty else "")
    if column.better:
        text += " Higher is better." if column.better == "high" else " Lower is better."
    look = LOOKS.get(base, ColumnLook())
    form = ".0%" if look.is_share else look.form
    return TableColumn(
        heading(column.name),
        state.say(text),
        form=form if column.kind is CellKind.NUMBER else "",
        is_head=column.name in ("recording", "track"),
    )
