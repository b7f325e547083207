"""Time left on the Encounters page: a description, and a button to the last chance."""

from __future__ import annotations

import streamlit as st

from nvcore.comparison.compare import Result
from nvcore.subjects.time_left.notes import last_chance
from nvcore.subjects.time_left.steps import time_left_in
from ui.session import state
from ui.shell.navigate import open_row
from ui.widgets.buttons import button
from ui.widgets.text import docs_link, plain


def draw_text(result: Result, encounter: int) -> None:
    """Draw when the last chance of an encounter is, and how each system responds to it."""
    if result.dataset.objects.is_on_road:
        text = state.say(last_chance(result, encounter))
        st.caption(f"{docs_link('Time left', 'time-left')}: {plain(text)}")


def draw_ways(result: Result, encounter: int) -> None:
    """Draw a button to the last chance of an urgent encounter."""
    view, frames = time_left_in(result), result.dataset.frames
    chance = int(view.urgency["urgent_row"].iloc[encounter])
    if view.is_urgent[encounter] and button(
        "Last chance to stop",
        key="encounters_show_chance",
        help=f"Frame {frames['frame'].iloc[chance]}",
        width="stretch",
    ):
        open_row(chance)
