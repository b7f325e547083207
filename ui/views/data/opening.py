"""Data page: open a comparison, and say in a banner why it cannot be opened."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.errors import InputError, MissingFactError, NvcoreError
from nvcore.common.wording import listed
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from ui.session import state, store
from ui.shell.messages import error_text
from ui.shell.navigate import ask_for_page
from ui.streamlit_inside.types import DeltaGenerator
from ui.widgets.script import read_script
from ui.widgets.text import plain

_SEE: Final = "see_opened"
WAYS: Final = "Open your own files or another comparison"
"""Label of the box with all ways to open something."""
SESSION: Final = "session"
"""Part of the page that changes the open comparison instead of opening another."""
MISSING_WORDS: Final = {
    "size": "the image size",
    "fps": "the frame rate",
    "frames": "which frames are evaluated",
}
"""Missing facts of a `MissingFactError` in words."""
_TO_TOP = st.components.v2.component(
    "nvcore_to_top", js=read_script(Path(__file__).with_name("to_top.js"))
)
"""Component that scrolls to the top, since the buttons that open something are far below."""


@dataclass(frozen=True)
class Trouble:
    """Reason why something could not be opened, its label, and the missing inputs."""

    text: str
    label: str
    facts: tuple[str, ...] = ()


def try_to_open(
    session: Session | Callable[[], Session],
    *,
    label: str,
    place: str = SESSION,
    check: Callable[[Dataset], None] | None = None,
    words: str = "",
    field_of: Callable[[str], str] = lambda _: "",
) -> None:
    """Open a session, called `label` on the pages.

    If that fails, the run starts again and `draw_trouble` says why in this part of the page.

    Parameters
    ----------
    check
        Called with the data before they are shown. Its errors are treated like those of files.
    words
        Description of the changes, for the message after opening.
    field_of
        Returns the title of the field with a file, for its errors, or "".
    """
    store.TROUBLES.of(place).pop()
    store.OPENED_WORDS.set(words)
    store.LAST_OPENED.set((place, label, state.workspace().n_opened))
    try:
        state.open_session(session() if callable(session) else session, label=label, check=check)
    except MissingFactError as error:
        trouble = Trouble(_question(error.facts) or error_text(error), label, error.facts)
    except NvcoreError as error:
        title = field_of(error.file) if isinstance(error, InputError) and error.file else ""
        trouble = Trouble(f"{title}: {error_text(error)}" if title else error_text(error), label)
    # only reached when it failed: opening something starts the run again
    store.TROUBLES.of(place).set(trouble)
    st.rerun()


def new_place(draw: Callable[[], None]) -> DeltaGenerator:
    """Return a place for a part of the page, emptied if another comparison is open now.

    Otherwise its old content would stay visible under the new heading until it is replaced.
    """
    drawn, n_opened = store.OPENING_DRAWN.of(draw.__module__), state.workspace().n_opened
    is_other = drawn.get() not in (None, n_opened)
    drawn.set(n_opened)
    return st.empty().container() if is_other else st.container()


def forget_outcome(place: str) -> None:
    """Forget errors and questions of this part of the page. For callbacks."""
    store.TROUBLES.of(place).pop()
    store.ASKED_FACTS.of(place).pop()


def has_trouble() -> bool:
    """Whether something could not be opened, and the choice that failed is unchanged."""
    return any(known != store.TROUBLES.of(SESSION) for known in store.TROUBLES.known())


def _opened() -> tuple[str, str] | None:
    """Return the part of the page that opened the open comparison, and its label, or None."""
    place, label, n_before = store.LAST_OPENED.get()
    is_open = place and state.workspace().n_opened > n_before
    return (place, label) if is_open else None


def draw_outcome() -> None:
    """Draw at the top of the page what was opened, or what failed and thus is not shown."""
    troubles = store.TROUBLES.known()
    opened = _opened()
    if opened is not None:
        for known in troubles:
            known.pop()
        if opened[0] != SESSION:
            _draw_opened(opened[1])
        return
    for trouble in filter(None, (known.get() for known in troubles)):
        st.error(
            f"**Not opened: {plain(trouble.label) or 'nothing chosen'}.** {plain(trouble.text)}\n\n"
            f"Still open, and what this page is about: {plain(state.opened().label)}.",
            icon=":material/error:",
        )


def _draw_opened(label: str) -> None:
    """Draw the next step, as long as the visitor stays on the page."""
    n_opened = state.workspace().n_opened
    is_first = store.OPENING_SHOWN.get() != n_opened
    if not is_first and not store.widget(_SEE).is_set:  # values of another page's widgets go
        store.LAST_OPENED.pop()
        return
    store.OPENING_SHOWN.set(n_opened)
    if is_first:
        store.WAYS_OPEN.set(False)
    words = f"{plain(words)} " if (words := store.OPENED_WORDS.get()) else ""
    st.success(
        f"**Opened: {plain(label)}.** {words}Below: what to mind and what was read."
        f"{_on_thresholds()}",
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


def ask_for_change() -> None:
    """Unfold the form that adds something to the open comparison, and scroll to it."""
    store.WAYS_OPEN.set(True)
    store.FORM_PURPOSE.of("upload").set("add")
    store.SCROLLS.set(True)


def scroll_if_asked() -> None:
    """Scroll to the top of the page if `ask_for_change` was called."""
    if store.SCROLLS.pop():
        _TO_TOP(key="to_form", data=None, height=1)


def draw_trouble(place: str) -> None:
    """Draw why something could not be opened, or once the message after a change."""
    opened_in, label = _opened() or ("", "")
    if opened_in == place == SESSION:
        store.LAST_OPENED.pop()
        st.success(
            f"Changed, and opened again: {plain(label)}. What to mind stands above.",
            icon=":material/check_circle:",
        )
    trouble = store.TROUBLES.of(place).get()
    if trouble is not None:
        is_question = bool(trouble.facts)
        icon = ":material/help:" if is_question else ":material/error:"
        (st.warning if is_question else st.error)(plain(trouble.text), icon=icon)


def _on_thresholds() -> str:
    """Name the systems with scores whose threshold is still to be chosen."""
    limits = (state.params().threshold_x, state.params().threshold_y)
    without = listed(
        [
            plain(name)
            for name, limit in zip(state.systems(), limits, strict=True)
            if name is not None and limit is None and state.score_span(name) is not None
        ]
    )
    return without and (
        f" Every detection of {without} counts, however low its score, until a threshold "
        "is set in the sidebar."
    )


def _question(facts: tuple[str, ...]) -> str:
    """Return the question to the user, without the command line's flags."""
    words = " and ".join(MISSING_WORDS[fact] for fact in facts if fact in MISSING_WORDS)
    return f"The files do not say {words}. Fill in the fields for it." if words else ""
