"""Time left page: the urgent encounters as a list."""

from __future__ import annotations

from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from ui.session import state
from ui.widgets.clicks import clicked_row
from ui.widgets.table_columns import MOST_ROWS, as_shown, column_config, rows_told, table_height
from ui.widgets.text import UNDEFINED

OPEN: Final = "time_left_open"
"""Encounter and frame row that were clicked in the list."""
TTC: Final = "ttc_s"
COLUMNS: Final = (
    *("recording", "track", "urgent_frame", TTC),
    *("time_left_x", "time_left_y", "margin_s_x", "margin_s_y", "impact_kmh_x", "impact_kmh_y"),
)


def take_opened() -> tuple[int, int] | None:
    """Encounter and frame row of the latest click in the list; None: there was none."""
    opened: tuple[int, int] | None = st.session_state.pop(OPEN, None)
    return opened


def draw(urgent: pd.DataFrame) -> None:
    """The fastest impact first; a click opens the last chance."""
    shown = urgent.head(MOST_ROWS)
    places = list(zip(shown.index.tolist(), shown["urgent_row"].tolist(), strict=True))
    key = f"time_left_list_{hash(tuple(places))}"
    first = COLUMNS if len(state.recording_names()) > 1 else COLUMNS[1:]
    meaning = "Time to contact at the last chance, s."
    config = column_config("encounters.csv") | {
        TTC: st.column_config.NumberColumn("Contact in (s)", help=meaning, format="%.2f", width=92)
    }
    st.dataframe(
        as_shown(shown[list(COLUMNS)]),
        hide_index=True,
        column_config=config,
        column_order=first,
        height=table_height(len(shown)),
        key=key,
        placeholder=UNDEFINED,
        selection_mode=("single-row", "single-cell"),
        on_select=partial(_ask, key, places),
    )
    st.caption(
        "Click a row to open its last chance in the Timeline. All of them, and why others are not "
        "urgent, are in `encounters.csv` on the page Export. "
        f"{rows_told(len(urgent), 'fastest')}".strip()
    )


def _ask(key: str, places: list[tuple[int, int]]) -> None:
    row = clicked_row(key)
    if row is not None:
        st.session_state[OPEN] = places[row]
