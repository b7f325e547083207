"""Data page: open a comparison, and say in a banner why it cannot be opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import streamlit as st
from streamlit.delta_generator import DeltaGenerator

from nvcore.errors import MissingFactError, NvcoreError
from nvcore.inputs.session import Session
from ui.session import state
from ui.shell.messages import error_text
from ui.shell.navigate import ask_for_page
from ui.widgets.script import read_script
from ui.widgets.text import plain

_KEY: Final = "data_trouble"
_OPENED: Final = "data_opened"
_SHOWN_OPENING: Final = "data_opened_shown"
_SEE: Final = "see_opened"
_DRAWN: Final = "data_drawn"
WAYS: Final = "Open your own files or another comparison"
"""Label of the box with all ways to open something."""
WAYS_OPEN: Final = "data_ways"
"""Whether that box is unfolded."""
SESSION: Final = "session"
"""The part of the page that changes the open comparison, rather than opening another."""
MISSING_WORDS: Final = {
    "size": "the image size",
    "fps": "the frame rate",
    "frames": "which frames are evaluated",
}
"""What `MissingFactError` says is missing, in words."""
_TO_TOP = st.components.v2.component(
    "nvcore_to_top",
    js=read_script(Path(__file__).with_name("to_top.js")),
)
"""Scrolls to the top of the page: the buttons that open something are far below."""


@dataclass(frozen=True)
class Trouble:
    """Why something could not be opened, what it was called, and which inputs are missing."""

    text: str
    label: str
    facts: tuple[str, ...] = ()


def try_to_open(
    session: Session | Callable[[], Session], *, label: str, place: str = SESSION
) -> None:
    """Open a session, called `label` on the pages.

    If that fails, the run starts again and `draw_trouble` says why in this part of the page.
    """
    st.session_state.pop(_key(place), None)
    st.session_state[_OPENED] = place, label, state.workspace().n_opened
    try:
        state.open_session(session() if callable(session) else session, label=label)
    except MissingFactError as error:
        trouble = Trouble(_question(error.facts) or error_text(error), label, error.facts)
    except NvcoreError as error:
        trouble = Trouble(error_text(error), label)
    # only reached when it failed: opening something starts the run again
    st.session_state[_key(place)] = trouble
    st.rerun()


def new_place(draw: Callable[[], None]) -> DeltaGenerator:
    """A place on the page for one of its parts; emptied first where another comparison is open.

    Otherwise what was there would stay in sight under the new heading until it is replaced.
    """
    name = f"{_DRAWN}_{draw.__module__}"
    n_opened = state.workspace().n_opened
    is_other = st.session_state.get(name, n_opened) != n_opened
    st.session_state[name] = n_opened
    return st.empty().container() if is_other else st.container()


def trouble_of(place: str) -> Trouble | None:
    """What went wrong in this part of the page; None: nothing."""
    trouble: Trouble | None = st.session_state.get(_key(place))
    return trouble


def _trouble_keys() -> list[str]:
    """Where the session's state has the trouble of each part of the page that has one."""
    return [str(key) for key in st.session_state if str(key).startswith(f"{_KEY}_")]


def has_trouble() -> bool:
    """Whether something could not be opened, and the choice that made trouble is as it was."""
    return any(key != _key(SESSION) for key in _trouble_keys())


def forget_trouble(place: str) -> None:
    """To be called when the choice that made trouble has changed."""
    st.session_state.pop(_key(place), None)


def _opened() -> tuple[str, str] | None:
    """Part of the page in which something was opened since, and what it is called."""
    place, label, n_before = st.session_state.get(_OPENED, ("", "", 0))
    is_open = place and state.workspace().n_opened > n_before
    return (place, label) if is_open else None


def draw_outcome() -> None:
    """At the top of the page: what was opened, or could not be and is not what the page shows."""
    keys = _trouble_keys()
    opened = _opened()
    if opened is not None:
        for key in keys:
            del st.session_state[key]
        if opened[0] != SESSION:
            _draw_opened(opened[1])
        return
    for key in keys:
        trouble: Trouble = st.session_state[key]
        st.error(
            f"**Not opened: {plain(trouble.label) or 'nothing chosen'}.** {plain(trouble.text)}\n\n"
            f"Still open, and what this page is about: {plain(state.opened().label)}.",
            icon=":material/error:",
        )


def _draw_opened(label: str) -> None:
    """The next step, for as long as one stays on the page."""
    n_opened = state.workspace().n_opened
    is_first = st.session_state.get(_SHOWN_OPENING) != n_opened
    if not is_first and _SEE not in st.session_state:  # values of another page's widgets go
        del st.session_state[_OPENED]
        return
    st.session_state[_SHOWN_OPENING] = n_opened
    if is_first:
        st.session_state[WAYS_OPEN] = False
    st.success(
        f"**Opened: {plain(label)}.** Below: what to mind and what was read.{_on_thresholds()}",
        icon=":material/check_circle:",
    )
    st.button(
        "Next: see the comparison",
        type="primary",
        icon=":material/arrow_forward:",
        key=_SEE,
        on_click=ask_for_page,
        args=("overview",),
    )
    _TO_TOP(key="to_top", data={"opened": n_opened}, height=1)


def draw_trouble(place: str) -> None:
    """The banner that says why something could not be opened, or once that it was changed."""
    opened_in, label = _opened() or ("", "")
    if opened_in == place == SESSION:
        del st.session_state[_OPENED]
        st.success(
            f"Changed, and opened again: {plain(label)}. What to mind stands above.",
            icon=":material/check_circle:",
        )
    trouble = trouble_of(place)
    if trouble is not None:
        is_question = bool(trouble.facts)
        icon = ":material/help:" if is_question else ":material/error:"
        (st.warning if is_question else st.error)(plain(trouble.text), icon=icon)


def _on_thresholds() -> str:
    """That thresholds are still to be chosen, where there are scores."""
    settings = state.params()
    limits = (settings.threshold_x, settings.threshold_y)
    is_open = any(
        limit is None and state.score_span(name) is not None
        for name, limit in zip(state.systems(), limits, strict=True)
        if name is not None
    )
    if not is_open:
        return ""
    return (
        " Every detection counts, however low its score, until thresholds are set in the sidebar."
    )


def _question(facts: tuple[str, ...]) -> str:
    """The question to the user, without the command line's flags."""
    words = " and ".join(MISSING_WORDS[fact] for fact in facts if fact in MISSING_WORDS)
    return f"The files do not say {words}. Fill in the fields for it." if words else ""


def _key(place: str) -> str:
    return f"{_KEY}_{place}"
