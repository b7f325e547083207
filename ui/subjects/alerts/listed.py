"""Alerts page: a list of alerts to step through, beside the viewer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import capitalised
from nvcore.comparison.compare import Result
from nvcore.subjects.alerts.episodes import ALERT_TEXT, UNWANTED, AlertKind
from nvcore.subjects.alerts.steps import alerts_in
from ui.session import state, store
from ui.shell.navigate import open_page
from ui.widgets import compared_viewer
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side, download_csv, draw_steps
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.table_columns import MOST_ROWS, rows_told

VIEWER_PX: Final = 460
COLUMNS: Final = {
    "system": TableColumn("System", "Whose alert it is, X or Y.", is_head=True),
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
    """Draw a list of alerts, unwanted ones first, with the selected one in the viewer."""
    st.header("One by one")
    view = alerts_in(result)
    alerts = pd.concat([view.of(system) for _, system in result.sides], ignore_index=True)
    table = view.table.assign(row=alerts["first_row"], encounter_row=alerts["encounter"])
    with st.container(horizontal=True, vertical_alignment="bottom"):
        whose = choose_side_by_side(
            "Of", {"xy": "X and Y", "x": "X", "y": "Y"}, "alerts_of", default="xy"
        )
        table = table[table["system"].isin([*whose])]
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
    is_wanted = ~table["kind"].isin([each.value for each in UNWANTED])
    table = table.iloc[np.argsort(is_wanted.to_numpy(), kind="stable")]
    if kind:
        table = table[table["kind"] == kind]
        st.caption(capitalised(state.say(ALERT_TEXT[AlertKind(kind)])))
    if table.empty:
        st.info("There is no such alert: nothing would have reached the driver.")
        return
    shown = table.head(MOST_ROWS)
    draw_beside_viewer(
        result,
        shown.assign(system=shown["system"].str.upper()),
        COLUMNS,
        key="alerts",
        name="Alerts, unwanted ones first",
    )
    if told := rows_told(len(table), "first"):
        st.caption(told)
    with st.container(horizontal=True):
        download_csv("alerts.csv", lambda: view.table, "alerts.csv", "alerts_csv")
        if result.dataset.objects.is_on_road and button(
            "Ask people whether these were worth it",
            key="alerts_ask",
            icon=":material/how_to_vote:",
        ):
            store.RATINGS_PART.set("session")
            store.RATING_ALERTS.set("these")
            if state.params().alerts == "off":  # alerts are then shown on this page only
                state.set_params(alerts="policy")
            open_page("ratings")


@st.fragment
def draw_beside_viewer(
    result: Result, table: pd.DataFrame, columns: Mapping[str, TableColumn], *, key: str, name: str
) -> None:
    """Draw a table beside the viewer. The viewer shows the selected row.

    Parameters
    ----------
    table
        Its column ``row`` holds the frame row in which an entry begins, and ``encounter_row`` the
        row of its encounter in ``result.encounters`` (-1: none).
    """
    rows, entry = table["row"].tolist(), store.ALERT_AT.of(key)
    at = min(entry.get(), len(rows) - 1)
    left, right = st.columns(2, gap="medium")
    with left:
        draw_steps(at, len(rows), partial(_go_to, entry, rows), key=key)
        draw_table(
            table,
            {
                name: replace(column, label=state.say(column.label), help=state.say(column.help))
                for name, column in columns.items()
                if name != "recording" or len(state.recording_names()) > 1
            },
            key=f"{key}_list",
            name=name,
            on_click=lambda row, _column: _go_to(entry, rows, row),
            most_lines=14,
            selected=at if at >= 0 else None,
        )
    with right:
        if at < 0:
            st.caption("Click a row to see the frame in which it begins; n and p go on and back.")
        viewer = f"{key}_viewer"
        settled = compared_viewer.settled(viewer)
        if settled != state.row():
            state.settle(state.recording(), settled)
        encounter = -1 if at < 0 else int(table["encounter_row"].iloc[at])
        compared_viewer.draw(
            result, viewer, height_px=VIEWER_PX, encounter=encounter if encounter >= 0 else None
        )


def _go_to(entry: store.Entry[int], rows: list[int], at: int) -> None:
    """Select an entry and show the frame in which it begins. For callbacks."""
    entry.set(at)
    state.go_to(*state.place_of(rows[at]))
