"""Timeline page, beside the viewer: numbers of the current frame and its boxes."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd
import streamlit as st

from nvcore.common.wording import count_text
from nvcore.comparison.compare import Result
from nvcore.figures.overlay.explain import explain_boxes, explain_similarity
from nvcore.tables.frame import (
    DETECTION_WORDS,
    PEDESTRIAN_WORDS,
    FrameSummary,
    Words,
    frame_summary,
)
from ui.session import state
from ui.session.chosen import choose_encounter, chosen_encounter, name_of
from ui.shell.navigate import open_page
from ui.widgets import drawing
from ui.widgets.buttons import button
from ui.widgets.table import TableColumn, draw_table
from ui.widgets.text import UNDEFINED, number, plain

MOST_BOXES: Final = 40
"""Maximum number of boxes in a table. Those with smaller terms are only counted."""
FORMS: Final = {"term": ".2f", "cost": ".2f", "k": ".2f", "score": ".2f"}
"""Format of a column by the first part of its name. Other numbers are integers."""


def draw(result: Result, row_in_all: int) -> None:
    """Draw both systems' similarity in the frame, and which boxes reduce it."""
    facts = frame_summary(result, row_in_all)
    st.markdown(f"**Frame {facts.frame}**, {facts.time_s:.2f} s")
    st.html(_numbers(facts))
    with st.expander("What made these numbers", expanded=True):
        for letter in "xy":
            why = plain(explain_similarity(result, row_in_all, letter))
            st.caption(f"**{letter.upper()}** {why}")
    _chosen(result, row_in_all)
    _boxes(result, facts)
    with st.expander("Picture"):
        st.slider(
            "Grey values shown from black to white (%)",
            0.0,
            100.0,
            drawing.stretch(),
            0.1,
            key="stretch",
            persist_state="session",
            help="Darker than the left end is black, brighter than the right end white: raise the "
            "left or lower the right one where a picture is pale. The ends are percentiles of the "
            "picture's grey values. For a quick look: the viewer's brightness and contrast, key b.",
        )


def _numbers(facts: FrameSummary) -> str:
    """Return an HTML table of X beside Y that fits narrow windows."""
    sides = (facts.x, facts.y)
    rows = [
        ("similarity", [f"<b>{number(side.similarity, '.3f')}</b>" for side in sides]),
        ("lost to misses", [number(side.loss_miss, ".3f") for side in sides]),
        ("lost to false alarms", [number(side.loss_false, ".3f") for side in sides]),
        ("matched", [f"{side.matched} of {facts.n_truth}" for side in sides]),
        ("false alarms", [f"{side.false_alarms}" for side in sides]),
    ]
    body = "".join(
        f'<tr data-frame-value="{label}"><th scope="row">{label}</th>'
        f"{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"
        for label, cells in rows
    )
    head = '<tr><td></td><th scope="col">X</th><th scope="col">Y</th></tr>'
    return f'<table class="nv-numbers" data-row="{facts.row}">{head}{body}</table>'


def _chosen(result: Result, row: int) -> None:
    """Show the selected pedestrian and what missing them costs in this frame."""
    encounter = chosen_encounter(result)
    if encounter is None:
        st.caption("Click a box in the picture, or a cell below: why it counts and costs.")
        return
    track = result.encounters.track[encounter]
    reasons = [box for box in explain_boxes(result, row) if box.encounter == encounter]
    recording = int(result.encounters.recording[encounter])
    with st.container(border=True):
        if reasons:
            lines = "\n".join(f"- {plain(line)}" for line in reasons[0].lines)
            st.markdown(f"**{plain(reasons[0].title)}**\n{lines}")
        else:
            where = plain(state.recording_names()[recording])
            st.markdown(
                state.say(
                    "**{One} {track}** of {where} is chosen, and not in this frame.",
                    track=track,
                    where=where,
                )
            )
        if button("Open in Encounters", key="open_chosen", width="stretch"):
            open_page("encounters", encounter=name_of(result, encounter))


def _choose(result: Result, tracks: list[int], row: int, _line: int, column: str) -> None:
    """Select the pedestrian whose column was clicked."""
    if not column:  # a click on the names of the rows
        return
    truth = result.dataset.truth
    rows = truth.rows_of(row, row + 1)
    is_chosen = result.tracks.track[rows] == tracks[int(column)]
    for encounter in result.encounters.encounter_of[rows][is_chosen & ~truth.ignore[rows]][:1]:
        choose_encounter(result, int(encounter))


def _boxes(result: Result, facts: FrameSummary) -> None:
    """Draw tables of the frame's pedestrians and detections, the costliest first."""
    if not facts.n_truth:
        st.caption(state.say("{Nobody} is annotated in this frame."))
    else:
        tracks = [int(track) for track in facts.pedestrians["track"]]
        _table(
            facts.pedestrians,
            PEDESTRIAN_WORDS,
            "pedestrians",
            state.say("{Many} by term"),
            clicks="cell",
            on_click=partial(_choose, result, tracks, facts.row),
        )
    if facts.detections.empty:
        st.caption("Neither system has a detection that counts in this frame.")
    else:
        _table(facts.detections, DETECTION_WORDS, "detections", "Detections by term")


def _table(
    boxes: pd.DataFrame, words: Mapping[str, Words], key: str, title: str, **clicking: Any
) -> None:
    """Draw a table with a column for each box, the largest term first.

    A narrow window shows the first columns in full.

    The first of `words` is the heading of a column, the others are the rows.
    """
    heading, *names = words
    meanings = "  \n".join(f"*{label}*: {meaning}" for label, meaning in words.values())
    st.markdown(title, help=state.say(meanings))
    shown = boxes.head(MOST_BOXES).to_dict("records")
    columns = {str(i): [_text(name, box[name]) for name in names] for i, box in enumerate(shown)}
    labels = [words[name].label for name in names]
    heads = {
        str(i): TableColumn(_text(heading, box[heading]), is_number=True)
        for i, box in enumerate(shown)
    }
    draw_table(
        pd.DataFrame({"": labels, **columns}),
        {"": TableColumn(state.say(words[heading].label), is_head=True), **heads},
        key=key,
        name=title,
        is_sortable=False,
        **clicking,
    )
    if n_left := len(boxes) - len(shown):
        st.caption(f"{count_text(n_left, 'box', 'boxes')} with smaller terms left out.")


def _text(name: str, value: Any) -> str:
    if isinstance(value, str):
        return value.replace(" and ", ", ")
    form = FORMS.get(name.partition("_")[0], ".0f")
    return number(value, form) if np.isfinite(value) else UNDEFINED
