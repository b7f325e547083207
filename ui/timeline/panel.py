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
from nvcore.wording import count_text
from ui.session import drawing
from ui.widgets.text import UNDEFINED, number

MOST_BOXES: Final = 40
"""Boxes of a table; those with smaller terms are counted."""
LABEL_PX: Final = 80
BOX_PX: Final = 46
ROW_PX: Final = 26
HEAD_PX: Final = 36
FORMS: Final = {"term": ".2f", "cost": ".2f", "k": ".2f", "score": ".2f"}
"""Format of a column by the first part of its name; other numbers are whole."""


def draw(result: Result, row_in_all: int) -> None:
    """Similarity of both systems in the frame, what it loses, and to which boxes."""
    facts = frame_summary(result, row_in_all)
    st.markdown(f"**Frame {facts.frame}**, {facts.time_s:.2f} s")
    left, right = st.columns(2)
    for column, letter, system in ((left, "X", facts.x), (right, "Y", facts.y)):
        column.metric(f"similarity {letter}", number(system.similarity, ".3f"))
        column.caption(
            f"{system.matched} of {facts.n_truth} pedestrians matched, "
            f"{count_text(system.false_alarms, 'false alarm')}; lost to misses "
            f"{number(system.loss_miss, '.3f')}, to false alarms {number(system.loss_false, '.3f')}"
        )
    _boxes(facts)
    with st.expander("Picture"):
        st.slider(
            "Stretch (percentiles of the grey values)",
            0.0,
            100.0,
            drawing.stretch(),
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
        _table(facts.pedestrians, PEDESTRIAN_WORDS, "pedestrians")
    if facts.detections.empty:
        st.caption("Neither system has a detection that counts in this frame.")
    else:
        _table(facts.detections, DETECTION_WORDS, "detections")


def _table(boxes: pd.DataFrame, words: Mapping[str, Words], kind: str) -> None:
    """A column for each box, the largest term first: a narrow window shows all of the first ones.

    The first of `words` is the heading of a column, the others are the rows.
    """
    heading, *names = words
    meanings = "  \n".join(f"*{label}*: {meaning}" for label, meaning in words.values())
    st.markdown(f"{kind.capitalize()} by term", help=meanings)
    shown = boxes.head(MOST_BOXES).to_dict("records")
    columns = {str(i): [_text(name, box[name]) for name in names] for i, box in enumerate(shown)}
    labels = [words[name].label for name in names]
    config: dict[str, Any] = {
        str(i): st.column_config.TextColumn(
            _text(heading, box[heading]), width=BOX_PX, alignment="right"
        )
        for i, box in enumerate(shown)
    }
    config["_index"] = st.column_config.TextColumn(words[heading].label, width=LABEL_PX)
    st.dataframe(
        pd.DataFrame(columns, index=labels),
        height=HEAD_PX + ROW_PX * len(names),
        row_height=ROW_PX,
        key=kind,
        column_config=config,
    )
    if n_left := len(boxes) - len(shown):
        st.caption(f"{count_text(n_left, 'box', 'boxes')} with smaller terms left out.")


def _text(name: str, value: Any) -> str:
    if isinstance(value, str):
        return value.replace(" and ", ", ")
    form = FORMS.get(name.partition("_")[0], ".0f")
    return number(value, form) if np.isfinite(value) else UNDEFINED
