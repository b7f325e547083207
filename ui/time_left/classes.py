"""Time left page: the urgent encounters of each class."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison import Result
from nvcore.time_left.by_class import CLASS_HEAD, IMPACT_MEANING, time_left_by_class
from nvcore.wording import Footnotes, capitalised
from ui.session import state
from ui.session.results import comparison_key
from ui.widgets.html import MeasureRow, measures_html
from ui.widgets.text import docs_link, plain


def draw(result: Result) -> None:
    """A row for each class; nothing where no urgent encounter has any."""
    key = comparison_key(result)
    rows = state.cached("time_left_by_class", key, lambda: time_left_by_class(result), most=8)
    if not rows:
        return
    st.subheader(state.say("By class of {one}"))
    notes = Footnotes()
    shown = []
    for row in rows:
        cells, marks = row.cells(notes)
        shown.append(MeasureRow(row.label, cells, marks=marks))
    st.html(measures_html(shown, key="time-left-by-class", head=CLASS_HEAD, first="Class"))
    lines = [f"{mark}: {plain(capitalised(note))}." for note, mark in notes.marks.items()]
    classes = docs_link("Classes of encounters", "classes-of-encounters")
    lines.append(
        state.say("{A_one} may have several classes ({classes}). ", classes=classes)
        + IMPACT_MEANING
    )
    st.caption("  \n".join(lines))
