"""Review page: misses, false alarms and doubtful truth case by case, and what is decided."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.session import state
from ui.shell.messages import draw_notices, needs_comparison
from ui.subjects.review import gallery, kept


@st.fragment
@needs_comparison
def draw_cases(result: Result) -> None:
    """Draw the cases. A decision redraws only these."""
    gallery.draw(result, gallery.cases_of(result), kept.decisions())


@needs_comparison
def draw(result: Result) -> None:
    """Draw the notices, and the cases."""
    draw_notices(result)
    draw_cases()


st.title("Review", help=state.say("One case at a time: is each miss a real one?"))
draw()
