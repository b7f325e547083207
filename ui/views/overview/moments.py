"""Overview page: the worst moments of each system, and those in which X and Y differ most."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.pictures import picture_address
from nvcore.tables.moments import encounter_box, worst_moments
from nvcore.tables.windows import windows_table, worst_windows_note
from ui.session import state, store
from ui.shell.navigate import open_row
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import docs_link, plain

KINDS: Final = {
    "x": "Worst of X",
    "y": "Worst of Y",
    "x_better": "X better",
    "y_better": "Y better",
}
_OF_WINDOW: Final = {
    "lost_s_per_min": (
        "lost (s/min)",
        ".2f",
        "What {letter} loses of its similarity: the sum of (1 − similarity) × time step, in "
        "seconds per minute of recording. 0 is best, 60 a similarity of 0 throughout.",
    ),
    "window_similarity": (
        "worst window",
        ".3f",
        "The lowest mean similarity of {letter} in any {window}; 1 is best.",
    ),
    "window_lost_s": ("lost there (s)", ".2f", "What {letter} loses in that window, in seconds."),
    "window_time_s": ("at (s)", ".2f", "Time of the window's middle in its recording."),
}
"""Label, format and help of the columns of each system's worst window."""
WINDOW_COLUMNS: Final = {
    "recording": ("", "", ""),
    **{f"{name}_{letter}": words for letter in "xy" for name, words in _OF_WINDOW.items()},
}
THUMBNAIL_PX: Final = 640
N_MOMENTS: Final = 4


def draw(result: Result) -> None:
    """Draw the moments of the selected kind side by side, each with a button to its frame."""
    theme = state.theme()
    st.caption(
        state.say(
            "The stretches of low similarity that weigh most, and those in which the systems "
            "differ most. The picture is of the worst frame, around the {one} {who} is named: "
            "{many} white, X {x}, Y {y}.",
            x=theme.style("x").words,
            y=theme.style("y").words,
        )
    )
    kind = choose_side_by_side(
        "Which moments", KINDS, "moments", default="x", label_visibility="collapsed"
    )
    table = worst_moments(result, n=N_MOMENTS)
    moments = table[table["kind"] == kind].to_dict("records")
    if not moments:
        st.info(_none(kind, result.params.low))
    for column, moment in zip(st.columns(N_MOMENTS), moments, strict=False):
        with column:
            _moment(result, kind, KINDS[kind], moment)


def worst_windows(result: Result) -> None:
    """Draw a table of each recording's worst window. A click opens the frame in its middle."""
    table = windows_table(result)
    if table.empty:
        st.info("There is no evaluated frame.")
        return
    draw_table(
        table,
        {name: _window_column(name, result) for name in WINDOW_COLUMNS},
        key="windows",
        name="Worst windows",
        on_click=partial(_ask_for_window, table),
        clicks="cell",
    )
    st.caption(
        f"{plain(state.say(worst_windows_note(table)))} Click a value of X or Y to open the middle "
        f"of that system's worst window of {result.params.window:g} s in the Timeline, or a "
        "recording's name for that of the worse system "
        f"({docs_link('Metrics', 'similarity')})."
    )
    row = store.WINDOW_ROW.pop()
    if row is not None:
        open_row(row)


def _ask_for_window(table: pd.DataFrame, row: int, column: str) -> None:
    """Store the clicked frame until the page is drawn, as callbacks cannot open pages."""
    store.WINDOW_ROW.set(window_row(table, row, column))


def window_row(table: pd.DataFrame, row: int, column: str) -> int:
    """Return the frame that a click opens, as a row of the frames table.

    It is the middle of the worst window of the column's system, or else of the worse system.
    """
    values = table.iloc[row]
    letter = column[-1:] if column in WINDOW_COLUMNS and column != "recording" else ""
    if not letter:
        letter = "x" if values["window_similarity_x"] <= values["window_similarity_y"] else "y"
    return int(values[f"window_row_{letter}"])


def _window_column(name: str, result: Result) -> TableColumn:
    """Return heading, format and help of a column. Columns of a system end with its letter."""
    if name == "recording":
        return TableColumn("Recording", is_head=True)
    (label, form, text), letter = WINDOW_COLUMNS[name], name[-1].upper()
    window = f"{result.params.window:g} s"
    return TableColumn(f"{letter} {label}", text.format(letter=letter, window=window), form)


def _moment(result: Result, kind: str, title: str, moment: Mapping[Hashable, Any]) -> None:
    row = int(moment["row"])
    with st.container(height="stretch"):  # so that the buttons stand in a line
        picture = _thumbnail(result, moment)
        if picture is not None:
            st.image(
                picture_address(picture), width="stretch", alt=f"{title}: frame {moment['frame']}"
            )
        st.markdown(
            f"**{plain(moment['recording'])}**, {moment['time_s']:.2f} s  \n"
            f"{plain(moment['reason'])}"
        )
        st.caption(
            f"similarity X {moment['similarity_x']:.2f}, Y {moment['similarity_y']:.2f}; "
            f"{moment['duration_s']:.2f} s"
        )
    if button("Open frame", key=f"moment_{kind}_{row}", width="stretch"):
        open_row(row)


def _thumbnail(result: Result, moment: Mapping[Hashable, Any]) -> bytes | None:
    row, track = int(moment["row"]), moment["track"]
    pictures, index = state.workspace().picture_of(*state.place_of(row))
    if pictures is None or index < 0:
        return None
    return drawing.thumbnail(
        (row, None if pd.isna(track) else int(track)),
        lambda: _draw(result, row, named_box(result, moment)),
    )


def named_box(result: Result, moment: Mapping[Hashable, Any]) -> np.ndarray | None:
    """Return the box (px) of the pedestrian named in a moment's reason.

    None if the reason names nobody, or the moment's frame does not show them.

    Parameters
    ----------
    moment
        Row of `nvcore.tables.moments.worst_moments`.
    """
    if pd.isna(moment["track"]):
        return None
    encounters = result.encounters
    is_named = (encounters.recording == moment["recording_index"]) & (
        encounters.track == moment["track"]
    )
    for encounter in np.flatnonzero(is_named):  # a track that is used again has several
        try:
            return encounter_box(result, int(encounter), int(moment["row"]))
        except ValueError:
            continue
    return None


def _draw(result: Result, row: int, xywh: np.ndarray | None) -> bytes:
    part = drawing.part_of_frame(result, row, xywh, labels=False)
    return drawing.small_jpeg(part, THUMBNAIL_PX)


def _none(kind: str, low: float) -> str:
    if kind in ("x", "y"):
        return f"{kind.upper()} never falls below a similarity of {low:g}."
    return "There is no such stretch."
