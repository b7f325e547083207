"""Progress of a background job, the same on every page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import streamlit as st

from nvcore.common.wording import percent
from ui.jobs.background import BackgroundJob, JobState
from ui.session import store
from ui.widgets.text import plain

POLL_S: Final = 0.4
NO_TIME_YET: Final = "estimating how long it takes"
"""Text while the time left is unknown."""
WAITS: Final = "It is done, and waits until other work in this tab has ended"


def start_as_made(job: BackgroundJob[Any], kind: str, **choices: object) -> None:
    """Set the widgets of these keys to the values of the job, before they are drawn.

    This happens only when the session sees the job for the first time. After a reload the session
    is new and its widgets have lost their values, but the job goes on.
    """
    seen = store.JOB_SEEN.of(kind)
    if seen.get() != job.key:
        seen.set(job.key)
        store.set_widgets(**choices)


@st.fragment(run_every=POLL_S)
def draw_progress(job: BackgroundJob[Any], kind: str, doing: str, *, with_steps: bool) -> None:
    """Draw progress, and a button to cancel. Sentences begin with `doing` ("Making the report").

    With `with_steps` they end with the steps of the work, such as the time left.
    """
    if not job.is_busy:
        st.rerun()
    st.progress(job.share, _words(job, doing, with_steps=with_steps))
    st.button(
        "Cancel",
        icon=":material/close:",
        key=f"{kind}_cancel",
        on_click=job.cancel,
        disabled=job.is_stopping,
    )


@st.fragment(run_every=POLL_S)
def draw_job_aside(job: BackgroundJob[Any], doing: str, *, until: Callable[[], bool]) -> None:
    """Draw progress of a job of another page. Rerun once `until` it can be taken over."""
    if until():
        st.rerun()
    words = _words(job, doing, with_steps=True) if job.is_busy else WAITS
    st.progress(job.share if job.is_busy else 1.0, words)


def _words(job: BackgroundJob[Any], doing: str, *, with_steps: bool) -> str:
    if job.is_stopping:
        return "Cancelling"
    if job.state is JobState.WAITING:
        return "Waiting for other work on this server"
    words = f"{plain(doing)}: {percent(job.share)}"
    if not with_steps:
        return words
    steps = filter(None, (plain(job.step), "" if job.share else NO_TIME_YET))
    return f"{words} ({'; '.join(steps)})"
