"""Timeline page, beside the viewer: the frame in numbers, box by box."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.comparison import Result
from nvcore.tables.frame import (
    DETECTION_WORDS,
    PEDESTRIAN_WORDS,
    FrameSummary,
    Words,
    frame_summary,
)
from ui.session import state
from ui.widgets.text import UNDEFINED, number

ROW_PX: Final = 28
MAX_ROWS: Final = 8
"""Rows in sight; the table scrolls to the others."""
WIDTHS: Final = {"track": 40, "cost": 48, "missed_by": 66, "system": 34, "outcome": 60, "k": 46}
NARROW: Final = 54
"""Width of the other columns, px."""
WHOLE: Final = ("track", "height_px", "border_px", "nearest_px")


def draw(result: Result, row_in_all: int) -> None:
    """Similarity of both systems in the frame, what it loses, and to which boxes."""
    facts = frame_summary(result, row_in_all)
    st.markdown(f"**Frame {facts.frame}**, {facts.time_s:.2f} s")
    left, right = st.columns(2)
    for column, letter, system in ((left, "X", facts.x), (right, "Y", facts.y)):
        column.metric(f"similarity {letter}", number(system.similarity, ".3f"))
        column.caption(
            f"{system.matched} of {facts.n_truth} pedestrians matched, {system.false_alarms} "
            f"false alarm{'s' if system.false_alarms != 1 else ''}; lost to misses "
            f"{number(system.loss_miss, '.3f')}, to false alarms {number(system.loss_false, '.3f')}"
        )
    _boxes(facts)
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


def _boxes(facts: FrameSummary) -> None:
    """Who costs most, and which detections."""
    if not facts.n_truth:
        st.caption("Nobody is annotated in this frame.")
    else:
        st.markdown("Pedestrians, the largest term first")
        _table(facts.pedestrians, PEDESTRIAN_WORDS, "pedestrians")
    if facts.detections.empty:
        st.caption("Neither system has a detection that counts in this frame.")
    else:
        st.markdown("Detections, the largest term first")
        _table(facts.detections, DETECTION_WORDS, "detections")


def _table(table: pd.DataFrame, words: Mapping[str, Words], key: str) -> None:
    shown = table[list(words)].replace([np.inf, -np.inf], np.nan)
    n_rows = min(len(shown), MAX_ROWS)
    st.dataframe(
        shown,
        hide_index=True,
        height=ROW_PX * n_rows + 38,
        row_height=ROW_PX,
        key=key,
        placeholder=UNDEFINED,
        column_config={name: _column(name, *words[name]) for name in words},
    )


def _column(name: str, label: str, meaning: str) -> Any:
    width = WIDTHS.get(name, NARROW)
    if name in ("missed_by", "outcome", "system"):
        return st.column_config.TextColumn(label, width=width, help=meaning)
    form = "%.0f" if name.removesuffix("_x").removesuffix("_y") in WHOLE else "%.2f"
    pinned = name == "track"
    return st.column_config.NumberColumn(
        label, width=width, help=meaning, format=form, pinned=pinned
    )
