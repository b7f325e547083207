"""Export page: an address that opens the app in its current state."""

from __future__ import annotations

from dataclasses import replace
from typing import Final
from urllib.parse import urlencode

import streamlit as st

from nvcore.inputs.session import Session
from nvcore.settings.params import Params
from ui.session import state
from ui.widgets.text import plain

PLACES: Final = {"timeline": "Timeline, at the current frame", "": "Overview"}
PAGE: Final = "export"
NO_STATE: Final = ("doc", "category")
"""Address entries that are useless on other pages."""

COMPLETE: Final = "It opens {} with these parameters, for everybody who can open this app."
SAMPLE: Final = "the sample recordings"
INCOMPLETE: Final = (
    "**Works in this tab only.** The files that are open belong to it: elsewhere the link opens {} "
    "with these parameters. To let somebody else see this comparison, send `session.toml` with its "
    "input files."
)


def draw() -> None:
    """Draw the link to copy, and its limits."""
    st.header("Link")
    place = st.segmented_control(
        "The link opens",
        list(PLACES),
        default="timeline",
        format_func=PLACES.__getitem__,
        required=True,
        key="export_place",
    )
    params = state.link_to(state.recording(), state.row()) if place else dict(st.query_params)
    start = state.shared_start().opened
    name = SAMPLE if start.label == state.SAMPLE_LABEL else plain(start.label)
    # no address holds corrections of the inputs
    is_complete = _inputs(state.opened().session) == _inputs(start.session)
    if not is_complete:
        st.warning(INCOMPLETE.format(name), icon=":material/tab:")
    st.code(link(st.context.url or "", place, params), language=None, wrap_lines=True)
    if is_complete:
        st.caption(COMPLETE.format(name))


def link(address: str, page: str, params: dict[str, str]) -> str:
    """Return the address of a page, given that of the Export page and the parameters.

    Examples
    --------
    >>> link("http://localhost:8501/nv/export", "timeline", {"alpha": "0.5", "doc": "report"})
    'http://localhost:8501/nv/timeline?alpha=0.5'
    """
    start = address.rstrip("/").removesuffix(f"/{PAGE}")
    state_params = {name: value for name, value in params.items() if name not in NO_STATE}
    return f"{start}/{page}" + (f"?{urlencode(state_params)}" if state_params else "")


def _inputs(session: Session) -> Session:
    """Return the session without what an address holds: systems, tags, thresholds, parameters."""
    systems = tuple(replace(system, threshold=None) for system in session.systems)
    return replace(
        session,
        systems=systems,
        x=None,
        y=None,
        only_tags=(),
        params=Params(),
        protocol=state.protocol(),
    )
