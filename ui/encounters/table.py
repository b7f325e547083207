"""Encounters page: the table, and the encounter that was chosen in it."""

from __future__ import annotations

from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.figures.encounters import position_map
from nvcore.schema import CATEGORY_TEXT, Category
from nvcore.tables.moments import NEVER, encounter_moments
from ui.encounters import picture
from ui.session import state
from ui.shell.navigate import open_row
from ui.widgets.charts import draw_chart
from ui.widgets.clicks import clicked_point, clicked_row
from ui.widgets.table_columns import (
    MOST_ROWS,
    as_shown,
    class_words,
    column_config,
    rows_told,
    table_height,
)
from ui.widgets.text import UNDEFINED, number, plain

FIRST_COLUMNS: Final = (
    "recording",
    "track",
    "category",
    "severity_s_x",
    "severity_s_y",
    "peak_cost_x",
    "peak_cost_y",
    "miss_class_x",
    "miss_class_y",
    "peak_height",
)
"""What most people look for, as many as stand side by side in a small window."""
ORDER: Final = (
    "Sorted by severity, the larger of X's and Y's; of equals the tallest first. Distant "
    "pedestrians, which do not count, are last. Click a heading to sort by it."
)
SELECTED: Final = "encounters_chosen"


def draw(result: Result, encounters: pd.DataFrame) -> None:
    """The encounters that pass the filters, then the map beside the chosen one."""
    if encounters.empty:
        st.info("No encounter passes the filters: widen or clear them.", icon=":material/info:")
        return
    _draw_table(encounters)
    left, right = st.columns([3, 2], gap="medium")
    with left:
        _draw_map(encounters)
    with right:
        _draw_chosen(result, encounters)


def _draw_table(encounters: pd.DataFrame) -> None:
    other_columns = [name for name in encounters if name not in FIRST_COLUMNS]
    table = as_shown(by_weight(encounters)[[*FIRST_COLUMNS, *other_columns]].head(MOST_ROWS))
    left, right = st.columns([5, 1], vertical_alignment="bottom")
    left.caption(ORDER)
    has_all = right.toggle(
        "All columns",
        key="encounters_columns",
        persist_state="session",
        help="Also coverage, lag, gap, tail, lead time, pose and more, to the right.",
    )
    # a key for these rows: a selection must not move to another pedestrian
    key = f"encounters_table_{hash(tuple(table.index))}"
    st.dataframe(
        table,
        hide_index=True,
        column_config=column_config("encounters.csv"),
        height=table_height(len(table)),
        placeholder=UNDEFINED,
        key=key,
        column_order=None if has_all else FIRST_COLUMNS,
        selection_mode=("single-row", "single-cell"),
        on_select=partial(_choose_row, key, table.index),
    )
    if note := rows_told(len(encounters), "first"):
        st.caption(f"{note} The filters choose among all.")


def by_weight(encounters: pd.DataFrame) -> pd.DataFrame:
    """The rows in the order of `ORDER`, with their index."""
    severity_s = encounters[["severity_s_x", "severity_s_y"]].max(axis=1).fillna(-1.0)
    is_distant = encounters["category"] == Category.DISTANT
    height = encounters["peak_height"].to_numpy(dtype=float)
    return encounters.iloc[np.lexsort((-height, -severity_s.to_numpy(dtype=float), is_distant))]


def _choose_row(key: str, index: pd.Index) -> None:
    row = clicked_row(key)
    if row is not None:
        _choose(int(index[row]))


def _draw_map(encounters: pd.DataFrame) -> None:
    draw_chart(
        position_map(encounters, theme=state.theme()), "encounters_map", on_click=_choose_point
    )


def _choose_point() -> None:
    clicked = clicked_point("encounters_map")
    if clicked is not None:
        _choose(int(clicked[0]))


def _choose(encounter: int) -> None:
    """Remember an encounter by its row, for the data that are open."""
    st.session_state[SELECTED] = (state.opened().dataset.fingerprint, encounter)


