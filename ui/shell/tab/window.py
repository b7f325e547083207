"""The window: settings folded away where it is narrow, everything drawn anew in another theme.

Streamlit changes its own colours with the theme at once, and tells Python of it with the next run
only. Its script is imported once for each document, however often the part is drawn, and keeps the
element that is watched as long: there is one observer, which ends with the document. Each drawing
says anew whom it tells. A clean-up by drawing would end the observer of the drawing after it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
_NARROW = st.components.v2.component("nvcore_narrow", js=read_script(FOLDER / "narrow.js"))
_THEME = st.components.v2.component("nvcore_theme", js=read_script(FOLDER / "theme.js"))


def draw() -> None:
    """The invisible parts: one folds the settings away, once in a tab; one asks for another run."""
    _NARROW(key="narrow", height=1)
    _THEME(key="theme", height=1, on_ground_change=_draw_anew)


def _draw_anew() -> None:
    """Nothing more: the run that follows draws in the theme of the browser."""
