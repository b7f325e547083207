"""From one page to another, at a frame."""

from __future__ import annotations

from typing import Final, NoReturn

import streamlit as st

from ui import state

PAGES: Final = state.ROOT / "pages"


def open_frame(recording_index: int, row_in_recording: int) -> NoReturn:
    """Show a frame on the Timeline page."""
    state.go_to(recording_index, row_in_recording)
    open_page("timeline")


def open_row(row: int) -> NoReturn:
    """Show a frame, given by its row of the frames table, on the Timeline page."""
    open_frame(*state.place_of(row))


def open_page(name: str) -> NoReturn:
    """Go to a page; recording, frame and parameters stay."""
    st.switch_page(str(PAGES / f"{name}.py"))
