"""How far a job in the background is, in words."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from nvcore.common.errors import ParameterError
from nvcore.common.findings import Remedy, Step
from pages import checked, scripted
from ui.jobs.background import JobState

SCRIPT = """
import streamlit as st
from ui.jobs.page_run import PageRun
PageRun("run", "run", "Looking", has_time_left=True).draw(st.session_state["job"])
"""


@pytest.mark.parametrize(
    ("share", "step", "words"),
    [
        (0.0, "", "Looking: 0 % (estimating how long it takes)"),
        (0.0, "a: 0 of 9", "Looking: 0 % (a: 0 of 9; estimating how long it takes)"),
        (0.5, "a: 5 of 9, 2 s left", "Looking: 50 % (a: 5 of 9, 2 s left)"),
    ],
)
def test_until_a_time_left_is_known_that_is_said(share: float, step: str, words: str):
    page = scripted(SCRIPT)
    page.session_state["job"] = SimpleNamespace(
        state=JobState.RUNNING,
        is_busy=True,
        is_stopping=False,
        share=share,
        step=step,
        cancel=None,
        title="",
    )
    (progress,) = checked(page.run()).get("progress")
    assert progress.proto.text.replace("\\", "") == words


def test_a_job_that_fails_says_why_and_how_to_go_on():
    page = scripted(SCRIPT)
    error = ParameterError("no box is left", steps=(Step(Remedy.THRESHOLD, "0.2"),))
    page.session_state["job"] = SimpleNamespace(state=JobState.FAILED, error=error)
    assert checked(page.run()).error[0].value == "no box is left\\. Set the threshold to 0\\.2\\."


def test_choices_of_a_job_are_set_once_so_that_later_ones_stay():
    page = scripted(
        "import streamlit as st\n"
        "from ui.jobs.progress import start_as_made\n"
        "start_as_made(st.session_state['job'], 'run', choice=True)\n"
        "st.checkbox('choice', key='choice')"
    )
    page.session_state["job"] = SimpleNamespace(key=(1, 2))
    assert checked(page.run()).checkbox(key="choice").value
    assert not checked(page.checkbox(key="choice").uncheck().run()).checkbox(key="choice").value
