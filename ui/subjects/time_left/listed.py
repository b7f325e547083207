"""Time left page: list of urgent encounters, with links to moments in the Timeline."""

from __future__ import annotations

from functools import partial
from typing import Final, NoReturn

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from ui.session import state, store
from ui.session.chosen import choose_encounter
from ui.shell.navigate import open_row
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.table_columns import MOST_ROWS, as_shown, columns_of, rows_told

TTC: Final = "ttc_s"
COLUMNS: Final = (
    *("recording", "track", "urgent_frame", TTC),
    *("time_left_x", "time_left_y", "margin_s_x", "margin_s_y", "impact_kmh_x", "impact_kmh_y"),
)


def draw(urgent: pd.DataFrame) -> None:
    """Draw the list, fastest impact first. A click opens the last chance."""
    shown = urgent.head(MOST_ROWS)
    places = list(zip(shown.index.tolist(), shown["urgent_row"].tolist(), strict=True))
    first = COLUMNS if len(state.recording_names()) > 1 else COLUMNS[1:]
    of_ttc = TableColumn("Time to contact (s)", "Time to contact at the last chance, s.", ".2f")
    of_file = columns_of("encounters.csv", *(name for name in first if name != TTC))
    draw_table(
        as_shown(shown),
        {name: of_file.get(name, of_ttc) for name in first},
        key="time_left_list",
        name="Urgent encounters, the fastest impact first",
        on_click=partial(_ask, places),
    )
    st.caption(
        "Click a row to open its last chance in the Timeline. All of them, and why others are not "
        "urgent, are in `encounters.csv` on the page Export. "
        f"{rows_told(len(urgent), 'fastest')}".strip()
    )


def _ask(places: list[tuple[int, int]], row: int, _column: str) -> None:
    store.URGENT_ENCOUNTER.set(places[row])


def open_encounter(result: Result, encounter: int, row: int) -> NoReturn:
    """Show a frame of an encounter on the Timeline, with its lane marked."""
    choose_encounter(result, encounter)
    open_row(row)
