"""Clicks that are not lost.

Streamlit tells a script of a click in the one run that the click begins. If another widget ends
that run before it comes to what was clicked, as a slider does that is still settling, nobody hears
of it. The last click is kept until it is asked for, or the page has been drawn to its end.
"""

from __future__ import annotations

from typing import Any

from ui.session import store


def keep_click(key: str, value: Any) -> None:
    """What was clicked in the widget with that key."""
    store.CLICKED.set((key, value))


def take_click(key: str) -> Any:
    """What was clicked in the widget, once; None: nothing."""
    clicked_key, value = store.CLICKED.get() or (None, None)
    if clicked_key != key:
        return None
    store.CLICKED.pop()
    return value
