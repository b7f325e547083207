"""Timeline page: choice of the recording, the frame viewer and what is in the frame."""

from __future__ import annotations

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.tables.frame import FrameSummary, frame_summary
from nvcore.tables.moments import next_misses
from ui.session import state
from ui.session.viewer_arguments import viewer_arguments
from ui.widgets.text import number
from ui.widgets.viewer import settled_in, viewer

HEIGHT_PX = 700
KEY = "viewer"
MAX_ROWS = 8


def settled() -> int:
    """Row within the recording that the viewer has settled on, also before it is drawn."""
    recording = state.recording()
    n_rows = len(state.frame_numbers(recording))
    if not n_rows:
        return 0
    return settled_in(KEY, recording=recording, n_rows=n_rows, seek=(state.row(), state.seek()))


def draw(result: Result) -> None:
    """The viewer."""
    recording = state.recording()
    rows = result.dataset.frame_columns.rows_of(recording)
    lo, hi = state.stretch()
    viewer(
        **viewer_arguments(result, recording),
        traces={letter: system.similarity[rows] for letter, system in result.sides},
        low=result.params.low,
        intervals=[_spans(system.intervals, recording, rows.start) for _, system in result.sides],
        misses=next_misses(result, recording),
        names=[system.name for _, system in result.sides],
        seek=(state.row(), state.seek()),
        lo=lo,
        hi=hi,
        height_px=HEIGHT_PX,
        key=KEY,
    )


def _spans(intervals: pd.DataFrame, recording: int, first: int) -> np.ndarray:
    mine = intervals[intervals["recording"].to_numpy() == recording]
    return np.column_stack([mine["first_row"] - first, mine["last_row"] - first + 1])


def panel(result: Result, row_in_all: int) -> None:
    """The frame in numbers: similarity of both, who is missed by whom."""
    facts = frame_summary(result, row_in_all)
    st.markdown(f"**Frame {facts.frame}**, {facts.time_s:.2f} s")
    left, right = st.columns(2)
    for column, letter, system in ((left, "X", facts.x), (right, "Y", facts.y)):
        column.metric(f"similarity {letter}", number(system.similarity, ".3f"))
        column.caption(
            f"{system.matched} of {facts.n_truth} pedestrians matched, {system.false_alarms} "
            f"false alarm{'s' if system.false_alarms != 1 else ''}"
        )
    _missed(facts)
    with st.expander("Picture"):
        st.slider(
            "Stretch (percentiles of the grey values)",
            0.0,
            100.0,
            state.stretch(),
            0.1,
            key="stretch",
            persist_state="session",
            help="Grey values below the first percentile are black, above the second white.",
        )


def _missed(facts: FrameSummary) -> None:
    missed = facts.missed
    if not facts.n_truth:
        st.caption("Nobody is annotated in this frame.")
        return
    if missed.empty:
        st.caption("Nobody is missed in this frame.")
        return
    st.markdown("Missed, the tallest first")
    table = pd.DataFrame(
        {
            "ped.": missed["track"],
            "px": missed["height_px"].round(),
            "by": np.select(
                [~missed["found_x"] & ~missed["found_y"], ~missed["found_x"]],
                ["X and Y", "X"],
                "Y",
            ),
            "counts": np.where(missed["is_relevant"], "yes", "no"),
        }
    ).head(MAX_ROWS)
    st.dataframe(
        table,
        hide_index=True,
        height="content",
        row_height=28,
        key="missed",
        column_config={
            "ped.": st.column_config.NumberColumn(width=45, help="Track of the pedestrian."),
            "px": st.column_config.NumberColumn(width=45, help="Height of the box in pixels."),
            "by": st.column_config.TextColumn(width=60, help="Who misses this pedestrian."),
            "counts": st.column_config.TextColumn(
                width=60,
                help="Whether the proximity weight is at least 0.5: only then a miss counts in the "
                "encounters. Similarity weighs all.",
            ),
        },
    )
