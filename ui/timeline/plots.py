"""Timeline page: viewer, time plot and lanes that move together."""

from __future__ import annotations

from typing import Any, Final, Literal

import streamlit as st

from nvcore.comparison import Result
from nvcore.figures.over_time.lanes import lanes_figure
from nvcore.figures.over_time.losses import loss_plot
from nvcore.figures.over_time.similarity import TimeLayout, similarity_plot
from ui.session import state
from ui.shell import title
from ui.timeline import panel, viewer
from ui.widgets.charts import clicked_chart
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import docs_link

LANES_PX: Final = 640
"""Height from which on the lanes scroll by themselves."""
PLOTS: Final[dict[TimeLayout | Literal["losses"], str]] = {
    "time": "Similarity",
    "losses": "Lost to misses and false alarms",
    "upright": "Upright, mirrored",
    "side_by_side": "Upright, side by side",
}
"""What the plot over time can show; the upright ones are the paper's figure 8."""
SIMILARITY_TEXT: Final = (
    "Thin: similarity of each frame, 1 is best. Thick: moving mean. Filled: low intervals. "
    "Marks above or between: saliency events."
)
LOSSES_TEXT: Final = (
    "What each frame loses of its similarity of 1. Filled: to misses, alpha × D(G, S). Hatched, on "
    "top: to false alarms, (1 − alpha) × D(S, G), both as shares of half the picture's width."
)


@st.fragment
def draw_all(result: Result) -> None:
    """Everything that shows the current frame; a click in one part moves all."""
    settled = viewer.settled()
    if settled != state.row():
        state.settle(state.recording(), settled)
    title.follow_frame()
    cursor = state.row_in_all()
    left, right = st.columns([3, 1], gap="medium")
    with st.container():  # first: while a slider moves, the plot is what people wait for
        _draw_plot(result, cursor)
    with left:
        viewer.draw(result)
    with right:
        panel.draw(result, cursor)
    theme, recording = state.theme(), state.recording()
    lanes = state.workspace().cached(  # they stay while alpha and the like move
        "lanes",
        (state.workspace().version, recording, theme, cursor),
        lambda: lanes_figure(result, recording, theme=theme, cursor_row=cursor),
    )
    with st.container(height=LANES_PX if lanes.layout.height > LANES_PX else "content"):
        _clickable(lanes, "lanes")


def _draw_plot(result: Result, cursor: int) -> None:
    kind = choose_side_by_side("Plot over time", PLOTS, "plot_over_time", default="time")
    settings: dict[str, Any] = {"theme": state.theme(), "cursor_row": cursor}
    if kind == "losses":
        figure = loss_plot(result, state.recording(), **settings)
        words = LOSSES_TEXT
    else:
        figure = similarity_plot(result, state.recording(), layout=kind, **settings)
        words = SIMILARITY_TEXT
    _clickable(figure, "time_plot")
    st.caption(f"{words} Click to see the frame ({docs_link('Metrics', 'similarity')}).")


def _clickable(figure: Any, key: str) -> None:
    row = clicked_chart(figure, f"{key}_{state.recording()}", clicks=key)
    if row is not None:
        state.go_to(*state.place_of(int(row)))
        st.rerun(scope="fragment")
