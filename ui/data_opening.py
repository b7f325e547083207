"""Data page: open a comparison, and say in a banner why it cannot be opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import streamlit as st

from nvcore.errors import MissingFactError, NvcoreError
from nvcore.session import Session
from ui import state
from ui.navigate import ask_for_page
from ui.public import public
from ui.text import plain

_KEY: Final = "data_trouble"
_OPENED: Final = "data_opened"
FACTS: Final = {
    "size": "the image size",
    "fps": "the frame rate",
    "frames": "which frames are evaluated",
}
"""Facts of `MissingFactError` in words."""


@dataclass(frozen=True)
class Trouble:
    """Why something could not be opened, what it was called, and which facts would help."""

    text: str
    label: str
    facts: tuple[str, ...] = ()


def try_to_open(
    session: Session | Callable[[], Session], *, label: str, place: str = "session"
) -> None:
    """Open a session; if that fails, the run starts again and `draw_trouble` says why.

    Parameters
    ----------
    session
        The session, or what makes it.
    label
        What it is called on the pages.
    place
        Part of the page that the trouble is shown in.
    """
    st.session_state.pop(_key(place), None)
    st.session_state[_OPENED] = place, label, state.workspace().n_opened
    try:
        state.open_session(session() if callable(session) else session, label=label)
    except MissingFactError as error:
        trouble = Trouble(_question(error.facts) or public(error), label, error.facts)
    except NvcoreError as error:
        trouble = Trouble(public(error), label)
    # only reached when it failed: what opens starts the run again
    st.session_state[_key(place)] = trouble
    st.rerun()


def trouble_of(place: str) -> Trouble | None:
    """What went wrong in this part of the page; None: nothing."""
    found: Trouble | None = st.session_state.get(_key(place))
    return found


def forget_trouble(place: str) -> None:
    """To be called when the choice that made trouble has changed."""
    st.session_state.pop(_key(place), None)


def _opened() -> tuple[str, str] | None:
    """Part of the page in which something was opened since, and what it is called."""
    place, label, n_before = st.session_state.get(_OPENED, ("", "", 0))
    is_open = place and state.workspace().n_opened > n_before
    return (place, label) if is_open else None


def draw_failures() -> None:
    """At the top of the page: what could not be opened, so that the rest is not taken for it."""
    keys = [key for key in st.session_state if str(key).startswith(f"{_KEY}_")]
    if _opened() is not None:
        for key in keys:
            del st.session_state[key]
        return
    for key in keys:
        trouble: Trouble = st.session_state[key]
        st.error(
            f"**Not opened: {plain(trouble.label) or 'nothing chosen'}.** {plain(trouble.text)}\n\n"
            f"Still open, and what this page is about: {plain(state.workspace().label)}.",
            icon=":material/error:",
        )


def draw_trouble(place: str) -> None:
    """The banner that says why something could not be opened, or once that it was."""
    opened_in, label = _opened() or ("", "")
    if opened_in == place:
        del st.session_state[_OPENED]
        st.success(
            f"Opened: {plain(label)}. What was read, and what to mind: see above."
            + _on_thresholds(),
            icon=":material/check_circle:",
        )
        st.button("See the comparison", type="primary", key=f"see_{place}",
                  on_click=ask_for_page, args=("overview",))  # fmt: skip
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
    return " Every detection counts, however low its score, until thresholds are set under Compare."


def _question(facts: tuple[str, ...]) -> str:
    """What is asked, without the command line's flags."""
    words = " and ".join(FACTS[fact] for fact in facts if fact in FACTS)
    return f"The files do not say {words}. Fill in the fields for it." if words else ""


def _key(place: str) -> str:
    return f"{_KEY}_{place}"
