"""Storage for clicks, so that none is lost.

Streamlit reports a click only in the run that it starts. If another widget ends that run before it
reaches the clicked widget, as a settling slider does, the click would be lost. Therefore the last
click is kept until it is taken, or the page has been drawn to its end.
"""

from __future__ import annotations

from typing import Any

from ui.session import store


def keep_click(key: str, value: Any) -> None:
    """Store the value that was clicked in the widget with that key."""
    store.CLICKED.set((key, value))


def take_click(key: str) -> Any:
    """Return the value that was clicked in the widget, once, or None."""
    clicked_key, value = store.CLICKED.get() or (None, None)
    if clicked_key != key:
        return None
    store.CLICKED.pop()
    return value
