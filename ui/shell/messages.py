"""Warnings and errors on pages, as sentences without traceback."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.common.errors import NvcoreError
from nvcore.common.findings import Severity
from nvcore.comparison.compare import Result
from nvcore.evidence.operating_points import SETTLED, can_be_equal, moved_of, point_note
from nvcore.notes import Note
from nvcore.notes.caveats import caveats
from nvcore.settings.defaults import OperatingPoint
from ui.access import files
from ui.session import state, store
from ui.session.opening import public_text
from ui.session.results import input_findings
from ui.settings.start import start_file
from ui.shell.navigate import open_page
from ui.shell.remedies import ways_text
from ui.widgets.buttons import button
from ui.widgets.choices import choose_side_by_side
from ui.widgets.text import plain

POINTS: Final[dict[OperatingPoint, str]] = {
    "as-set": "As set",
    "equal-alarms": "At equal false alarms",
}


def draw_notices(result: Result) -> None:
    """Draw the audit's warnings, then the operating points that the page's numbers are based on."""
    draw_warnings(result, has_point=True)
    draw_operating_point(result)


def draw_warnings(
    result: Result, *, is_of_encounters: bool = True, has_point: bool = False
) -> None:
    """Draw the audit's warnings. Pages about encounters also warn if most last a single frame.

    Unequal operating points are left out at equal false alarms, and on a page that names the
    operating points itself (`has_point`).
    """
    told = {"short-encounters"}
    if has_point or result.as_set is not None:
        told.add(SETTLED)
    if is_of_encounters and result.is_short:
        st.warning(state.say(Note("sections.short_encounters")), icon=":material/warning:")
    warned = caveats().warned
    texts = [
        state.say(warned[finding.code])
        for finding in input_findings()
        if finding.severity is not Severity.NOTE
        and finding.code in warned
        and finding.code not in told
    ]
    if texts:
        text = "; ".join(dict.fromkeys(texts))
        st.warning(
            f"The audit found: {plain(text)}. Details and remedies are on the page Data.",
            icon=":material/warning:",
        )


def draw_operating_point(result: Result) -> None:
    """Draw the operating points that the page's numbers are based on, and a choice if possible."""
    note = point_note(result)
    if note is None:
        return
    with st.container(horizontal=True, vertical_alignment="center", key="operating_points"):
        if can_be_equal(result.as_set or result):
            store.OPERATING_POINT.set(state.operating_point())
            choose_side_by_side(
                "What is compared",
                POINTS,
                store.OPERATING_POINT.key,
                on_change=_choose_point,
                label_visibility="collapsed",
                help="Of every page, of reports and of files that are written here.",
            )
        if result.as_set is not None:
            moved = moved_of(result)
            st.button(
                "Keep this threshold",
                key="keep_threshold",
                on_click=state.set_threshold,
                args=(moved, result.system(moved).threshold),
                help=f"Sets the threshold of {moved.upper()} in the sidebar.",
            )
        st.markdown(f":material/balance: {plain(state.say(note))}")


def _choose_point() -> None:
    state.set_operating_point(store.OPERATING_POINT.get())
    state.write_address()


def needs_comparison(draw: Callable[[Result], None]) -> Callable[[], None]:
    """Decorate a function so that it draws the current result, or a notice without a comparison."""

    @wraps(draw)
    def draw_if_compared() -> None:
        result = state.result()
        if result is None:
            _one_system_only()
        else:
            draw(result)

    return draw_if_compared


def _one_system_only() -> None:
    st.info("Only one system is open. A comparison needs two: add the second one on the Data page.")
    if button("Open the Data page", type="primary", key="open_data_page"):
        open_page("data")


def without_paths(text: object) -> str:
    """Remove the machine's paths from a text. The result is not yet `plain`."""
    return path_remover()(text)


def path_remover() -> Callable[[object], str]:
    """Return a function like `without_paths` for many texts, also usable outside a page's run."""
    return partial(public_text, folders=_folders())


def error_text(error: BaseException) -> str:
    """Return an error's message with suggested fixes, without local paths. Not yet `plain`."""
    text = str(error)
    if isinstance(error, NvcoreError) and error.steps:
        ways = ways_text(error.steps, are_all_needed=error.needs_all_steps)
        text = f"{text.rstrip('.')}. {ways}"
    return without_paths(text)


def shown_error(error: BaseException) -> str:
    """Return `error_text` as Markdown that shows it literally.

    This opens nothing, so it also works if the workspace could not be opened.
    """
    return plain(error_text(error))


@contextmanager
def errors_shown() -> Iterator[None]:
    """Draw an error in the user's input, and go on after the block.

    Also works as a decorator. The function then returns None after an error.
    """
    try:
        yield
    except NvcoreError as error:
        st.error(shown_error(error))


def shown_root() -> Path | None:
    """Return the folder that visitors may browse, or None if it is unset or missing."""
    try:
        root = files.local_root()
    except NvcoreError:  # reported where files are chosen
        return None
    return None if root is None else root.folder


def _folders() -> list[Path]:
    folders = [state.ROOT]
    start = start_file()
    if start is not None:
        folders.append(start.parent)
    root = shown_root()
    if root is not None:
        folders.append(root)
    space = store.WORKSPACE.get()
    if space is not None:
        folders += [space.folder, *space.folder.glob("upload-*")]
        folders += space.folder.glob("model-*/*")
        if space.opened is not None:
            session = space.opened.session
            outside = (Path(path) for path in session.paths())
            folders += [session.folder, *(path.parent for path in outside if path.is_absolute())]
    return folders


_LOG = logging.getLogger("nvcore.ui")


def error_banner(error: Exception) -> bool:
    """Draw an error in the data or a fault of the program. Return True to mark it as handled."""
    if isinstance(error, NvcoreError):
        st.error(shown_error(error), icon=":material/error:")
        return True
    _LOG.error("a page could not be drawn", exc_info=error)
    st.error(
        "This page could not be drawn: a fault of the program, not of your data. The other pages "
        "still work; the terminal that runs the app has the details.",
        icon=":material/error:",
    )
    return True
