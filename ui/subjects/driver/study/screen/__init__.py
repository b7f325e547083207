"""Full-window display of a study's run in the browser.

This is a Streamlit component. It fetches the pictures of a run in advance, shows everything by the
animation clock, and sends each answer to the study's route at once. Python is notified of the end,
and of a stop.

    clock.js     frames of the animation, and waiting for them
    drawing.js   content of the canvas: light, pictures, crosses
    sending.js   pictures from the app, answers to it, which wait in the tab until they are kept
    run.js       sequence of a run, with the entry point for Streamlit
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Final, NamedTuple

import streamlit as st

from ui.session import state, store
from ui.session.routes import address
from ui.subjects.driver.study.on_screen import OnScreen
from ui.widgets.script import read_script

FOLDER: Final = Path(__file__).parent
KEY: Final = "study_screen"

_COMPONENT = st.components.v2.component(
    "nvcore_study",
    css=(FOLDER / "screen.css").read_text(encoding="utf-8"),
    js=read_script(FOLDER / "run.js"),
)


class ScreenTrial(NamedTuple):
    """Trial for the browser: place (0: practice), picture with size (px), and time."""

    place: int
    picture: str
    width: int
    height: int
    adaptation_s: float


def draw_run(
    on_screen: OnScreen,
    run: str,
    title: str,
    trials: Sequence[ScreenTrial],
    *,
    on_end: Callable[[str], None] = lambda _: None,
) -> None:
    """Draw the button that starts a run, which then fills the window.

    Parameters
    ----------
    run
        Name of the run. A new name means a new run.
    title
        Label of the button.
    on_end
        Called with the name of a run that was seen to its end. After a stop, or when earlier
        answers were stored, the page is only redrawn.
    """

    def end() -> None:
        ended = store.sent(KEY, "ended")
        if isinstance(ended, str):
            on_end(ended)

    _COMPONENT(
        key=KEY,
        data={
            "run": run,
            "title": title,
            "whose": on_screen.whose,
            "url": f"{address(state.workspace())}/study",
            "trials": [trial._asdict() for trial in trials],
            "timing": asdict(on_screen.study.settings.timing),
        },
        on_ended_change=end,
        on_stopped_change=lambda: None,
        on_kept_change=lambda: None,
    )
