"""Export: the report's files, the session, a link, and frames as picture or video."""

import streamlit as st

from ui import export_frame, export_html, export_link, export_report, export_video, state
from ui.empty import one_system_only

st.title("Export")
result = state.result()
if result is None:
    one_system_only()
else:
    export_report.draw(result)
    export_html.draw(result)
    export_link.draw()
    if export_frame.choose_frame(result):
        export_frame.draw(result)
        export_video.draw(result)
