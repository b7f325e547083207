"""A page that is loaded again gets back what was open in its tab.

A reload starts a new Streamlit session. The tab keeps the workspace's token in the browser's
``sessionStorage``, which ends with the tab, and claims the workspace with it, unless that has been
closed or another page uses it.
"""

from __future__ import annotations

from typing import Final

import streamlit as st

from ui.session import state

KEY: Final = "tab"
_SCRIPT: Final = """
const NAME = "nvcore-workspace";
export default function ({ data, setTriggerValue }) {
  let kept = null;
  try { kept = sessionStorage.getItem(NAME); } catch { return; }
  if (kept === data.token) return;
  if (kept && !data.is_settled) setTriggerValue("claim", kept);
  else sessionStorage.setItem(NAME, data.token);
}
"""
_COMPONENT = st.components.v2.component("nvcore_tab", js=_SCRIPT)
_SETTLED: Final = "tab_is_settled"


def draw() -> None:
    """The invisible part of the page that remembers what the tab had open."""
    _COMPONENT(
        key=KEY,
        on_claim_change=_claim,
        height=1,
        data={
            "token": state.workspace().token,
            "is_settled": st.session_state.get(_SETTLED, False),
        },
    )


def _claim() -> None:
    token = st.session_state[KEY].claim
    st.session_state[_SETTLED] = True
    if isinstance(token, str):
        state.restore(token)
