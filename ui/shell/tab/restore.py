"""A page that is loaded again gets back what was open in its tab.

A reload starts a new Streamlit session. The tab keeps the workspace's token in the browser's
``sessionStorage``, which ends with the tab, and claims the workspace with it, unless that has been
closed or another page uses it. The page from before the reload may be that other one for a moment:
the server hears of its end when it hears of it. So the claim is repeated for a while.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import streamlit as st

from ui.session import state, store
from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
KEY: Final = "tab"
_COMPONENT = st.components.v2.component("nvcore_tab", js=read_script(FOLDER / "restore.js"))
MOST_CLAIMS: Final = 7
"""The last one comes after a minute: by then the server has noticed a connection that broke off."""


def draw() -> None:
    """The invisible part of the page that remembers what the tab had open."""
    _COMPONENT(
        key=KEY,
        on_claim_change=_claim,
        height=1,
        data={
            "token": state.workspace().token,
            "is_settled": store.TAB_IS_SETTLED.get(),
        },
    )


def _claim() -> None:
    claim(store.sent(KEY, "claim"))


def claim(token: object) -> None:
    """Go on with the workspace of that token; where another page has it, later claims try again."""
    n_claims = store.TAB_CLAIMS.get() + 1
    store.TAB_CLAIMS.set(n_claims)
    store.TAB_IS_SETTLED.set(
        not isinstance(token, str) or state.restore(token) or n_claims >= MOST_CLAIMS
    )
