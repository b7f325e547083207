"""Saliency page: choice of the recording, and the table of events."""

from __future__ import annotations

from functools import partial
from typing import Final

import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.settings.params import Params
from nvcore.tables.columns import column_names
from nvcore.tables.result import located_events
from ui.session import state, store
from ui.session.chosen import recordings_key
from ui.shell.navigate import open_row
from ui.widgets import table
from ui.widgets.choices import choose_side_by_side
from ui.widgets.table_columns import MOST_ROWS, as_shown, columns_of, rows_told

BOTH: Final = "both"


def open_asked() -> None:
    """Open the frame of the latest click in a figure or the table, if there was one."""
    row = store.SALIENCY_ROW.pop()
    if row is not None:
        open_row(row)


def choose_recording() -> int | None:
    """Draw the choice of a recording if there are several, and return it. None: all."""
    names = state.recording_names()
    if len(names) == 1:
        return None
    chosen = store.widget(recordings_key("saliency"))
    clicked_row = store.SALIENCY_RECORDING.pop()
    if clicked_row is not None:
        chosen.set(names[clicked_row])
    if chosen.get() not in (None, *names):  # another choice of tags may exclude it
        chosen.set(None)
    name: str | None = st.selectbox(
        "Recording",
        names,
        index=None,
        key=chosen.key,
        placeholder="all recordings",
        persist_state="session",
        width=360,
    )
    return None if name is None else names.index(name)


def draw_table(result: Result, recording: int | None) -> None:
    """Draw events of one or all recordings, most salient first. A click opens the first frame."""
    letter = choose_side_by_side("Events of", [BOTH, "X", "Y"], "saliency_system", default=BOTH)
    events, first_row = _events(result, recording, None if letter == BOTH else letter.lower())
    if events.empty:
        st.info(state.say("No event here: {nobody} is missed by more than the tolerance."))
        return
    n_events = len(events)
    events, first_row = events.head(MOST_ROWS), first_row[:MOST_ROWS]
    table.draw_table(
        as_shown(events.assign(system=events["system"].str.upper())),
        columns_of("events.csv", *_shown_columns(result.params)),
        key="saliency_events",
        name="Events, the most salient first",
        on_click=partial(_ask_for_row, first_row),
    )
    st.caption(
        "Click an event here or in a figure to open its first frame in the Timeline. "
        + rows_told(n_events, "most salient")
    )


def _shown_columns(params: Params) -> list[str]:
    """Return the columns that make up saliency, from left to right, then the frames."""
    weight = ["weight_s"] if params.saliency_weight == "risk" else []
    end = "rest_s" if params.recency_unit == "seconds" else "tau"
    made_of = ["duration_s", "relevant_s", *weight, end, "recency", "saliency_s"]
    return ["recording", "track", "system", "start_s", *made_of, "first_frame", "last_frame"]


def _events(
    result: Result, recording: int | None, letter: str | None
) -> tuple[pd.DataFrame, list[int]]:
    """Return the rows of events.csv to show, and the frame row at which each begins."""
    events = located_events(result)
    if recording is not None:
        events = events[events["recording_row"] == recording]
    if letter is not None:
        events = events[events["system"] == letter]
    events = events.sort_values("saliency_s", ascending=False, kind="stable")
    return events[column_names("events.csv")], events["first_row"].tolist()


def _ask_for_row(first_row: list[int], row: int, _column: str) -> None:
    store.SALIENCY_ROW.set(first_row[row])
