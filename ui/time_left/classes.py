"""Time left page: the urgent encounters of each class."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.evidence.measures import Evidence
from nvcore.measures.table import evidence_form
from nvcore.metrics.encounter_classes import shown_class
from nvcore.time_left.by_class import OfClass, time_left_by_class
from nvcore.wording import Footnotes, capitalised, difference, minus, number
from ui.session import state
from ui.session.results.evidence import comparison_key
from ui.widgets.html import MeasureRow, interval_cell, measures_html
from ui.widgets.text import docs_link, plain

HEAD: Final = (
    *("In time X", "In time Y", "X − Y", "95 % interval"),
    *("Impact X (km/h)", "Impact Y (km/h)", "X − Y", "95 % interval"),
)


def draw(result: Result) -> None:
    """A row for each class; nothing where no urgent encounter has any."""
    key = comparison_key(result)
    rows = state.cached("time_left_by_class", key, lambda: time_left_by_class(result), most=8)
    if not rows:
        return
    st.subheader(state.say("By class of {one}"))
    notes = Footnotes()
    shown = [_row(row, notes) for row in rows]
    st.html(measures_html(shown, key="time-left-by-class", head=HEAD, first="Class"))
    lines = [f"{mark}: {plain(capitalised(note))}." for note, mark in notes.marks.items()]
    classes = docs_link("Classes of encounters", "classes-of-encounters")
    lines.append(
        state.say("{A_one} may have several classes ({classes}). ", classes=classes)
        + "Impact: mean speed, 0 where the system was in time."
    )
    st.caption("  \n".join(lines))


def _row(row: OfClass, notes: Footnotes) -> MeasureRow:
    share, share_mark = interval_cell(row.share, notes)
    impact, impact_mark = interval_cell(row.impact, notes)
    form = evidence_form(row.impact.figure)
    return MeasureRow(
        label=f"{shown_class(row.name)}, {row.n_urgent:,} urgent",
        cells=(
            *(f"{row.in_time_x:,}", f"{row.in_time_y:,}", _apart(row.share), share),
            *(number(value, form) for value in (row.impact.x, row.impact.y)),
            *(_apart(row.impact), impact),
        ),
        marks=" ".join(dict.fromkeys(filter(None, (share_mark, impact_mark)))),
    )


def _apart(of: Evidence) -> str:
    return minus(difference(of.x, of.y, evidence_form(of.figure)))
