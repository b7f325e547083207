"""Saliency page: misses that would annoy the driver most, and how saliency is composed."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.shell.messages import draw_notices, needs_comparison
from ui.views.saliency import events, figures


@st.fragment
@needs_comparison
def draw_events(result: Result) -> None:
    """Draw X against Y, then the selected recording's events. Selecting redraws only these."""
    events.open_asked()
    figures.draw_recordings(result)
    st.header("Events")
    recording = events.choose_recording()
    figures.draw_events(result, recording)
    events.draw_table(result, recording)


@needs_comparison
def draw(result: Result) -> None:
    """Draw what saliency means, its values, and the events behind them."""
    st.caption(figures.what_it_is(result.params))
    draw_notices(result)
    figures.draw_numbers(result)
    draw_events()


st.title("Saliency")
draw()
