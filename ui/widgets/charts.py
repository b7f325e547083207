"""Charts as every page draws them, and clicks in them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import plotly.graph_objects as go
import streamlit as st

from nvcore.figures.style import CONFIG
from ui.widgets.clicks import is_new_click


def draw_chart(figure: go.Figure, key: str, *, on_click: Callable[[], None] | None = None) -> None:
    """Draw a chart.

    Parameters
    ----------
    on_click
        Called when a point was clicked or the click was taken back, before the page is drawn
        again; see `ui.widgets.clicks.clicked_point`.
    """
    if on_click is None:
        st.plotly_chart(figure, theme=None, config=CONFIG, key=key)
        return
    st.plotly_chart(
        figure, theme=None, config=CONFIG, key=key, on_select=on_click, selection_mode="points"
    )


def clicked_chart(
    figure: go.Figure, key: str, *, clicks: str | None = None, alt: str | None = None
) -> Any:
    """Draw a chart, and return the `customdata` of a point clicked since it was last drawn.

    Parameters
    ----------
    clicks
        Charts that share this name share the memory of the last click; None: the key.
    alt
        What the chart shows, for those who cannot see it.

    Returns
    -------
    None where there is no new click.
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
