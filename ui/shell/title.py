"""Title of the document, which tells browser tabs apart."""

from __future__ import annotations

from typing import Final

import streamlit as st

from nvcore.common.wording import one_line, shortened
from ui.session import state, store

NAME: Final = "nvcore"
MAX_SYSTEM: Final = 24
TIMELINE: Final = "timeline"


def last() -> str:
    """Return the previous run's title, which stays until this run sets another."""
    return store.TITLE.get() or NAME


def draw(page: str, path: str) -> None:
    """Set the document's title to that of a page, or on the Timeline of its frame."""
    what = _frame() if path == TIMELINE else page
    systems = "/".join(
        shortened(one_line(name), MAX_SYSTEM) for name in state.systems() if name is not None
    )
    title = " · ".join(part for part in (what or page, systems, NAME) if part)
    store.TITLE.set(title)
    st.set_page_config(page_title=title)


def follow_frame() -> None:
    """Set the document's title to the current frame's when only a part of a page runs again."""
    draw("", TIMELINE)


def _frame() -> str:
    recording = state.recording()
    if not len(state.frame_numbers(recording)):
        return ""
    time_s = state.opened().dataset.frames["time_s"].iloc[state.row_in_all()]
    return f"{one_line(state.recording_names()[recording])} {time_s:.2f} s"
