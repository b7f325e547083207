"""Timeline: a recording frame by frame, with both systems' similarity and encounters over time."""

import streamlit as st

from ui import state, timeline_plots, timeline_viewer
from ui.empty import one_system_only

st.title("Timeline")
result = state.result()
if result is None:
    one_system_only()
elif len(result.dataset.frames) == 0:
    st.info("There is no evaluated frame. Check the frame list on the Data page.")
else:
    timeline_viewer.recording_choice()
    timeline_plots.draw_all(result)
