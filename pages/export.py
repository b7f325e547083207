"""Export page: a link, the report's files, the session, and frames as picture or video."""

import streamlit as st

from nvcore.comparison.compare import Result
from ui.shell.messages import needs_comparison
from ui.views.export import frame, html, link, report, video


@needs_comparison
def draw(result: Result) -> None:
    """Draw everything that can be exported."""
    link.draw()
    report.draw(result)
    html.draw(result)
    if frame.choose_frame(result):
        frame.draw(result)
        video.draw(result)


st.title("Export")
draw()
