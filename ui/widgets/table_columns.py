"""Columns of the report's tables for `st.dataframe`: headings, formats, help texts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import pandas as pd
import streamlit as st
from pandas.api.types import is_bool_dtype

from nvcore.figures.encounters import CLASS_WORDS
from nvcore.figures.venn import WORDS
from nvcore.tables.column import Column, Kind
from nvcore.tables.columns import report_columns
from nvcore.tables.scorecard import ScoreRow
from nvcore.wording import ARROWS, difference, minus, number
from ui.session import state
from ui.subjects import ColumnLook, contributed
from ui.widgets.html import HEAD

CATEGORY_WORDS: Final = {kind.value: text for kind, text in WORDS.items()}
MISS_WORDS: Final = {kind.value: text for kind, text in CLASS_WORDS.items()}
YES_NO: Final = {True: "yes", False: "no"}
SIGNED: Final = "%+.2f"
WHOLE: Final = "%.0f"
LOOKS: Final[dict[str, ColumnLook]] = {
    "recording": ColumnLook(width=124),
    "track": ColumnLook("{One}", 80),
    "category": ColumnLook(width=72, words=CATEGORY_WORDS.get),
    "n_relevant": ColumnLook("Frames that count"),
    "n_frames": ColumnLook("Annotated frames"),
    "miss_class": ColumnLook("miss class", 90, words=MISS_WORDS.get),
    "coverage": ColumnLook(width=85, is_share=True),
    "lag_s": ColumnLook("lag (s)"),
    "gap_s": ColumnLook("gap (s)"),
    "tail_s": ColumnLook("tail (s)"),
    "severity_s": ColumnLook("severity (s)", 88),
    "peak_cost": ColumnLook(width=88),
    "lead_time_s": ColumnLook("Lead of X (s)", 92, SIGNED),
    "peak_height": ColumnLook("Height (px)", 82, WHOLE),
    "lateral_position": ColumnLook("Position", 70, SIGNED),
    "peak_k": ColumnLook("Largest k"),
    "aspect_ratio": ColumnLook("Height / width"),
    "aspect_z": ColumnLook("Pose z-score", form=SIGNED),
    "occluded_share": ColumnLook("Occluded", is_share=True),
    "start_s": ColumnLook("Start (s)"),
    "duration_s": ColumnLook("Duration (s)"),
    "tau": ColumnLook("Ends at", is_share=True),
    "relevant_s": ColumnLook("Counts (s)"),
    "weight_s": ColumnLook("Weight (s)"),
    "rest_s": ColumnLook("Rest (s)"),
    "saliency_s": ColumnLook("Saliency (s)"),
    **{name: look for looks in contributed("COLUMN_LOOKS") for name, look in looks.items()},
}
"""Of columns that do not look as their name and kind say; X and Y alike."""
MOST_ROWS: Final = 5000
"""Rows of a table that are sent to the browser; more would slow down every change."""
LINE_PX: Final = 33
"""Height of a row, and of the heading: Streamlit's 2.1875 of our `theme.baseFontSize`."""
BORDERS_PX: Final = 2
MOST_LINES: Final = 10


def heading(name: str) -> str:
    """Heading of a column, "X lag (s)" for ``lag_s_x``."""
    base, letter = _split(name)
    words = state.say(LOOKS.get(base, ColumnLook()).heading or base.replace("_", " "))
    return f"{letter.upper()} {words}" if letter else words[0].upper() + words[1:]


def column_config(file: str) -> dict[str, Any]:
    """Settings of all columns of a report's file, for `st.dataframe`."""
    return {column.name: _config(column) for column in report_columns()[file]}


def as_shown(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of a report's table for `column_config`: shares in percent, what is named in words.

    Truth values are "yes" and "no": a box that is empty is not told from a cell that is.
    """
    configs = {}
    for name in table:
        base, _ = _split(str(name))
        look = LOOKS.get(base, ColumnLook())
        if look.is_share:
            configs[str(name)] = 100 * table[name]
        elif look.words is not None:
            configs[str(name)] = table[name].map(look.words, na_action="ignore")
        elif is_bool_dtype(table[name]):
            configs[str(name)] = table[name].map(YES_NO, na_action="ignore").astype(object)
    return table.assign(**configs)


def measures_as_text(rows: Sequence[ScoreRow]) -> pd.DataFrame:
    """Measures of X beside those of Y as text, as each has a format of its own."""
    return pd.DataFrame(
        [
            (
                "    " * row.level + row.label + ARROWS[row.better],
                number(row.x, row.form),
                number(row.y, row.form),
                minus(difference(row.x, row.y, row.form)),
            )
            for row in rows
        ],
        columns=["measure", *HEAD],
    )


def rows_told(n_rows: int, which: str) -> str:
    """A note for a table that lists only some rows, the "first" or the like; else empty."""
    if n_rows <= MOST_ROWS:
        return ""
    return f"The {which} {MOST_ROWS:,} of {n_rows:,} are listed; Export has them all."


def table_height(n_rows: int) -> int:
    """Height of a table with its heading that shows up to ten rows, px."""
    return LINE_PX * (min(max(n_rows, 1), MOST_LINES) + 1) + BORDERS_PX


def category_words(value: str) -> str:
    """A Venn category in words."""
    return CATEGORY_WORDS[value]


def class_words(value: object) -> str | None:
    """A miss class in words; None where there is none."""
    return MISS_WORDS[value] if isinstance(value, str) else None


def _split(name: str) -> tuple[str, str]:
    is_of_system = name.endswith(("_x", "_y"))
    return (name[:-2], name[-1]) if is_of_system else (name, "")


def _config(column: Column) -> Any:
    base, _ = _split(column.name)
    text = column.meaning + (f" Empty: {column.empty}." if column.empty else "")
    if column.better:
        text += " Higher is better." if column.better == "high" else " Lower is better."
    label, text = heading(column.name), state.say(text)
    look = LOOKS.get(base, ColumnLook())
    pinned, width = column.name in ("recording", "track"), look.width
    if column.kind is Kind.TRUTH_VALUE:
        return st.column_config.TextColumn(label, width=width, help=text)
    if column.kind is Kind.TEXT:
        return st.column_config.TextColumn(label, width=width, help=text, pinned=pinned)
    form = "%d" if column.kind is Kind.INTEGER else "%.0f %%" if look.is_share else look.form
    return st.column_config.NumberColumn(label, width=width, help=text, pinned=pinned, format=form)
