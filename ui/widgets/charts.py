"""Charts as every page draws them, and clicks in them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import plotly.graph_objects as go
import streamlit as st

from nvcore.figures.style import CONFIG
from ui.widgets.clicks import is_new_click


def draw_chart(figure: go.Figure, key: str, *, on_click: Callable[[], None] | None = None) -> None:
    """Draw a chart; `on_click` is called before the page when a point is clicked or released."""
    if on_click is None:
        st.plotly_chart(figure, theme=None, config=CONFIG, key=key)
        return
    st.plotly_chart(
        figure, theme=None, config=CONFIG, key=key, on_select=on_click, selection_mode="points"
    )


def clicked_chart(
    figure: go.Figure, key: str, *, clicks: str | None = None, alt: str | None = None
) -> Any:
    """Draw a chart; the `customdata` of a point clicked since then, None: no new click.

    Charts that share the name `clicks` share the memory of the last one. `alt` says what the chart
    shows, for those who cannot see it.
    """
    chart = st.plotly_chart(
        figure,
        theme=None,
        config=CONFIG,
        key=key,
        on_select="rerun",
        selection_mode="points",
        alt=alt,
    )
    points = chart["selection"]["points"]
    if points and is_new_click(clicks or key, points):
        return points[0]["customdata"]
    return None
