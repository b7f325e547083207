"""Background jobs of a session, with progress and cancellation."""

from __future__ import annotations

import shutil
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import CancelledError
from enum import Enum, auto
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

from nvcore.common.errors import NvcoreError
from nvcore.common.progress import Progress
from ui.session.uploads import remove_folder
from ui.session.workspace import Workspace

MOST_JOBS: Final = 2
"""Maximum number of jobs of all sessions that run at a time. Others wait."""
WAIT_S: Final = 0.2

Output = TypeVar("Output")

_slots = threading.BoundedSemaphore(MOST_JOBS)


class JobState(Enum):
    """State of a job."""

    WAITING = auto()
    RUNNING = auto()
    DONE = auto()
    CANCELLED = auto()
    FAILED = auto()

    @property
    def is_busy(self) -> bool:
        """True before it has ended."""
        return self in (JobState.WAITING, JobState.RUNNING)


class BackgroundJob(Generic[Output]):
    """Background job. It starts at once, or when a running one has ended.

    Attributes
    ----------
    key
        Inputs of the work, with which a page checks that the job is current. None: not checked.
    folder, title
        Folder that the work writes to, if any, and title of the work on pages.
    is_kept
        True if the folder outlasts the job, since the session has opened its files.
    share, step
        Completed share of the work, 0..1, and its step in words.
    output, error
        Return value of the finished work, or the reason of its failure.
    is_told
        True once its page has shown the outcome.
    outlasts
        True if its output stays useful when the same recordings are read again.
    """

    def __init__(
        self,
        work: Callable[[Progress], Output],
        space: Workspace,
        *,
        key: Any = None,
        title: str = "",
        folder: Path | None = None,
        outlasts: bool = False,
    ):
        """Start the job. It is cancelled when the session ends or opens something else.

        Parameters
        ----------
        work
            Receives the job's `Progress`, which raises `CancelledError` once the job is cancelled.
            It must not hold a reference to the session's workspace, which would then never end.
        space
            Workspace of the session, whose quota the files in `folder` are counted in.
        """
        self.key, self.folder, self.title, self.outlasts = key, folder, title, outlasts
        self.share, self.step = 0.0, ""
        self.error: NvcoreError | None = None
        self.is_kept = self.is_told = False
        self.state = JobState.WAITING
        self.output: Output | None = None
        opened = space.opened
        # the job would keep the session's files alive
        self._space = weakref.ref(space)
        self._dataset = (lambda: None) if opened is None else weakref.ref(opened.dataset)
        self._stop, self._ending = threading.Event(), threading.Lock()
        self._thread = threading.Thread(target=self._run, args=(work,), daemon=True)
        self._thread.start()

    @property
    def is_busy(self) -> bool:
        """True before it has ended."""
        return self.state.is_busy

    @property
    def is_stopping(self) -> bool:
        """True if it was cancelled and has not ended yet."""
        return self.is_busy and self._stop.is_set()

    def cancel(self) -> None:
        """Stop at the next step and remove the files. The output of an ended job stays."""
        self._stop.set()

    def discard(self) -> None:
        """Stop at the next step and remove the files, even of an ended job."""
        self.cancel()
        with self._ending:
            if not self.is_busy:
                self._remove()

    def join(self) -> None:
        """Wait for the end."""
        self._thread.join()

    def _progress(self, share: float, step: str) -> None:
        self.share, self.step = share, step
        space = self._space()
        opened = None if space is None else space.opened
        if self._stop.is_set() or opened is None or opened.dataset is not self._dataset():
            raise CancelledError

    def _run(self, work: Callable[[Progress], Output]) -> None:
        state, output = JobState.FAILED, None  # unless it comes to an end
        try:
            while not _slots.acquire(timeout=WAIT_S):
                self._progress(0.0, "")
            try:
                self.state = JobState.RUNNING
                self._progress(0.0, "")
                output = work(self._progress)
            finally:
                _slots.release()
            state = JobState.DONE
        except CancelledError:
            state = JobState.CANCELLED
        except NvcoreError as error:
            # its frames would keep alive what the work has loaded
            error.__traceback__ = error.__cause__ = error.__context__ = None
            self.error = error
        finally:
            with self._ending:
                if state is JobState.DONE and self._stop.is_set():
                    state = JobState.CANCELLED
                if state is JobState.DONE:
                    self.output = output
                else:
                    self._remove()
                self.state = state

    def _remove(self) -> None:
        space = self._space()
        if self.folder is None or self.is_kept:
            return
        if space is None:
            shutil.rmtree(self.folder, ignore_errors=True)
        else:
            remove_folder(space, self.folder)
