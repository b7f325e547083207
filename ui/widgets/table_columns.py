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
from nvcore.tables.columns import REPORT_COLUMNS
from nvcore.tables.scorecard import ScoreRow
from nvcore.wording import ARROWS, difference, minus, number
from ui.session import state
from ui.widgets.html import HEAD

HEADINGS: Final = {
    "track": "Pedestrian",
    "n_relevant": "Frames that count",
    "n_frames": "Annotated frames",
    "miss_class": "miss class",
    "lag_s": "lag (s)",
    "gap_s": "gap (s)",
    "tail_s": "tail (s)",
    "severity_s": "severity (s)",
    "time_left": "confirms",
    "margin_s": "margin (s)",
    "impact_kmh": "impact (km/h)",
    "confirmed_frame": "confirmed in frame",
    "detectability_sd": "SD",
    "within_sd": "Open",
    "driver_seen_frames": "Frames seen",
    "driver_frame": "Driver sees in frame",
    "min_ttc_s": "Least to contact (s)",
    "urgent_frame": "Last chance",
    "lead_time_s": "Lead of X (s)",
    "peak_height": "Height (px)",
    "lateral_position": "Position",
    "peak_k": "Largest k",
    "aspect_ratio": "Height / width",
    "aspect_z": "Pose z-score",
    "occluded_share": "Occluded",
    "start_s": "Start (s)",
    "duration_s": "Duration (s)",
    "tau": "Ends at",
    "relevant_s": "Counts (s)",
    "weight_s": "Weight (s)",
    "rest_s": "Rest (s)",
    "saliency_s": "Saliency (s)",
}
"""Headings that do not follow from the column's name."""

PERCENT: Final = frozenset({"coverage", "occluded_share", "tau"})
SIGNED: Final = frozenset({"lead_time_s", "margin_s", "lateral_position", "aspect_z"})
WHOLE: Final = frozenset({"peak_height", "impact_kmh"})
CATEGORY_WORDS: Final = {kind.value: text for kind, text in WORDS.items()}
MISS_WORDS: Final = {kind.value: text for kind, text in CLASS_WORDS.items()}
YES_NO: Final = {True: "yes", False: "no"}
WIDTHS: Final = {
    "recording": 124,
    "track": 80,
    "category": 72,
    "miss_class": 90,
    "coverage": 85,
    "detectability_sd": 52,
    "within_sd": 56,
    "driver_sees": 88,
    "driver_seen_frames": 92,
    "driver_in_time": 98,
    "severity_s": 88,
    "peak_cost": 88,
    "lead_time_s": 92,
    "peak_height": 82,
    "lateral_position": 70,
    "urgent_frame": 88,
    "time_left": 76,
    "margin_s": 84,
    "impact_kmh": 100,
}
"""Of columns that stand side by side in a window of 1280, px; the others are as wide as needed."""
MOST_ROWS: Final = 5000
"""Rows of a table that are sent to the browser; more would slow down every change."""
LINE_PX: Final = 33
"""Height of a row, and of the heading: Streamlit's 2.1875 of our `theme.baseFontSize`."""
BORDERS_PX: Final = 2
MOST_LINES: Final = 10


def heading(name: str) -> str:
    """Heading of a column, "X lag (s)" for ``lag_s_x``."""
    base, letter = _split(name)
    words = state.words(HEADINGS.get(base, base.replace("_", " ")))
    return f"{letter.upper()} {words}" if letter else words[0].upper() + words[1:]


def column_config(file: str) -> dict[str, Any]:
    """Settings of all columns of a report's file, for `st.dataframe`."""
    return {column.name: _config(column) for column in REPORT_COLUMNS[file]}


def as_shown(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of a report's table for `column_config`: shares in percent, what is named in words.

    Truth values are "yes" and "no": a box that is empty is not told from a cell that is.
    """
    configs = {}
    for name in table:
        base, _ = _split(str(name))
        if base in PERCENT:
            configs[str(name)] = 100 * table[name]
        elif base in ("category", "miss_class"):
            configs[str(name)] = table[name].map(
                MISS_WORDS if base == "miss_class" else CATEGORY_WORDS
            )
        elif is_bool_dtype(table[name]):
            configs[str(name)] = table[name].map(YES_NO, na_action="ignore").astype(object)
        elif base in ("time_left", "urgency"):
            configs[str(name)] = table[name].str.replace("_", " ")
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
    label, text = heading(column.name), state.words(text)
    pinned, width = column.name in ("recording", "track"), WIDTHS.get(base)
    if column.kind is Kind.TRUTH_VALUE:
        return st.column_config.TextColumn(label, width=width, help=text)
    if column.kind is Kind.TEXT:
        return st.column_config.TextColumn(label, width=width, help=text, pinned=pinned)
    if column.kind is Kind.INTEGER:
        form = "%d"
    elif base in PERCENT:
        form = "%.0f %%"
    else:
        form = "%+.2f" if base in SIGNED else "%.0f" if base in WHOLE else "%.2f"
    return st.column_config.NumberColumn(label, width=width, help=text, pinned=pinned, format=form)
