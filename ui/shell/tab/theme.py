"""A change of the theme, by the browser or in Streamlit's menu, draws charts and viewer anew.

Streamlit changes its own colours at once, and tells Python of the theme with the next run only.

It imports the script once for each document, however often the part is drawn anew, and keeps the
element that is watched as long: there is one observer, which ends with the document. Each drawing
says anew whom it tells. A clean-up by drawing would end the observer of the drawing after it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
_COMPONENT = st.components.v2.component("nvcore_theme", js=read_script(FOLDER / "theme.js"))


def draw() -> None:
    """The invisible part of the page that asks for another run when the theme has changed."""
    _COMPONENT(key="theme", height=1, on_ground_change=_draw_anew)


def _draw_anew() -> None:
    """Nothing more: the run that follows draws in the theme of the browser."""
