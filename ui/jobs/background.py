"""Work in the background while its page stays alive: progress, cancel, end with the session."""

from __future__ import annotations

import secrets
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import CancelledError
from enum import Enum, auto
from pathlib import Path
from typing import Any, Final, Generic, TypeVar

from nvcore.dataset import Dataset
from nvcore.errors import NvcoreError
from nvcore.progress import Progress
from ui.session.workspace import Workspace

MOST_AT_ONCE: Final = 2
"""Jobs of all sessions together that run at a time; further ones wait."""
WAIT_S: Final = 0.2

Output = TypeVar("Output")

_slots = threading.BoundedSemaphore(MOST_AT_ONCE)


def while_open(space: Workspace) -> Callable[[], bool]:
    """A function for `BackgroundJob`: whether the session still has open what it has open now.

    It does not hold the workspace: a thread that did would keep the session's files alive.
    """

    def dataset_of(workspace: Workspace | None) -> Dataset | None:
        return None if workspace is None or workspace.opened is None else workspace.opened.dataset

    dataset = dataset_of(space)
    if dataset is None:
        return lambda: False
    space_ref, dataset_ref = weakref.ref(space), weakref.ref(dataset)

    def is_wanted() -> bool:
        current = dataset_of(space_ref())
        return current is not None and current is dataset_ref()

    return is_wanted


class JobState(Enum):
    """How far a job has come."""

    WAITING = auto()
    RUNNING = auto()
    DONE = auto()
    CANCELLED = auto()
    FAILED = auto()

    @property
    def is_busy(self) -> bool:
        """Whether it has not ended yet."""
        return self in (JobState.WAITING, JobState.RUNNING)


class BackgroundJob(Generic[Output]):
    """One piece of work; starts at once, or when another has ended.

    Attributes
    ----------
    key
        What it is made from, so that a page can check whether it fits; None: it does not matter.
    share, step
        What is done, 0..1, and in words.
    error
        Why it failed, in words.
    is_wanted
        Whether the session still shows what the work is for.
    outlasts
        Whether what came out is of use, too, when the same recordings are read again.
    """

    def __init__(
        self,
        work: Callable[[Progress], Output],
        is_wanted: Callable[[], bool],
        *,
        key: Any = None,
    ):
        """Start.

        Parameters
        ----------
        work
            Is given the job's `Progress`, which ends it where it is cancelled. It must not hold
            the session's workspace, which would then never end.
        is_wanted
            False once the session has ended or shows something else: the job then ends, too.
        """
        self.key = key
        self.share, self.step, self.error = 0.0, "", ""
        self.state = JobState.WAITING
        self.is_wanted, self.outlasts = is_wanted, False
        self._output: Output | None = None
        self._stop, self._ending = threading.Event(), threading.Lock()
        self._thread = threading.Thread(
            target=self._run, args=(work,), name=type(self).__name__, daemon=True
        )
        self._thread.start()

    @property
    def is_busy(self) -> bool:
        """Whether it has not ended yet."""
        return self.state.is_busy

    @property
    def output(self) -> Output | None:
        """What came out; None before that is done."""
        return self._output if self.state is JobState.DONE else None

    @property
    def is_stopping(self) -> bool:
        """Whether it was cancelled and is still at the step at which that happened."""
        return self.is_busy and self._stop.is_set()

    def cancel(self) -> None:
        """Stop at the next step; nothing is left of the work. What is done already stays."""
        self._stop.set()

    def discard(self) -> None:
        """Stop at the next step; nothing is left, even of work that is done."""
        self.cancel()
        with self._ending:
            if not self.is_busy:
                self._remove()

    def join(self) -> None:
        """Wait until nothing more will happen."""
        self._thread.join()

    def _goes_on(self) -> bool:
        return not self._stop.is_set() and self.is_wanted()

    def _progress(self, share: float, step: str) -> None:
        self.share, self.step = share, step
        if not self._goes_on():
            raise CancelledError

    def _remove(self) -> None:
        """Remove what the work left; to be overridden by jobs that leave something."""

    def _run(self, work: Callable[[Progress], Output]) -> None:
        while not _slots.acquire(timeout=WAIT_S):
            if not self._goes_on():
                self.state = JobState.CANCELLED
                return
        state = JobState.FAILED  # unless it comes to an end
        try:
            self.state = JobState.RUNNING
            self._progress(0.0, "")
            self._output = work(self._progress)
            state = JobState.DONE
        except CancelledError:
            state = JobState.CANCELLED
        except NvcoreError as error:
            self.error = str(error)
        finally:
            with self._ending:
                is_late = state is JobState.DONE and self._stop.is_set()
                self.state = JobState.CANCELLED if is_late else state
                if self.state is not JobState.DONE:
                    self._remove()
            _slots.release()


FOLDER: Final = "exports"


def new_path(space: Workspace, suffix: str) -> Path:
    """Where the workspace has room for such a file; it is there no longer than the workspace."""
    folder = space.folder / FOLDER
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder / f"{secrets.token_hex(8)}{suffix}"


class FileJob(BackgroundJob[None]):
    """One file for download; it is at its path only once the job is done."""

    def __init__(
        self,
        path: Path,
        name: str,
        write: Callable[[Progress], None],
        is_wanted: Callable[[], bool],
        *,
        key: Any = None,
    ):
        """Start to write; see `BackgroundJob`."""
        self.path, self.name = path, name
        super().__init__(write, is_wanted, key=key)

    def _remove(self) -> None:
        self.path.unlink(missing_ok=True)
