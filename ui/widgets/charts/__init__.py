"""Charts of the pages, and clicks in them.

A Streamlit component around Plotly: Streamlit's own chart is drawn anew whenever its data change,
which takes several times as long. Every figure can be saved as picture, drawing or table, and
where points can be clicked, keys do it as well. All of that happens in the browser.
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
"""Height of title and subtitle where neither wraps."""


@dataclass(frozen=True)
class ReadyFigure:
    """A figure as Plotly's JSON, its height in pixels, and the HTML of its heading."""

    title: str
    subtitle: str
    height: int
    spec: str


@dataclass(frozen=True)
class Clicked:
    """A clicked point: its ``customdata`` and the number of its trace."""

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
    help: str | None = None,  # noqa: A002  # as Streamlit calls it
    of: str = "",
) -> None:
    """Draw a chart.

    Parameters
    ----------
    on_click
        Called before the page's script when a point is clicked or released.
    is_clicked
        Whether points can be clicked without `on_click`, too (`clicked_chart`).
    alt
        Alternative text, else the heading.
    time_axis
        Axis in seconds along which the browser marks the frame that the viewer shows.
    help
        Text behind a question mark beside the heading, with links as `docs_link` writes them.
    of
        Start of the subtitle: what the page shows, for those who see the figure alone.
    """
    ready = figure if isinstance(figure, ReadyFigure) else _ready(figure)
    subtitle = ready.subtitle
    if not subtitle.startswith(of):
        subtitle = "; ".join(filter(None, (of, subtitle)))
    _COMPONENT(
        key=key,
        height=ready.height + (HEADING_PX if ready.title else 0),  # until its script has come
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

    `more` as of `draw_chart`.
    """
    draw_chart(figure, key, is_clicked=True, **more)
    return take_click(key)


def kept_figure(
    kind: str, key: Hashable, make: Callable[[], go.Figure], *, most: int = 1
) -> ReadyFigure:
    """Return a figure ready to be drawn, made anew when `key` changes (see `state.cached`)."""
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
