"""Data page: open a session file together with the files that it names."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import streamlit as st

from nvcore.errors import InputError
from nvcore.session import Session
from ui import state
from ui.data_facts import Facts, draw_facts, forget_facts
from ui.data_inputs import sent_pictures
from ui.data_opening import draw_trouble, forget_trouble, try_to_open
from ui.opening import uploaded_session
from ui.uploads import PICTURES, SentFile, new_upload, store_annotations

PLACE: Final = "session_file"


def draw_session_form() -> None:
    """The form; its button opens the session."""
    st.caption(
        "A session file (TOML) names ground truth, systems, thresholds, corrections and settings. "
        "Send it with the files it names: they are found by their names, wherever they lay before. "
        "Pictures that were sent under Upload are found as well."
    )
    file = st.file_uploader("Session file", type=["toml"], key="session_file", on_change=_changed)
    others = st.file_uploader(
        "The files that it names, or a ZIP archive of their folder", accept_multiple_files=True,
        key="session_files", on_change=_changed,
    )  # fmt: skip
    facts = draw_facts(PLACE, sent_pictures(state.workspace()).values())
    draw_trouble(PLACE)
    if st.button("Open this session", key="open_session_file", type="primary"):
        label = "" if file is None else file.name
        try_to_open(lambda: _session(file, others, facts), label=label, place=PLACE)


def _changed() -> None:
    forget_trouble(PLACE)
    forget_facts(PLACE)


def _session(file: SentFile | None, others: Sequence[SentFile], facts: Facts) -> Session:
    if file is None:
        raise InputError("Choose the session file first.")
    space = state.workspace()
    folder = new_upload(space)
    paths = store_annotations(space, folder, "files", others)
    content = bytes(file.getbuffer())
    return facts.added_to(uploaded_session(content, folder, paths, space.folder / PICTURES))
