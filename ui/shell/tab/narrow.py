"""In a narrow window the settings begin folded away, so that results have room; in no other."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
_COMPONENT = st.components.v2.component("nvcore_narrow", js=read_script(FOLDER / "narrow.js"))


def draw() -> None:
    """The invisible part of the page that folds the settings away, once in a tab."""
    _COMPONENT(key="narrow", height=1)
