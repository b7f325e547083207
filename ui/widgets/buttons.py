"""Buttons that never lose clicks (see `ui.widgets.clicks`)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

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
    """Draw a button, and return True once after a click.

    `at` is its container. Other options are Streamlit's.
    """
    draw = st.button if at is None else at.button
    draw(label, key=key, on_click=keep_click, args=(key, label), disabled=disabled, **options)
    return bool(take_click(key) == label) and not disabled


def submit_button(
    label: str, *, key: str, at: DeltaGenerator | None = None, **options: Any
) -> bool:
    """Draw the button that sends a form, and return True once after a click (see `button`)."""
    draw = st.form_submit_button if at is None else at.form_submit_button
    draw(label, key=key, on_click=keep_click, args=(key, label), **options)
    return bool(take_click(key) == label)


MIME: Final = {
    "csv": "text/csv",
    "html": "text/html",
    "json": "application/json",
    "mp4": "video/mp4",
    "parquet": "application/vnd.apache.parquet",
    "toml": "application/toml",
    "zip": "application/zip",
}


def download(
    label: str,
    content: Callable[[], Any],
    name: str,
    *,
    key: str,
    at: DeltaGenerator | None = None,
    icon: str = "download",
    **options: Any,
) -> None:
    """Draw a button that downloads a file of this name. The content is made on the click."""
    (st if at is None else at).download_button(
        label,
        content,
        name,
        MIME[name.rpartition(".")[2]],
        on_click="ignore",
        icon=f":material/{icon}:",
        key=key,
        **options,
    )
