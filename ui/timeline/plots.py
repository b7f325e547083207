"""Timeline page: viewer, time plot and lanes that move together."""

from __future__ import annotations

from typing import Any, Final

import streamlit as st

from nvcore.comparison import Result
from nvcore.figures.lanes import lanes_figure
from nvcore.figures.time_plot import similarity_plot
from ui.session import state
from ui.timeline import viewer
from ui.widgets.charts import clicked_chart
from ui.widgets.text import docs_link

LANES_PX: Final = 640
"""Height from which on the lanes scroll by themselves."""


@st.fragment
def draw_all(result: Result) -> None:
    """Everything that shows the current frame; a click in one part moves all."""
    settled = viewer.settled()
    if settled != state.row():
        state.settle(state.recording(), settled)
    cursor = state.row_in_all()
    left, right = st.columns([3, 1], gap="medium")
    with st.container():  # first: while a slider moves, the plot is what people wait for
        _draw_plot(result, cursor)
    with left:
        viewer.draw(result)
    with right:
        viewer.panel(result, cursor)
    theme, recording = state.theme(), state.recording()
    lanes = state.workspace().cached(  # they stay while alpha and the like move
        "lanes",
        (state.workspace().version, recording, theme, cursor),
        lambda: lanes_figure(result, recording, theme=theme, cursor_row=cursor),
    )
    with st.container(height=LANES_PX if lanes.layout.height > LANES_PX else "content"):
        _clickable(lanes, "lanes")


def _draw_plot(result: Result, cursor: int) -> None:
    upright = st.toggle(
        "Time upwards, X left and Y right",
        key="upright",
        persist_state="session",
        help="The plot as in the paper's figure 8: the middle is perfect.",
    )
    _clickable(
        similarity_plot(
            result,
            state.recording(),
            theme=state.theme(),
            cursor_row=cursor,
            layout="upright" if upright else "time",
        ),
        "time_plot",
    )
    st.caption(
        "Thin: similarity of each frame, 1 is best. Thick: moving mean. Filled: low intervals. "
        "Marks above: saliency events. Click to see the frame "
        f"({docs_link('Metrics', 'similarity')})."
    )


def _clickable(figure: Any, key: str) -> None:
    row = clicked_chart(figure, f"{key}_{state.recording()}", clicks=key)
    if row is not None:
        state.go_to(*state.place_of(int(row)))
        st.rerun(scope="fragment")
