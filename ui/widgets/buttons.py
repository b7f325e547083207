"""Buttons whose clicks are not lost.

Streamlit tells a script of a click in the one run that the click begins. If another widget ends
that run before it comes to the button, as a slider does that is still settling, nobody hears of it.
The last click is kept here until its button is drawn, or the page has been drawn to its end.
"""

from __future__ import annotations

from typing import Any

import streamlit as st

from ui.session import store
from ui.streamlit_inside.types import DeltaGenerator


def button(
    label: str,
    *,
    key: str,
    at: DeltaGenerator | None = None,
    disabled: bool = False,
    **options: Any,
) -> bool:
    """Whether it was clicked, to be asked once; `at` is where it stands, the rest Streamlit's."""
    draw = st.button if at is None else at.button
    draw(label, key=key, on_click=_keep, args=(key, label), disabled=disabled, **options)
    return _take(key, label) and not disabled


def submit_button(
    label: str, *, key: str, at: DeltaGenerator | None = None, **options: Any
) -> bool:
    """Whether the form was sent by it; as `button`."""
    draw = st.form_submit_button if at is None else at.form_submit_button
    draw(label, key=key, on_click=_keep, args=(key, label), **options)
    return _take(key, label)


def _keep(key: str, label: str) -> None:
    store.CLICKED_BUTTON.set((key, label))


def _take(key: str, label: str) -> bool:
    """Whether it is this that was clicked last, and said the same: it may be another's by now."""
    if store.CLICKED_BUTTON.get() != (key, label):
        return False
    store.CLICKED_BUTTON.pop()
    return True
