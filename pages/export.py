"""Export: the report's files, the session, a link, and frames as picture or video."""

import streamlit as st

from ui.export import frame, html, link, report, video
from ui.session import state
from ui.shell.messages import one_system_only

st.title("Export")
result = state.result()
if result is None:
    one_system_only()
else:
    report.draw(result)
    html.draw(result)
    link.draw()
    if frame.choose_frame(result):
        frame.draw(result)
        video.draw(result)
