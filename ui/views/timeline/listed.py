"""Timeline page: step through the boxes or frames that a finding lists, with the box marked."""

from __future__ import annotations

from typing import Final

import pandas as pd
import streamlit as st

from nvcore.tables.inputs import NO_ROW
from ui.session import state
from ui.shell import review
from ui.shell.messages import without_paths
from ui.shell.navigate import open_page
from ui.widgets.buttons import button
from ui.widgets.choices import draw_steps
from ui.widgets.text import plain
from ui.widgets.viewer import ListedBox

BOX: Final = ["x", "y", "w", "h"]


def box_in(recording: int) -> ListedBox | None:
    """Return the current entry's box for a recording's viewer, or None without a list."""
    walk = review.current()
    if walk is None:
        return None
    row = walk.frame_row
    where = state.place_of(row) if row != NO_ROW else (-1, -1)
    if where[0] != recording:
        return ListedBox(-1, None)
    x, y, w, h = (float(walk.entry[name]) for name in BOX)
    return ListedBox(where[1], None if pd.isna(x) else (x, y, w, h))


def draw() -> None:
    """Draw the finding, its current entry, and buttons to other entries, if a list is open."""
    walk = review.current()
    if walk is None:
        return
    with st.container(border=True, key="listed", gap=None):
        with st.container(horizontal=True, vertical_alignment="center", key="listed_head"):
            subject, text = review.subject_text(walk.finding), without_paths(walk.finding.message)
            st.caption(f"**{plain(subject)}:** {plain(text)}", width="stretch")
            if button(
                "Back to the list", key="listed_back", icon=":material/list:", type="tertiary"
            ):
                open_page("data")
            st.button(
                "Close",
                key="listed_close",
                icon=":material/close:",
                type="tertiary",
                on_click=review.end,
            )
        with st.container(horizontal=True, vertical_alignment="center", gap="medium"):
            draw_steps(walk.at, len(walk.cases), review.go_to, key="listed", width="content")
            st.markdown(_words(walk), width="content")
            if walk.frame_row not in (NO_ROW, state.row_in_all()):
                st.button(
                    "To its frame",
                    key="listed_again",
                    icon=":material/my_location:",
                    type="tertiary",
                    on_click=review.go_to,
                    args=(walk.at,),
                )


def _words(walk: review.Review) -> str:
    """Describe where the entry is, with the coordinates of its box."""
    entry = walk.entry
    parts = [f"{entry['recording']}, frame {entry['frame']}"]
    if walk.frame_row == NO_ROW:
        parts.append("which is not evaluated: there is nothing to show")
    if not pd.isna(entry["x"]):
        x, y, w, h = (f"{float(entry[name]):.0f}" for name in BOX)
        parts.append(f"box of {w} × {h} px at {x}, {y}")
    if not pd.isna(entry["track"]):
        parts.append(f"track {entry['track']}")
    if not pd.isna(entry["line"]):
        parts.append(f"line {entry['line']} of {without_paths(entry['file'])}")
    return plain("; ".join(parts))
