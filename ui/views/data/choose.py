"""Data page: open the sample, an upload, a session file, or files of the local folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final

import streamlit as st
from streamlit.typing import UploadedFile

from nvcore.common.errors import InputError, NvcoreError
from nvcore.inputs.session import Session
from ui.access.files import LocalRoot, local_root
from ui.session import state, store
from ui.session.opening import uploaded_session
from ui.session.uploads import new_upload, refuse_equal_names, store_annotations
from ui.settings.start import start_file
from ui.views.data import local, upload
from ui.views.data.inputs import sent_pictures
from ui.views.data.missing_inputs import MissingInputs, ask_for_missing
from ui.views.data.opening import (
    WAYS,
    draw_trouble,
    forget_outcome,
    has_trouble,
    scroll_if_asked,
    try_to_open,
)
from ui.widgets.buttons import button
from ui.widgets.text import plain

SAMPLE_TEXT = (
    "Ten short night drives made by a program: pedestrians at the kerb, a child running, a "
    "cyclist, glare, frost. A far infrared and a near infrared camera see them, each with the "
    "weaknesses such cameras have. With pictures."
)
SIGNS_TEXT = (
    "Three short drives past speed signs, made by a program, too. Two systems read the limits, and "
    "each makes its own mistakes. With pictures and the speed of the car."
)


def draw() -> None:
    """Draw all ways to open something, folded unless something is left to do there."""
    if not store.WAYS_OPEN.is_set:  # the page is new
        store.WAYS_OPEN.set(has_trouble() or upload.has_lost(state.workspace()))
    with st.expander(WAYS, key=store.WAYS_OPEN.key, on_change="rerun"):
        _draw_tabs()
    scroll_if_asked()


def _draw_tabs() -> None:
    root, trouble = _root()
    tabs: dict[str, Callable[[], None]] = {"Upload": upload.draw}
    if root is not None:
        tabs["Local folder"] = partial(local.draw, root)
    tabs |= {"Session file": draw_session_form, "Sample": _draw_sample}
    if start_file() is not None:
        tabs["Start"] = _draw_start
    if trouble:
        st.warning(plain(trouble), icon=":material/warning:")
    for tab, draw_tab in zip(st.tabs(list(tabs)), tabs.values(), strict=True):
        with tab:
            draw_tab()


def _root() -> tuple[LocalRoot | None, str]:
    try:
        return local_root(), ""
    except NvcoreError as error:
        return None, str(error)


def _draw_start() -> None:
    start = state.shared_start().opened
    st.markdown(f"The comparison that this app was started with: **{plain(start.label)}**.")
    draw_trouble("start")
    if button("Open it again", key="open_start"):
        try_to_open(start.session, label=start.label, place="start")


def _draw_sample() -> None:
    st.markdown(SAMPLE_TEXT)
    draw_trouble("sample")
    if button("Open the sample recordings", key="open_sample"):
        try_to_open(state.sample_session, label=state.SAMPLE_LABEL, place="sample")
    st.markdown(SIGNS_TEXT)
    if button("Open the drives past speed signs", key="open_signs"):
        signs = partial(state.sample_session, state.SIGNS, state.SIGNS_LABEL)
        try_to_open(signs, label=state.SIGNS_LABEL, place="sample")


PLACE: Final = "session_file"
_changed = partial(forget_outcome, PLACE)


def draw_session_form() -> None:
    """Draw the form for a session file. Its button opens the session."""
    st.caption(
        "A session file (TOML) names ground truth, systems, thresholds, corrections and settings. "
        "Send it with the files it names: they are found by their names, wherever they lay before. "
        "Pictures that were sent under Upload are found as well."
    )
    file = st.file_uploader("Session file", type=["toml"], key="session_file", on_change=_changed)
    others = st.file_uploader(
        "The files that it names, or a ZIP archive of their folder",
        accept_multiple_files=True,
        key="session_files",
        on_change=_changed,
    )
    facts = ask_for_missing(PLACE, sent_pictures(state.workspace()).values())
    draw_trouble(PLACE)
    if button("Open this session", key="open_session_file", type="primary"):
        label = "" if file is None else file.name
        try_to_open(lambda: _session(file, others, facts), label=label, place=PLACE)


def _session(
    file: UploadedFile | None, others: Sequence[UploadedFile], facts: MissingInputs
) -> Session:
    if file is None:
        raise InputError("Choose the session file first.")
    refuse_equal_names(others)
    space = state.workspace()
    folder = new_upload(space)
    paths = store_annotations(space, folder, "files", others)
    content = bytes(file.getbuffer())
    return facts.added_to(uploaded_session(content, folder, paths, space.sent))
