"""The recording selector."""

from __future__ import annotations

import streamlit as st

from nvcore.pictures.index import USUAL
from ui.session import state
from ui.widgets.text import plain


def recording_choice() -> None:
    """The recording selector; by which rule pictures show frames, where it is not the usual one."""
    names = state.recording_names()
    left, right = st.columns([2, 3], vertical_alignment="bottom")
    key = f"recording_choice_{state.workspace().n_opened}_{state.recording()}"
    recording = left.selectbox(
        "Recording",
        range(len(names)),
        index=state.recording(),
        format_func=lambda i: names[i],
        key=key,
    )
    if recording != state.recording():
        state.go_to(recording, 0)
        st.rerun()
    note = state.workspace().picture_notes.get(state.recording())
    if note not in USUAL:
        right.caption(plain(note or "This recording has no pictures: boxes are drawn on a blank."))
