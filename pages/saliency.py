"""Saliency: which misses would annoy the driver most, and how the number comes about."""

import streamlit as st

from ui.saliency import events, figures
from ui.session import state
from ui.shell.messages import draw_caution, one_system_only
from ui.widgets.text import docs_link


@st.fragment
def draw_events() -> None:
    """X against Y, then the events of the chosen recording; a choice draws nothing but this."""
    events.open_asked()
    result = state.result()
    figures.draw_recordings(result)
    st.header("Events")
    recording = events.choose_recording()
    figures.draw_events(result, recording)
    events.draw_table(result, recording)


st.title("Saliency")
result = state.result()
if result is None:
    one_system_only()
else:
    st.caption(
        f"{docs_link('Saliency', 'saliency')}, in seconds, 0 is best: how much the misses will be "
        "noticed. A *saliency event* is a run of frames in which one pedestrian is the most "
        "salient miss. It counts by its *duration* times its *recency*, a weight of 0 to 1 that is "
        "larger for late misses, because the end of a drive is remembered best. Distant "
        "pedestrians can be the most salient, with the little weight they have."
    )
    draw_caution(result)
    figures.draw_numbers(result)
    draw_events()
