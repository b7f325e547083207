"""Charts as every page draws them, and clicks in them."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from html import unescape
from typing import Any, Literal

import plotly.graph_objects as go
import streamlit as st

from nvcore.figures.style import CONFIG, take_heading
from ui.session import state
from ui.widgets.clicks import is_new_click


def draw_chart(
    figure: go.Figure,
    key: str,
    *,
    on_click: Callable[[], None] | None = None,
    help: str | None = None,  # noqa: A002  # as Streamlit calls it
    of: str = "",
) -> None:
    """Draw a chart; `on_click` is called before the page when a point is clicked or released.

    `help` stands behind a question mark beside the heading; `of` says at the start of the subtitle
    what the page shows there, for those who see the figure alone.
    """
    figure = _ready(figure, of)
    alt = _draw_heading(figure, help_text=help)
    if on_click is None:
        st.plotly_chart(figure, theme=None, config=CONFIG, key=key, alt=alt)
        return
    st.plotly_chart(
        figure,
        theme=None,
        config=CONFIG,
        key=key,
        on_select=on_click,
        selection_mode="points",
        alt=alt,
    )


def clicked_chart(
    figure: go.Figure,
    key: str,
    *,
    clicks: str | None = None,
    alt: str | None = None,
    time_axis: Literal["x", "y"] | None = None,
    help: str | None = None,  # noqa: A002  # as Streamlit calls it
    of: str = "",
) -> Any:
    """Draw a chart; the `customdata` of a point clicked since then, None: no new click.

    Charts that share the name `clicks` share the memory of the last one. `alt` says what the chart
    shows, for those who cannot see it. Along `time_axis`, which is in seconds, the browser marks
    the frame that the viewer shows. `help` and `of` as of `draw_chart`.
    """
    figure = _ready(figure, of)
    heading = _draw_heading(figure, time_axis, help)
    chart = st.plotly_chart(
        figure,
        theme=None,
        config=CONFIG,
        key=key,
        on_select="rerun",
        selection_mode="points",
        alt=alt or heading,
    )
    points = chart["selection"]["points"]
    if points and is_new_click(clicks or key, points):
        return points[0]["customdata"]
    return None


def kept_figure(kind: str, key: Hashable, make: Callable[[], go.Figure]) -> go.Figure:
    """A figure, made anew when `key` changes (see `state.cached`), ready to be drawn."""
    return state.cached(kind, key, lambda: _ready(make()))


def _ready(figure: go.Figure, of: str = "") -> go.Figure:
    """The figure, its title and subtitle moved to ``layout.meta``, where the browser finds them.

    Itself if it is so already, as one without data is.
    """
    title, subtitle, *more = figure.layout.meta or take_heading(figure)
    if not subtitle.startswith(of):
        subtitle = "; ".join(filter(None, (of, subtitle)))
    meta = (title, subtitle, *more)
    if figure.layout.meta != meta:  # it may be drawn by others meanwhile
        figure.layout.meta = meta
    return figure


def _draw_heading(
    figure: go.Figure, time_axis: str | None = None, help_text: str | None = None
) -> str | None:
    """Draw title and subtitle as text of the page, which wraps; they leave the figure."""
    title, subtitle, *_ = figure.layout.meta
    meta = (title, subtitle, time_axis)
    if time_axis and tuple(figure.layout.meta) != meta:  # it may be drawn by others meanwhile
        figure.layout.meta = meta
    if not title:
        return unescape(subtitle) or None
    text = f'<div class="nv-figure"><p><strong>{title}</strong> <span>{subtitle}</span></p>'
    if help_text:  # between empty lines it is Streamlit's Markdown, whose links open as everywhere
        text += f'<details class="nv-help"><summary>?</summary>\n\n{help_text}\n\n</details>'
    st.markdown(f"{text}</div>", unsafe_allow_html=True)
    return unescape(f"{title}: {subtitle}" if subtitle else title)
