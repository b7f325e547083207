"""Every figure can be taken away: as picture, drawing or table, by a menu of its own.

Where points can be clicked, keys do it as well; those over time mark the frame that the viewer
shows. The browser does it all, with what it has drawn: no figure costs the server anything for
that.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
_COMPONENT = st.components.v2.component("nvcore_figure_menu", js=read_script(FOLDER / "menu.js"))


def draw() -> None:
    """The invisible part of each page that gives its figures menu and keys; once on every page."""
    _COMPONENT(key="figure_menu", height=1)
