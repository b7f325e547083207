"""Charts as every page draws them, and clicks in them.

A Streamlit component around Plotly: a figure of Streamlit's own is thrown away and drawn anew
whenever its data change, which takes several times as long. Every figure can be taken away, as
picture, drawing or table, and where points can be clicked, keys do it as well: the browser does it
all with what it has drawn, and it costs the server nothing.
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
    """A figure as the browser takes it, and what the page says above it.

    Attributes
    ----------
    title, subtitle
        HTML.
    height
        Pixels.
    spec
        Plotly's JSON.
    """

    title: str
    subtitle: str
    height: int
    spec: str


@dataclass(frozen=True)
class Clicked:
    """A point that was clicked: its ``customdata`` and its trace."""

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
    """Draw a chart; `on_click` is called before the page when a point is clicked or released.

    `help` stands behind a question mark beside the heading, text with links as `docs_link` writes
    them; `of` says at the start of the subtitle what the page shows there, for those who see the
    figure alone. `alt` says what the chart shows, for those who cannot see it. Along `time_axis`,
    which is in seconds, the browser marks the frame that the viewer shows.
    """
    ready = figure if isinstance(figure, ReadyFigure) else _ready(figure)
    subtitle = ready.subtitle
    if not subtitle.startswith(of):
        subtitle = "; ".join(filter(None, (of, subtitle)))
    is_clicked = is_clicked or on_click is not None
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
            "isClicked": is_clicked,
            "plotly": f"{base_path()}{PLOTLY}",
        },
        on_clicked_change=partial(_tell, key, on_click),
    )


def clicked_chart(figure: go.Figure | ReadyFigure, key: str, **more: Any) -> Any:
    """Draw a chart; the ``customdata`` of a point clicked since the last call, None: no click.

    `more` as of `draw_chart`.
    """
    draw_chart(figure, key, is_clicked=True, **more)
    return take_click(key)


def kept_figure(
    kind: str, key: Hashable, make: Callable[[], go.Figure], *, most: int = 1
) -> ReadyFigure:
    """A figure, made anew when `key` changes (see `state.cached`), ready to be drawn."""
    return state.cached(kind, key, lambda: _ready(make()), most=most)


def _ready(figure: go.Figure) -> ReadyFigure:
    title, subtitle, *_ = figure.layout.meta or take_heading(figure)
    figure.layout.meta = (title, subtitle)  # it may be drawn again
    return ReadyFigure(
        title, subtitle, int(figure.layout.height), plotly.io.to_json(figure, validate=False)
    )


def _tell(key: str, on_click: Callable[[Clicked], None] | None) -> None:
    """Pass on what was clicked, if a browser can have meant it."""
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
