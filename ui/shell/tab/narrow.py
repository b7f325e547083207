"""In a narrow window the settings begin folded away, so that results have room."""

from __future__ import annotations

from typing import Final

import streamlit as st

_SCRIPT: Final = """
const NARROW_PX = 1100;
const FOLD = '[data-testid="stSidebarCollapseButton"] button[aria-expanded="true"]';
export default function () {
  if (window.nvcoreNarrow) return;
  window.nvcoreNarrow = true;
  if (window.innerWidth < NARROW_PX) document.querySelector(FOLD)?.click();
}
"""
_COMPONENT = st.components.v2.component("nvcore_narrow", js=_SCRIPT)


def draw() -> None:
    """The invisible part of the page that folds the settings away, once in a tab."""
    _COMPONENT(key="narrow", height=1)
