"""Data page: open the sample, an upload, a session file, or files of the local folder."""

from __future__ import annotations

import streamlit as st

from nvcore.errors import NvcoreError
from nvcore.session_file import read_session
from ui import data_local, data_upload, state
from ui.data_opening import draw_trouble, try_to_open
from ui.data_session import draw_session_form
from ui.local_files import LocalRoot, local_root
from ui.text import plain

SAMPLE_TEXT = (
    "Ten short night drives made by a program: pedestrians at the kerb, a child running, a "
    "cyclist, glare, frost. A far infrared and a near infrared camera see them, each with the "
    "weaknesses such cameras have. With pictures."
)


def draw() -> None:
    """The tabs."""
    st.header("Open another comparison")
    root, trouble = _root()
    titles = ["Sample", "Upload", "Session file", *(["Local folder"] if root else [])]
    if trouble:
        st.warning(plain(trouble), icon=":material/warning:")
    tabs = st.tabs(titles)
    with tabs[0]:
        _draw_sample()
    with tabs[1]:
        data_upload.draw()
    with tabs[2]:
        draw_session_form()
    if root is not None:
        with tabs[3]:
            data_local.draw(root)


def _root() -> tuple[LocalRoot | None, str]:
    try:
        return local_root(), ""
    except NvcoreError as error:
        return None, str(error)


def _draw_sample() -> None:
    st.markdown(SAMPLE_TEXT)
    draw_trouble("sample")
    if st.button("Open the sample recordings", key="open_sample"):
        try_to_open(lambda: read_session(state.SAMPLE), label=state.SAMPLE_LABEL, place="sample")
