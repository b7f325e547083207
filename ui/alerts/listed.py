"""Alerts page: the alerts one by one, with the viewer beside."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.alerts.kinds import ALERT_TEXT, AlertKind
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.wording import capitalised
from ui.session import state, store
from ui.widgets import compared_viewer
from ui.widgets.choices import choose_side_by_side, download_csv, draw_steps
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.table_columns import MOST_ROWS, rows_told

VIEWER: Final = "alerts_viewer"
VIEWER_PX: Final = 460
COLUMNS: Final = {
    "system": TableColumn("", "Whose alert it is, X or Y.", is_head=True),
    "recording": TableColumn("Recording"),
    "start_s": TableColumn("Start (s)", "When it begins.", ".2f"),
    "kind": TableColumn("Kind", "What it was worth."),
    "encounter": TableColumn("{One}", "Whom it is about; –: {nobody}.", is_number=True),
    "lead_s": TableColumn(
        "Lead (s)",
        "From the first alert about an urgent {one} to the last chance to brake; 0 or less is too "
        "late.",
        "+.2f",
    ),
}


def draw(result: Result) -> None:
    """The alerts of X, Y or both, of all kinds or one; the chosen one in the viewer."""
    st.header("One by one")
    table = alerts_in(result).table.assign(row=_first_rows(result))
    with st.container(horizontal=True, vertical_alignment="bottom"):
        whose = choose_side_by_side(
            "Of", {"xy": "X and Y", "x": "X", "y": "Y"}, "alerts_of", default="xy"
        )
        table = table[[letter in whose for letter in table["system"]]]
        counts = table["kind"].value_counts()
        kinds = {"": f"all ({len(table)})"} | {
            kind.value: f"{kind.value} ({counts[kind.value]})"
            for kind in AlertKind
            if kind.value in counts
        }
        chosen = store.widget("alerts_kind")
        if chosen.get() not in kinds:
            chosen.set("")
        kind = choose_side_by_side("Kind", kinds, "alerts_kind")
    if kind:
        table = table[table["kind"] == kind]
        st.caption(capitalised(state.say(ALERT_TEXT[AlertKind(kind)])))
    if table.empty:
        st.info("There is no such alert: nothing would have reached the driver.")
        return
    _draw_moving(result, table.head(MOST_ROWS))
    if told := rows_told(len(table), "first"):
        st.caption(told)
    download_csv("alerts.csv", lambda: alerts_in(result).table, "alerts.csv", "alerts_csv")


def _first_rows(result: Result) -> np.ndarray:
    """Frame row in which each alert of the table begins."""
    view = alerts_in(result)
    return np.concatenate([view.of(system)["first_row"].to_numpy() for _, system in result.sides])


@st.fragment
def _draw_moving(result: Result, table: pd.DataFrame) -> None:
    rows = table["row"].tolist()
    at = min(store.ALERT_AT.get(), len(rows) - 1)
    left, right = st.columns(2, gap="medium")
    with left:
        draw_steps(at, len(rows), partial(_go_to, rows), key="alerts")
        is_one = len(state.recording_names()) < 2
        columns = {
            name: replace(column, label=state.say(column.label), help=state.say(column.help))
            for name, column in COLUMNS.items()
            if not (is_one and name == "recording")
        }
        draw_table(
            table.assign(system=table["system"].str.upper()),
            columns,
            key="alerts_list",
            name="Alerts, those of X first",
            on_click=lambda row, _column: _go_to(rows, row),
            most_lines=14,
            selected=at if at >= 0 else None,
        )
    with right:
        if at < 0:
            st.caption(
                "Click an alert to see the frame in which it begins; n and p go on and back."
            )
        settled = compared_viewer.settled(VIEWER)
        if settled != state.row():
            state.settle(state.recording(), settled)
        encounter = _encounter(result, table, at)
        compared_viewer.draw(result, VIEWER, height_px=VIEWER_PX, encounter=encounter)


def _go_to(rows: list[int], at: int) -> None:
    """Show the frame in which an alert begins. For callbacks."""
    store.ALERT_AT.set(at)
    state.go_to(*state.place_of(rows[at]))


def _encounter(result: Result, table: pd.DataFrame, at: int) -> int | None:
    """Row in ``result.encounters`` of whom the chosen alert is about."""
    if at < 0:
        return None
    index = int(table.index[at])
    of_x = len(alerts_in(result).of(result.x))
    system, place = (result.x, index) if index < of_x else (result.y, index - of_x)
    encounter = int(alerts_in(result).of(system)["encounter"].iloc[place])
    return encounter if encounter >= 0 else None
