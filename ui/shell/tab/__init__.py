"""What the browser's tab does by itself: it remembers what was open, and how one goes back.

*Reload.* A reload starts a new Streamlit session. The tab keeps the workspace's token in the
browser's ``sessionStorage``, which ends with the tab, and claims the workspace with it, unless that
has been closed or another page uses it. The page from before the reload may be that other one for a
moment: the server hears of its end when it hears of it. So the claim is repeated for a while.

*Back.* Streamlit makes an entry in the browser's history for each change of the address. Here one
is made for another page, recording or encounter only; any other change replaces the entry.

*Theme.* Streamlit changes its own colours with the theme at once, and tells Python of it with the
next run only. The script is imported once for each document, however often the part is drawn, and
keeps the element that is watched as long: there is one observer, which ends with the document. Each
drawing says anew whom it tells. A clean-up by drawing would end the observer of the drawing after.
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
"""The last one comes after a minute: by then the server has noticed a connection that broke off."""
_MEMORY = st.components.v2.component(
    "nvcore_tab", js=read_script(Path(__file__).with_name("restore.js"))
)
_HISTORY = st.components.v2.component("nvcore_history", js=read_script(SCRIPTS / "history.js"))
_NARROW = st.components.v2.component("nvcore_narrow", js=read_script(SCRIPTS / "narrow.js"))
_THEME = st.components.v2.component("nvcore_theme", js=read_script(SCRIPTS / "theme.js"))


def draw_memory() -> None:
    """The invisible parts that remember what was open, and look after the history."""
    _MEMORY(
        key=KEY,
        on_claim_change=_claim,
        height=1,
        data={
            "token": state.workspace().token,
            "is_settled": store.TAB_IS_SETTLED.get(),
        },
    )
    _HISTORY(key="history", height=1, data={"start": START})


def _claim() -> None:
    claim(store.sent(KEY, "claim"))


def claim(token: object) -> None:
    """Go on with the workspace of that token; where another page has it, later claims try again."""
    n_claims = store.TAB_CLAIMS.get() + 1
    store.TAB_CLAIMS.set(n_claims)
    store.TAB_IS_SETTLED.set(
        not isinstance(token, str) or state.restore(token) or n_claims >= MOST_CLAIMS
    )


def follow_history() -> None:
    """Go to the frame of the address that Back or Forward led to, if one of them did.

    Parameters stay as they are, and a recording that is no longer open is passed over.
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
    """The invisible parts that fold the settings away where it is narrow, and watch the theme."""
    _NARROW(key="narrow", height=1)
    _THEME(key="theme", height=1, on_ground_change=_draw_anew)


def _draw_anew() -> None:
    """Nothing more: the run that follows draws in the theme of the browser."""
