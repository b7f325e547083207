"""Runs whose files the session may open: where these lie, how long, and the room they take."""

from __future__ import annotations

import shutil
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nvcore.inputs.session import Session
from nvcore.progress import Progress
from ui.jobs.background import BackgroundJob, Output, while_open
from ui.session.uploads import ANNOTATION_FOLDERS, count_folder, remove_folder
from ui.session.workspace import Workspace


class FolderJob(BackgroundJob[Output]):
    """A run that ends with what is open; its files go with it unless they were opened.

    Attributes
    ----------
    folder
        Where its files are.
    is_opened
        Whether what it wrote is what the session has open.
    """

    def __init__(
        self,
        space: Workspace,
        folder: Path,
        work: Callable[[Progress], Output],
        *,
        key: Any = None,
    ):
        """Start to run; see `BackgroundJob`."""
        self.folder, self.is_opened = folder, False
        self._space = weakref.ref(space)
        super().__init__(work, while_open(space), key=key)

    def _remove(self) -> None:
        if self.is_opened:
            return
        space = self._space()
        if space is None:
            shutil.rmtree(self.folder, ignore_errors=True)
        else:
            remove_folder(space, self.folder)


@dataclass(frozen=True)
class Aside:
    """A page's run that goes on while the visitor is on other pages.

    Attributes
    ----------
    draw
        Says in the sidebar how far it is, given the path of the page that is shown.
    take_over
        Makes what it wrote what is open, once it is done; called when all widgets are drawn.
    give_up
        Forgets it, after a fault in `take_over`.
    """

    draw: Callable[[str], None]
    take_over: Callable[[], None]
    give_up: Callable[[], None]


def is_uploaded(space: Workspace, session: Session) -> bool:
    """Whether the session's files were sent."""
    return session.folder.is_relative_to(space.folder)


def new_run_folder(space: Workspace, session: Session, job: str, kind: str) -> Path:
    """Where the files of a run go; those of earlier ones of its kind that are not open are removed.

    Beside the other files of an upload, so that the session is exported as it.

    Parameters
    ----------
    job
        What the workspace holds such a run by; the last one is dropped.
    kind
        Begins the folder's name.
    """
    space.drop_job(job)
    base = session.folder if is_uploaded(space, session) else space.folder
    in_use = [session.folder / path for path in session.paths()]
    for folder in base.glob(f"{kind}-*"):
        is_run = folder.name.removeprefix(f"{kind}-").isdecimal()
        if is_run and not any(path.is_relative_to(folder) for path in in_use):
            remove_folder(space, folder)
    with space.lock:
        space.n_received += 1
        folder = base / f"{kind}-{space.n_received}"
    (folder / ANNOTATION_FOLDERS).mkdir(mode=0o700, parents=True)
    return folder


def open_written(space: Workspace, job: FolderJob[Any], opens: Callable[[], None]) -> None:
    """Open a session with what a run wrote, which then stays, and start the page's run again.

    Parameters
    ----------
    opens
        Opens it, by `ui.session.state`.

    Raises
    ------
    NvcoreError
        If there is no room for it, or it cannot be used: what was open stays open, and the files
        go with the job.
    """
    before = space.opened
    try:
        count_folder(space, job.folder)
        job.is_opened = True  # else its files go with what was open
        opens()
    finally:  # `opens` ends the page's run by an exception, too
        job.is_opened = space.opened is not before
