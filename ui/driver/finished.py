"""Driver: an estimate that has ended becomes what is open, whatever page the visitor is on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final

import streamlit as st

from nvcore.driver.inputs.session import DriverTable
from nvcore.driver.writing import WrittenEstimates
from nvcore.errors import NvcoreError
from nvcore.inputs.session import Session
from nvcore.progress import Progress
from nvcore.wording import count_text
from ui.driver.confined import EstimatorSpec
from ui.driver.known import RUN, OpenedRun
from ui.jobs.background import JobState
from ui.jobs.progress import draw_job_aside
from ui.jobs.runs import Aside, FolderJob, is_uploaded, open_written
from ui.session import state
from ui.session.opening import relative_path
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error
from ui.shell.navigate import PAGES

JOB: Final = "driver_run"
PAGE: Final = "driver"
"""Path of the page."""
DOING: Final = "Estimating {what} the driver sees"
_NEWS: Final = "driver_news"
"""What the workspace remembers of estimates that were taken over, and the page that has said it."""
_TROUBLE: Final = "driver_trouble"
"""The same of why the last ones could not be, until the page Driver has said it."""


class EstimateJob(FolderJob[WrittenEstimates]):
    """A run.

    Attributes
    ----------
    spec
        The estimator, copied to the files.
    is_told
        Whether the page Driver has said how it ended.
    """

    def __init__(
        self,
        space: Workspace,
        folder: Path,
        spec: EstimatorSpec,
        work: Callable[[Progress], WrittenEstimates],
    ):
        """Start to run; see `FolderJob`."""
        self.spec, self.is_told = spec, False
        super().__init__(space, folder, work)


def draw_aside(page: str) -> None:
    """In the sidebar of any page: how far an estimate is, what came of it, and the way to Driver.

    Parameters
    ----------
    page
        Path of the page. Driver says all of that itself; the news stays on the page where it came.
    """
    space = state.workspace()
    job: EstimateJob | None = space.job(JOB)
    trouble, news = _trouble(), _news_on(page)
    if page == PAGE:
        return
    if news:  # no toast: what reads pages aloud has no name for those
        st.success(news, icon=":material/visibility:")
    elif trouble and job is None:
        text = state.say("{What} the driver sees was estimated, but cannot be taken over: ")
        st.error(text + trouble, icon=":material/error:")
    elif job is not None and (job.is_busy or is_waiting(job)):
        draw_job_aside(job, state.say(DOING), until=lambda: is_ready(job))
    elif job is not None and job.state is JobState.FAILED and not job.is_told:
        text = state.say("{What} the driver sees could not be estimated.")
        st.error(text, icon=":material/error:")
    else:
        return
    st.page_link(PAGES / f"{PAGE}.py", label="Driver", icon=":material/arrow_forward:")


def _news_on(page: str) -> str:
    """The message about estimates that were taken over, for the page that showed it first.

    Empty: nothing, or somebody has gone to another page since.
    """
    notes = state.workspace().notes
    text, where = notes.get(_NEWS, ("", None))
    if where not in (None, page) or page == PAGE:
        notes.pop(_NEWS, None)
        return ""
    if text:
        notes[_NEWS] = text, page
    return str(text)


def is_waiting(job: EstimateJob) -> bool:
    """Whether estimates are there and wait for other work of the session, which they would end."""
    return job.state is JobState.DONE and state.workspace().is_busy


def is_ready(job: EstimateJob) -> bool:
    """Whether the run has ended and may be taken over, if there is anything to be."""
    return not job.is_busy and not is_waiting(job)


def take_over() -> None:
    """Make the estimates of a run that is done what is open, and start the page's run again.

    Frame, settings and choices stay. To be called once all widgets have been drawn: nobody's click
    is lost.
    """
    job: EstimateJob | None = state.workspace().job(JOB)
    if job is not None and job.state is JobState.DONE and is_ready(job):
        _open(job)


def trouble() -> str:
    """Why the last estimates could not be taken over; empty: they could. Returned once."""
    text = _trouble()
    state.workspace().notes.pop(_TROUBLE, None)
    return text


def _trouble() -> str:
    """The same, if it is of what is open."""
    space = state.workspace()
    n_opened, text = space.notes.get(_TROUBLE, (0, ""))
    return str(text) if n_opened == space.n_opened else ""


def _open(job: EstimateJob) -> None:
    """Go on with what is open, and the estimates as what is known of the driver."""
    written, space, opened = job.output, state.workspace(), state.opened()
    assert written is not None
    session = with_estimates(opened.session, written, is_upload=is_uploaded(space, opened.session))
    named = session.driver.detectability
    assert named is not None
    files = (written.features, written.detectability, written.record)
    n = count_text(len(written.run.features.recordings), "recording")
    text = state.say(
        "{What} the driver sees is estimated in {n}. All pages count with it now.", n=n
    )

    def remember() -> None:
        space.notes[RUN] = OpenedRun(named, written.run, job.spec, files)
        space.notes[_NEWS] = text, None

    try:
        open_written(space, job, lambda: state.read_again(session, then=remember))
    except NvcoreError as error:
        space.notes[_TROUBLE] = space.n_opened, shown_error(error)
        give_up()
        st.rerun()  # the sidebar of this run is drawn


def give_up() -> None:
    """Forget a run that cannot be taken over: else each run of a page would try again."""
    state.workspace().drop_job(JOB)


def with_estimates(session: Session, written: WrittenEstimates, *, is_upload: bool) -> Session:
    """The session with the estimates.

    Parameters
    ----------
    is_upload
        Whether its files are uploads, and those of the run lie beside them: they are then named
        from its folder.
    """
    paths = written.detectability, written.record
    named = [relative_path(path, session.folder) if is_upload else str(path) for path in paths]
    return replace(session, driver=DriverTable(*named))  # type: ignore[call-arg]


ASIDE: Final = Aside(draw_aside, take_over, give_up)
