"""Navigation from page to page and to a frame."""

from __future__ import annotations

from typing import Final, NoReturn

import streamlit as st

from ui.session import state, store
from ui.shell import review

PAGES: Final = state.ROOT / "pages"


def open_frame(recording_index: int, row_in_recording: int) -> NoReturn:
    """Show a frame on the Timeline page, and close the list that is viewed there."""
    review.end()
    # writing the address here would add another entry to the browser's history
    state.go_to(recording_index, row_in_recording, writes=False)
    open_page("timeline")


def open_row(row: int) -> NoReturn:
    """Show a frame, given by its row of the frames table, on the Timeline page."""
    open_frame(*state.place_of(row))


def ask_for_page(name: str) -> None:
    """Go to a page in the next run. For buttons that are not drawn again."""
    store.NEXT_PAGE.set(name)


def follow_wish() -> None:
    """Go to the page requested by `ask_for_page`, if any."""
    name = store.NEXT_PAGE.pop()
    if name is not None:
        open_page(name)


def open_page(name: str, **address: str) -> NoReturn:
    """Go to a page with these address entries, keeping recording, frame and parameters."""
    if address:
        store.PAGE_LINK.set(address)
    st.switch_page(str(PAGES / f"{name}.py"))
