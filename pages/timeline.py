"""Timeline page: a recording frame by frame, with similarity and encounters over time."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.session import state
from ui.shell.messages import draw_operating_point, needs_comparison
from ui.views.timeline import plots
from ui.widgets.recording import recording_choice


@needs_comparison
def draw(result: Result) -> None:
    """Draw the recording, its viewer and its plots."""
    if len(result.dataset.frames) == 0:
        st.info("There is no evaluated frame. Check the frame list on the Data page.")
        return
    recording_choice()
    draw_operating_point(result)
    plots.draw_all(result, state.recording())


st.title("Timeline")
draw()
