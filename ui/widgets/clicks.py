"""Clicks that are not lost.

Streamlit tells a script of a click in the one run that the click begins. If another widget ends
that run before it comes to what was clicked, as a slider does that is still settling, nobody hears
of it. The last click is kept here until it is asked for, or the page has been drawn to its end.
"""

from __future__ import annotations

from typing import Any, Final

import streamlit as st

_CLICKED: Final = "clicked"


def keep_click(key: str, value: Any) -> None:
    """What was clicked in the widget with that key."""
    st.session_state[_CLICKED] = key, value


def take_click(key: str) -> Any:
    """What was clicked in the widget, once; None: nothing."""
    clicked_key, value = st.session_state.get(_CLICKED) or (None, None)
    if clicked_key != key:
        return None
    forget_clicks()
    return value


def forget_clicks() -> None:
    """At the end of a page, also of one that failed: what was clicked is no longer there."""
    st.session_state.pop(_CLICKED, None)
