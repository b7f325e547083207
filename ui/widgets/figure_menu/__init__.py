"""Every figure can be taken away: as picture, drawing or table, by a menu of its own.

The browser does it, with what it has drawn: no figure costs the server anything for its menu.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import streamlit as st

from nvcore.figures.style import CONFIG

CONFIG_WITH_EXPORT: Final[dict[str, Any]] = {
    **CONFIG,
    "displayModeBar": True,
    "modeBarButtons": [["toImage"]],
}
"""Plotly's tool bar is there with the one button that the menu presses; the style hides it."""

_COMPONENT = st.components.v2.component(
    "nvcore_figure_menu",
    js=(Path(__file__).parent / "menu.js").read_text(encoding="utf-8"),
)


def draw() -> None:
    """The invisible part of the page that gives each figure its menu; once on every page."""
    _COMPONENT(key="figure_menu", height=1)
