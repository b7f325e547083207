"""Charts of the pages, and clicks in them.

This is a Streamlit component around Plotly. Streamlit's own chart is recreated whenever its data
change, which takes several times as long. Every figure can be saved as picture, drawing or table,
and clickable points also respond to keys. All of that happens in the browser.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, Literal

import plotly.graph_objects as go
import plotly.io
import streamlit as st

from nvcore.figures.style import CONFIG, take_heading
from ui.session import state, store
from ui.session.routes import PLOTLY
from ui.settings.start import base_path
from ui.widgets.clicks import keep_click, take_click
from ui.widgets.script import read_script

_COMPONENT = st.components.v2.component(
    "nvcore_chart", js=read_script(Path(__file__).parent / "chart.js"), isolate_styles=False
)

HEADING_PX: Final = 40
"""Height of title and subtitle if neither wraps."""


@dataclass(frozen=True)
class ReadyFigure:
    """Figure as Plotly's JSON, its height in pixels, and the HTML of its heading."""

    title: str
    subtitle: str
    height: int
    spec: str


@dataclass(frozen=True)
class Clicked:
    """Clicked point: its ``customdata`` and the number of its trace."""

    value: Any
    curve: int


def draw_chart(
    figure: go.Figure | ReadyFigure,
    key: str,
    *,
    on_click: Callable[[Clicked], None] | None = None,
    is_clicked: bool = False,
    alt: str | None = None,
    time_axis: Literal["x", "y"] | None = None,
    help: str | None = None,  # noqa: A002  # Streamlit's name
    of: str = "",
) -> None:
    """Draw a chart.

    Parameters
    ----------
    on_click
        Called before the page's script when a point is clicked or released.
    is_clicked
        Whether points can be clicked even without `on_click` (see `clicked_chart`).
    alt
        Alternative text. None: the heading.
    time_axis
        Axis in seconds along which the browser marks the frame that the viewer shows.
    help
        Text behind a question mark beside the heading, with links as from `docs_link`.
    of
        Start of the subtitle: content of the page, for those who see the figure alone.
    """
    ready = figure if isinstance(figure, ReadyFigure) else _ready(figure)
    subtitle = ready.subtitle
    if not subtitle.startswith(of):
        subtitle = "; ".join(filter(None, (of, subtitle)))
    _COMPONENT(
        key=key,
        height=ready.height + (HEADING_PX if ready.title else 0),  # until its script has loaded
        data={
            "spec": ready.spec,
            "height": ready.height,
            "config": CONFIG,
            "meta": [ready.title, subtitle, time_axis],
            "help": help,
            "alt": alt,
            "isClicked": is_clicked or on_click is not None,
            "plotly": f"{base_path()}{PLOTLY}",
        },
        on_clicked_change=partial(_tell, key, on_click),
    )


def clicked_chart(figure: go.Figure | ReadyFigure, key: str, **more: Any) -> Any:
    """Draw a chart and return ``customdata`` of a point clicked since the last call, or None.

    Options in `more` are those of `draw_chart`.
    """
    draw_chart(figure, key, is_clicked=True, **more)
    return take_click(key)


def kept_figure(
    kind: str, key: Hashable, make: Callable[[], go.Figure], *, most: int = 1
) -> ReadyFigure:
    """Return a figure ready to draw, recreated when `key` changes (see `state.cached`)."""
    return state.cached(kind, key, lambda: _ready(make()), most=most)


def _ready(figure: go.Figure) -> ReadyFigure:
    title, subtitle, *_ = figure.layout.meta or take_heading(figure)
    figure.layout.meta = (title, subtitle)  # it may be drawn again
    spec = plotly.io.to_json(figure, validate=False)
    return ReadyFigure(title, subtitle, int(figure.layout.height), spec)


def _tell(key: str, on_click: Callable[[Clicked], None] | None) -> None:
    """Pass on a click, unless its message is malformed."""
    clicked = store.sent(key, "clicked")
    if not isinstance(clicked, Mapping) or type(clicked.get("curve")) is not int:
        return
    value = clicked.get("value")
    if value is None:
        return
    if on_click is None:
        keep_click(key, value)
    else:
        on_click(Clicked(value, clicked["curve"]))
