"""The browser's Back button goes from page to page, not through every change of a parameter.

Streamlit makes an entry in the browser's history for each change of the address. Here one is made
for another page, recording or encounter only; any other change replaces the entry.
"""

from __future__ import annotations

from typing import Final

import streamlit as st
from streamlit.runtime.scriptrunner import get_script_run_ctx

from ui.session import state
from ui.session.address import read_place
from ui.shell.pages import START

_SCRIPT: Final = """
const PLACES = ["recording", "encounter", "doc"];
const ALWAYS = "recording"; // of every address that is written
const LEAVING_MS = 3000;
const MAY_END = ["encounter"]; // none is open: no place of its own
const START = new RegExp("/START$"); // the page that is open without a name, too
export default function () {
  if (window.nvcoreHistory) return;
  window.nvcoreHistory = true;
  const push = window.history.pushState.bind(window.history);
  const replace = window.history.replaceState.bind(window.history);
  let leaving = null;
  let last = null;
  const stays = () => {
    leaving = null;
    if (last) replace(...last);
  };
  window.history.pushState = (state, title, url) => {
    const here = new URL(window.location.href);
    const next = new URL(url ?? here, here);
    const isSamePage = next.pathname.replace(START, "/") === here.pathname.replace(START, "/");
    // a page that a button leaves is emptied first, and written for the next page: it keeps its
    // address to come back to
    if (isSamePage && here.searchParams.has(ALWAYS) && next.search === "") {
      clearTimeout(leaving);
      leaving = setTimeout(stays, LEAVING_MS);
      last = null;
      return;
    }
    if (isSamePage && leaving !== null) {
      last = [state, title, url];
      return;
    }
    clearTimeout(leaving);
    leaving = null;
    const isSame = isSamePage && PLACES.every((name) => {
      const before = here.searchParams.get(name);
      // an address that names no place yet is completed, which is no step
      const after = next.searchParams.get(name);
      return before === null || before === after || (after === null && MAY_END.includes(name));
    });
    if (isSame) replace(state, title, url);
    else push(state, title, url);
  };
}
"""
_COMPONENT = st.components.v2.component("nvcore_history", js=_SCRIPT.replace("/START", f"/{START}"))


def draw() -> None:
    """The invisible part of the page that looks after the history; on every page."""
    _COMPONENT(key="history", height=1)


def follow() -> None:
    """Go to the frame of the address that Back or Forward led to, if one of them did.

    Parameters stay as they are, and a recording that is no longer open is passed over.
    """
    context = get_script_run_ctx(suppress_warning=True)
    if context is None or not context.is_history_navigation:
        return
    query = st.session_state["page_link"] = st.query_params.to_dict()
    names = state.recording_names()
    if query.get("recording") in names:
        numbers = state.frame_numbers
        place, _ = read_place(query["recording"], query.get("frame"), names, numbers)
        state.go_to(*place, writes=False)


def page_link() -> dict[str, str] | None:
    """The address that led to the page, or what another page asks it for; None: neither.

    Returned once: what a person chooses on the page afterwards holds.
    """
    link: dict[str, str] | None = st.session_state.pop("page_link", None)
    return link
