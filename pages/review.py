"""Review page: misses, false alarms and doubtful truth case by case, and what is decided."""

import pandas as pd
import streamlit as st

from nvcore.common.wording import shortened
from nvcore.comparison.compare import Result
from ui.session import state
from ui.shell.messages import draw_notices, errors_shown, needs_comparison
from ui.subjects.review import files, gallery, kept, numbers, projects
from ui.widgets.text import plain

WATCH_S = 4


@st.fragment
@needs_comparison
def draw_cases(result: Result) -> None:
    """Draw numbers, files and projects, and the cases. A decision redraws only these."""
    cases, decisions = gallery.cases_of(result), kept.decisions()
    top = st.container(key="review_top")
    gallery.draw_conflict(cases)
    gallery.draw(result, cases, decisions, seen=kept.seen())
    with top:  # after the cases, which are not to wait for it
        numbers.draw(result, cases, decisions, lambda: draw_kept(decisions))


def draw_kept(decisions: pd.DataFrame) -> None:
    """Draw the decisions as files, and the projects."""
    with st.popover("Decisions", type="tertiary"):
        files.draw(decisions)
    opened = kept.project()
    label = "Projects" if opened is None else f"Project: {plain(shortened(opened[1].name, 24))}"
    popover = st.popover(label, type="tertiary", key="review_projects", on_change="rerun")
    if popover.open:
        with popover:
            projects.draw()


@st.fragment(run_every=WATCH_S)
def watch() -> None:
    """Draw the page again once others have decided."""
    if kept.has_news():
        st.rerun()


@needs_comparison
def draw(result: Result) -> None:
    """Draw the notices, and the cases."""
    draw_notices(result)
    draw_cases()


st.title("Review", help=state.say("One case at a time: is each miss a real one?"))
with errors_shown():
    projects.follow_address()
draw()
if kept.project() is not None:
    watch()
