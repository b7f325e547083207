"""Buttons on a failed page: remove uploaded pictures, go back to the start data, or start over."""

from __future__ import annotations

import streamlit as st

from nvcore.common.wording import count_text
from ui.session import state, store
from ui.session.sample import shown_in
from ui.session.uploads import remove_pictures
from ui.session.workspace import Workspace


def draw(*, is_fault: bool) -> None:
    """Draw the buttons that may help.

    Parameters
    ----------
    is_fault
        True if the program is to blame. Otherwise buttons appear only if this visitor has opened or
        sent something.
    """
    space = store.WORKSPACE.get()
    has_opened = space is not None and (space.n_opened > 1 or bool(space.stored))
    if not (is_fault or has_opened):
        return
    with st.container(key="way_out", horizontal=True):
        if space is not None and space.stored:
            st.button(
                f"Remove {count_text(len(space.stored), 'file')} of pictures",
                key="way_out_remove",
                help="The pictures and videos that were sent, or are not opened yet.",
                on_click=_remove,
                args=(space,),
            )
        if space is not None and has_opened:
            st.button(
                "Back to what the app started with",
                key="way_out_back",
                on_click=_go_back,
                args=(space,),
            )
        st.button(
            "Start over",
            key="way_out_anew",
            help="As if the page were opened for the first time: settings and files are forgotten.",
            on_click=_start_over,
        )


def _remove(space: Workspace) -> None:
    space.close_pictures()
    remove_pictures(space, list(space.stored))


def _go_back(space: Workspace) -> None:
    shown_in(space, state.shared_start().opened)


def _start_over() -> None:
    space = store.WORKSPACE.get()
    store.clear()
    st.query_params.clear()
    if space is not None:
        space.close()
