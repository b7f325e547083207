"""Encounters page: the list, its sort order, and a map of all listed encounters."""

from __future__ import annotations

from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.figures.encounters import position_map
from ui.session import state, store
from ui.subject import subject_pages
from ui.views.encounters import selection
from ui.views.encounters.order import COLUMNS, SEVERITY, Order
from ui.widgets.charts import Clicked, draw_chart
from ui.widgets.table import SortedBy, draw_table
from ui.widgets.table_columns import MOST_ROWS, as_shown, columns_of, heading, rows_told

FIRST_COLUMNS: Final = (
    "recording",
    "track",
    "category",
    "severity_s_x",
    "severity_s_y",
    "miss_class_x",
    "miss_class_y",
    "peak_height",
    "peak_cost_x",
    "peak_cost_y",
)
"""Main columns. In a small window, the first five fit."""
BY_SEVERITY: Final = "Severity, the larger of both"


def order() -> Order:
    """Return the current sort order."""
    return Order(store.ENCOUNTER_ORDER.get() or SEVERITY, store.IS_DESCENDING.get())


def take_order(chosen: Order) -> None:
    """Set the sort order."""
    store.ENCOUNTER_ORDER.set(chosen.by)
    store.IS_DESCENDING.set(chosen.is_descending)


def draw_order() -> Order:
    """Draw the controls of the sort order, and return it."""
    with st.container(horizontal=True, vertical_alignment="bottom", gap="small"):
        st.selectbox(
            "Sort by",
            (SEVERITY, *COLUMNS),
            format_func=lambda name: BY_SEVERITY if name == SEVERITY else heading(name),
            key=store.ENCOUNTER_ORDER.key,
            persist_state="session",
            label_visibility="collapsed",
            width=230,
        )
        chosen = order()
        st.button(
            "Largest first" if chosen.is_descending else "Smallest first",
            key="encounters_turn",
            icon=f":material/arrow_{'down' if chosen.is_descending else 'up'}ward:",
            help="Turns the order round.",
            on_click=take_order,
            args=(Order(chosen.by, not chosen.is_descending),),
        )
    return chosen


def draw_switch() -> None:
    """Draw the switch between the main columns and all columns."""
    st.toggle(
        "All columns",
        key=store.ALL_COLUMNS.key,
        persist_state="session",
        help="Also coverage, lag, gap, tail, lead time, pose and more, to the right.",
    )


def draw(listed: pd.DataFrame, encounter: int) -> None:
    """Draw the list of encounters, with this encounter's row selected."""
    added = [name for of in subject_pages() for name in of.encounters().columns if name in listed]
    at_category = FIRST_COLUMNS.index("category") + 1  # after the category
    first = [*FIRST_COLUMNS[:at_category], *added, *FIRST_COLUMNS[at_category:]]
    others = [str(name) for name in listed if name not in first]
    table = as_shown(listed.head(MOST_ROWS))
    if len(state.recording_names()) == 1:  # the name is the same in every row
        first.remove("recording")
    shown = [*first, *others] if store.ALL_COLUMNS.get() else first
    at, by = selection.place_of(listed, encounter), order()
    draw_table(
        table,
        columns_of("encounters.csv", *shown),
        key="encounters_table",
        name="Encounters",
        on_click=partial(_click, table.index),
        selected=at if at < len(table) else None,
        sorted_by=SortedBy(by.by, by.is_descending),
        on_sort=_sort,
    )
    if told := rows_told(len(listed), "first"):
        st.caption(told)


def _sort(by: str) -> None:
    """Sort by the clicked heading. If the list is sorted by it already, reverse the order."""
    before = order()
    take_order(Order(by, not before.is_descending if before.by == by else True))


def _click(index: pd.Index, row: int, _column: str) -> None:
    selection.choose_clicked(int(index[row]))


def draw_map(encounters: pd.DataFrame) -> None:
    """Draw the positions of the encounters in the picture. A click selects one."""
    draw_chart(
        position_map(encounters, theme=state.theme(), objects=state.opened().dataset.objects),
        "encounters_map",
        on_click=_choose_point,
    )


def _choose_point(clicked: Clicked) -> None:
    selection.choose_clicked(int(clicked.value))
