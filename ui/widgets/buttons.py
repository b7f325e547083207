"""Buttons whose clicks are not lost (see `ui.widgets.clicks`)."""

from __future__ import annotations

from typing import Any

import streamlit as st

from ui.streamlit_inside.types import DeltaGenerator
from ui.widgets.clicks import keep_click, take_click


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
    draw(label, key=key, on_click=keep_click, args=(key, label), disabled=disabled, **options)
    return bool(take_click(key) == label) and not disabled


def submit_button(
    label: str, *, key: str, at: DeltaGenerator | None = None, **options: Any
) -> bool:
    """Whether the form was sent by it; as `button`."""
    draw = st.form_submit_button if at is None else at.form_submit_button
    draw(label, key=key, on_click=keep_click, args=(key, label), **options)
    return bool(take_click(key) == label)
