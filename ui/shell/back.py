"""The browser's Back button goes from page to page, not through every change of a parameter.

Streamlit makes an entry in the browser's history for each change of the address. Here one is made
for another page, recording or encounter only; any other change replaces the entry.
"""

from __future__ import annotations

from typing import Final

import streamlit as st

_SCRIPT: Final = """
const PLACES = ["recording", "encounter", "doc"];
export default function () {
  if (window.nvcoreHistory) return;
  window.nvcoreHistory = true;
  const push = window.history.pushState.bind(window.history);
  window.history.pushState = (state, title, url) => {
    const here = new URL(window.location.href);
    const next = new URL(url ?? here, here);
    const isSame = next.pathname === here.pathname && PLACES.every((name) => {
      const before = here.searchParams.get(name);
      // an address that names no place yet is completed, which is no step
      return before === null || before === next.searchParams.get(name);
    });
    if (isSame) window.history.replaceState(state, title, url);
    else push(state, title, url);
  };
}
"""
_COMPONENT = st.components.v2.component("nvcore_history", js=_SCRIPT)


def draw() -> None:
    """The invisible part of the page that looks after the history; on every page."""
    _COMPONENT(key="history", height=1)
