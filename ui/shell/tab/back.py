"""The browser's Back button goes from page to page, not through every change of a parameter.

Streamlit makes an entry in the browser's history for each change of the address. Here one is made
for another page, recording or encounter only; any other change replaces the entry.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx

from ui.session import state, store
from ui.session.address import read_place
from ui.shell.pages import START
from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent

_COMPONENT = st.components.v2.component("nvcore_history", js=read_script(FOLDER / "back.js"))


def draw() -> None:
    """The invisible part of the page that looks after the history; on every page."""
    _COMPONENT(key="history", height=1, data={"start": START})


def follow() -> None:
    """Go to the frame of the address that Back or Forward led to, if one of them did.

    Parameters stay as they are, and a recording that is no longer open is passed over.
    """
    context = get_script_run_ctx(suppress_warning=True)
    if context is None or not context.is_history_navigation:
        return
    query = st.query_params.to_dict()
    store.PAGE_LINK.set(query)
    names = state.recording_names()
    if query.get("recording") in names:
        numbers = state.frame_numbers
        place, _ = read_place(query["recording"], query.get("frame"), names, numbers)
        state.go_to(*place, writes=False)
