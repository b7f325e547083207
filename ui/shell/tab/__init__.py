"""Scripts of the browser's tab: restoring after a reload, history, narrow windows and theme.

*Reload.* A reload starts a new Streamlit session. The tab keeps the workspace's token in the
browser's ``sessionStorage``, which ends with the tab. The new session claims the workspace with it,
unless the workspace is closed or used by another page. That may still be the page from before the
reload, since the server notices its end with a delay. So the claim is repeated for a while.

*Back.* Streamlit adds an entry to the browser's history for each change of the address. Here only
another page, recording or encounter adds one. Any other change replaces the current entry.

*Theme.* Streamlit applies a changed theme at once, but tells Python only in the next run. The
script is imported once per document, however often it is drawn. Its only observer lasts as long as
the document, and each drawing sets anew which component it notifies. A clean-up by one drawing
would end the observer of the next drawing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from ui.session import state, store
from ui.session.address import read_place
from ui.shell.pages import START
from ui.streamlit_inside import SCRIPTS
from ui.streamlit_inside.sessions import was_led_by_history
from ui.widgets.script import read_script

KEY: Final = "tab"
MOST_CLAIMS: Final = 7
"""The last claim comes after a minute, when the server has noticed a broken connection."""
_MEMORY = st.components.v2.component(
    "nvcore_tab", js=read_script(Path(__file__).with_name("restore.js"))
)
_HISTORY = st.components.v2.component("nvcore_history", js=read_script(SCRIPTS / "history.js"))
_NARROW = st.components.v2.component("nvcore_narrow", js=read_script(SCRIPTS / "narrow.js"))
_THEME = st.components.v2.component("nvcore_theme", js=read_script(SCRIPTS / "theme.js"))


def draw_memory() -> None:
    """Draw the invisible components that remember the workspace and manage the history."""
    _MEMORY(
        key=KEY,
        on_claim_change=_claim,
        height=1,
        data={"token": state.workspace().token, "is_settled": store.TAB_IS_SETTLED.get()},
    )
    _HISTORY(key="history", height=1, data={"start": START})


def _claim() -> None:
    claim(store.sent(KEY, "claim"))


def claim(token: object) -> None:
    """Take over the workspace of that token. If another page uses it, later claims try again."""
    n_claims = store.TAB_CLAIMS.get() + 1
    store.TAB_CLAIMS.set(n_claims)
    store.TAB_IS_SETTLED.set(
        not isinstance(token, str) or state.restore(token) or n_claims >= MOST_CLAIMS
    )


def follow_history() -> None:
    """Go to the frame in the address if the browser's Back or Forward led to it.

    Parameters stay as they are, and a recording that is no longer open is ignored.
    """
    if not was_led_by_history():
        return
    query = st.query_params.to_dict()
    store.PAGE_LINK.set(query)
    names = state.recording_names()
    if query.get("recording") in names:
        numbers = state.frame_numbers
        place, _ = read_place(query["recording"], query.get("frame"), names, numbers)
        state.go_to(*place, writes=False)


def draw_window() -> None:
    """Draw the invisible components that fold the sidebar in narrow windows and watch the theme."""
    _NARROW(key="narrow", height=1)
    _THEME(key="theme", height=1, on_ground_change=_draw_anew)


def _draw_anew() -> None:
    """Do nothing. The run that follows draws in the browser's theme."""
