"""Long work of a page, as background jobs with buttons and progress."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic

import streamlit as st

from nvcore.common.progress import Progress
from nvcore.dataset import Dataset
from nvcore.inputs.session import Session
from ui.jobs.background import BackgroundJob, JobState, Output
from ui.jobs.progress import draw_progress
from ui.session import state
from ui.session.uploads import ANNOTATION_FOLDERS, count_folder, remove_unused
from ui.session.workspace import Workspace
from ui.shell.messages import shown_error
from ui.widgets.buttons import button, download


@dataclass(frozen=True)
class PageRun(Generic[Output]):
    """A kind of long work. The workspace keeps the newest run of each kind.

    Attributes
    ----------
    name
        Name of its job in the workspace. Begins the keys of its widgets.
    thing, doing
        Its output in words ("report"), and the beginning of its progress ("Making {title}").
    folder
        Beginning of the name of the folder for its files. Empty: it writes none.
    outlasts
        True if its output stays useful when the same recordings are read again.
    has_time_left
        True if the progress ends with the steps of the work and the time left.
    """

    name: str
    thing: str
    doing: str
    folder: str = ""
    outlasts: bool = False
    has_time_left: bool = False

    @property
    def job(self) -> BackgroundJob[Output] | None:
        """Newest run of this session, running or ended."""
        job: BackgroundJob[Output] | None = state.workspace().job(self.name)
        return job

    @property
    def is_busy(self) -> bool:
        """True while such a run is under way."""
        return self.job is not None and self.job.is_busy

    def start_button(
        self, label: str, icon: str, key: str, *, is_possible: bool = True, **options: Any
    ) -> bool:
        """Draw the button that starts a run, disabled while one is under way. Return its click."""
        icon, disabled = f":material/{icon}:", self.is_busy or not is_possible
        return button(label, key=key, icon=icon, disabled=disabled, **options)

    def drop(self) -> None:
        """Cancel the newest run and remove its files."""
        state.workspace().drop_job(self.name)

    def new_folder(self) -> Path:
        """Make the folder of a new run, and remove the folders of earlier runs that are not open.

        It lies beside the files of an upload, so that all are exported as one session.
        """
        self.drop()
        space, session = state.workspace(), state.opened().session
        base = session.folder if is_uploaded(space, session) else space.folder
        start = f"{self.folder}-"
        every = base.glob(f"{start}*")
        runs = (path for path in every if path.name.removeprefix(start).isdecimal())
        remove_unused(space, runs)
        folder = base / f"{self.folder}-{next(space.numbers)}"
        (folder / ANNOTATION_FOLDERS).mkdir(mode=0o700, parents=True)
        return folder

    def start(
        self,
        work: Callable[[Progress], Output],
        *,
        key: Any = None,
        title: str = "",
        folder: Path | None = None,
    ) -> None:
        """Start a run (see `BackgroundJob`) in place of the last one."""
        space = state.workspace()
        job = BackgroundJob(
            work, space, key=key, title=title, folder=folder, outlasts=self.outlasts
        )
        space.put_job(self.name, job)

    def draw(self, job: BackgroundJob[Output]) -> JobState:
        """Draw the progress of a run, or why it has no output. Return the state that was drawn."""
        job_state = job.state  # once: it may end meanwhile
        if job_state.is_busy:
            doing = self.doing.format(title=job.title)
            draw_progress(job, self.name, doing, with_steps=self.has_time_left)
        elif job_state is JobState.CANCELLED:
            st.info(f"Cancelled. No {self.thing} was made.", icon=":material/info:")
        elif job_state is JobState.FAILED:
            reason = shown_error(job.error) if job.error else f"The {self.thing} could not be made."
            st.error(reason, icon=":material/error:")
        return job_state

    def draw_file(self, key: Any = None) -> None:
        """Draw the newest run, whose file has its title. Warn if it has another `key`."""
        job = self.job
        if job is None or self.draw(job) is not JobState.DONE:
            return
        assert job.folder is not None
        path = job.folder / job.title  # the callable must not hold the job, which holds pictures
        key_of_button = f"{self.name}_download"
        download(path.name, lambda: path.open("rb"), path.name, key=key_of_button, type="primary")
        size = f"{path.stat().st_size / 1e6:.1f} MB."
        if job.key == key:
            st.caption(f"{size} It stays here until the next one.")
        else:
            st.warning(f"{size} It was made with other settings: make it again for those of now.")


@dataclass(frozen=True)
class Aside:
    """A page's run that goes on while the visitor is on other pages.

    `draw` draws its progress in the sidebar of the page with the given path. Once all widgets are
    drawn, `take_over` opens the output of a run that is done. If that fails, `give_up` drops the
    run.
    """

    draw: Callable[[str], None]
    take_over: Callable[[], None]
    give_up: Callable[[], None]


def is_uploaded(space: Workspace, session: Session) -> bool:
    """Return whether the session's files were uploaded."""
    return session.folder.is_relative_to(space.folder)


def named_in(session: Session, path: Path) -> str:
    """Return the path of a run's file, relative to the session's folder if it lies below it."""
    is_inside = path.is_relative_to(session.folder)
    return path.relative_to(session.folder).as_posix() if is_inside else str(path)


def dataset_of(names: Collection[str]) -> Dataset:
    """Return these recordings of the open comparison, with the live session as settings."""
    dataset = state.opened().dataset.with_settings(state.live_session())
    return dataset if {*names} == {*state.recording_names()} else dataset.only(names=names)


def open_written(space: Workspace, job: BackgroundJob[Any], opens: Callable[[], None]) -> None:
    """Open a session with the files of a run, which then stay, by `opens`, which reruns the page.

    Raises
    ------
    NvcoreError
        If there is no room for the files, or the session cannot be used. The previous session stays
        open, and the files are removed with the job.
    """
    before = space.opened
    assert job.folder is not None
    try:
        count_folder(space, job.folder)
        job.is_kept = True  # otherwise its files are removed with the previous session
        opens()
    finally:  # `opens` ends the page's run by an exception, too
        job.is_kept = space.opened is not before