def _draw_chosen(result: Result, encounters: pd.DataFrame) -> None:
    fingerprint, encounter = st.session_state.get(SELECTED, ("", -1))
    if fingerprint != result.dataset.fingerprint or encounter not in encounters.index:
        st.info(
            "Click a row of the table or a mark on the map to see the encounter here and open it "
            "in the Timeline.",
            icon=":material/touch_app:",
        )
        return
    row = encounters.loc[encounter]
    st.header(f"Pedestrian {row['track']} in {plain(row['recording'])}")
    st.markdown(CATEGORY_TEXT[Category(row["category"])])
    moments = encounter_moments(result).iloc[encounter]
    picture.draw(result, encounter, int(moments["shown_row"]))
    _draw_ways(result, row, moments)
    st.table(_both(row))
    st.caption(
        f"Up to {row['peak_height']:.0f} px tall (k {row['peak_k']:.2f}); mean position "
        f"{row['lateral_position']:+.2f} (-1 left edge, 1 right edge); pose z-score "
        f"{number(row['aspect_z'], '+.1f')}; frames {row['first_frame']} to {row['last_frame']}."
    )


def _both(row: pd.Series[Any]) -> pd.DataFrame:
    """How X and Y did with one encounter, side by side, as text."""
    columns = {}
    for letter in "xy":
        matched, coverage = row[f"matched_{letter}"], row[f"coverage_{letter}"]
        share = f"{matched} of {row['n_relevant']} frames"
        columns[letter.upper()] = {
            "Severity": _seconds(row[f"severity_s_{letter}"]),
            "Peak cost": number(row[f"peak_cost_{letter}"], ".2f"),
            "Miss class": class_words(row[f"miss_class_{letter}"]) or UNDEFINED,
            "Matched": f"{share} ({coverage:.0%})" if row["n_relevant"] else UNDEFINED,
            "Lag": _seconds(row[f"lag_s_{letter}"]),
            "Longest gap": _seconds(row[f"gap_s_{letter}"]),
            "Tail": _seconds(row[f"tail_s_{letter}"]),
        }
    return pd.DataFrame(columns).rename_axis("Measure")


def _seconds(value: float) -> str:
    text = number(value, ".2f")
    return text if text == UNDEFINED else f"{text} s"


def _draw_ways(result: Result, row: pd.Series[Any], moments: pd.Series[Any]) -> None:
    """Buttons to the frames that are worth seeing."""
    frames = result.dataset.frames
    shown_row = int(moments["shown_row"])
    missed = {letter: int(moments[f"missed_row_{letter}"]) for letter in "xy"}
    if st.button(
        "Show in timeline",
        key="encounters_show",
        type="primary",
        icon=":material/movie:",
        width="stretch",
    ):
        open_row(shown_row)
    st.caption(
        f"Frame {frames['frame'].iloc[shown_row]} at {frames['time_s'].iloc[shown_row]:.2f} s, "
        f"{_why(result, row, shown_row, any(place >= 0 for place in missed.values()))}."
    )
    for letter, place in missed.items():
        if place not in (shown_row, NEVER) and st.button(
            f"Show where {letter.upper()} first misses (frame {frames['frame'].iloc[place]})",
            key=f"encounters_show_{letter}",
            width="stretch",
        ):
            open_row(place)


def _why(result: Result, row: pd.Series[Any], shown_row: int, is_missed: bool) -> str:
    """Why that frame is shown."""
    if not is_missed:
        return "where the encounter begins to count"
    x, y = row["severity_s_x"], row["severity_s_y"]
    heavier, other = ("y", "x") if y > x else ("x", "y")
    what = "missing the pedestrian" if x == y else f"{heavier.upper()}'s failure, the heavier,"
    is_peak = shown_row == result.system(heavier).failures["peak_row"].iloc[int(str(row.name))]
    while_seen = "" if is_peak else f" while {other.upper()} detects the pedestrian"
    return f"where {what} costs most{while_seen}"
