"""Export: the report's files, the session, a link, and frames as picture or video."""

import streamlit as st

from nvcore.comparison import Result
from ui.export import frame, html, link, report, video
from ui.shell.messages import needs_comparison


@needs_comparison
def draw(result: Result) -> None:
    """Everything that can be taken away."""
    report.draw(result)
    html.draw(result)
    link.draw()
    if frame.choose_frame(result):
        frame.draw(result)
        video.draw(result)


st.title("Export")
draw()
