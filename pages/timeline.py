"""Timeline: a recording frame by frame, with both systems' similarity and encounters over time."""

import streamlit as st

from ui.session import state
from ui.shell.messages import one_system_only
from ui.timeline import plots, viewer

st.title("Timeline")
result = state.result()
if result is None:
    one_system_only()
elif len(result.dataset.frames) == 0:
    st.info("There is no evaluated frame. Check the frame list on the Data page.")
else:
    viewer.recording_choice()
    plots.draw_all(result)
