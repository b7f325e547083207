"""Work in the background while its page stays alive: progress, cancel, end with the session."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from enum import Enum, auto
from typing import Final

from nvcore.errors import NvcoreError
from ui.workspace import Workspace

MOST_AT_ONCE: Final = 2
"""Jobs that all sessions together run at a time; further ones wait."""
WAIT_S: Final = 0.2

Progress = Callable[[float], bool]
"""Told the share that is done; says whether to go on."""

_slots = threading.BoundedSemaphore(MOST_AT_ONCE)


def while_open(space: Workspace) -> Callable[[], bool]:
    """Whether the session still has open what it has open now, for `BackgroundJob`.

    It does not hold the workspace: a thread that did would keep the session's files alive.
    """
    session, dataset = weakref.ref(space), weakref.ref(space.dataset)

    def is_wanted() -> bool:
        here = session()
        return here is not None and here.dataset is not None and here.dataset is dataset()

    return is_wanted


class JobState(Enum):
    """How far a job has come."""

    WAITING = auto()
    RUNNING = auto()
    DONE = auto()
    CANCELLED = auto()
    FAILED = auto()


class BackgroundJob:
    """One piece of work; starts at once, or when another has ended.

    Attributes
    ----------
    share
        What is done, 0..1.
    error
        Why it failed, in words.
    is_wanted
        Whether the session still shows what the work is for.
    """

    def __init__(self, work: Callable[[Progress], bool], is_wanted: Callable[[], bool]):
        """Start.

        Parameters
        ----------
        work
            Says whether it was finished. It must not hold the session's workspace, which would
            then never end.
        is_wanted
            False once the session has ended or shows something else: the job then ends, too.
        """
        self.share, self.error = 0.0, ""
        self.state = JobState.WAITING
        self.is_wanted = is_wanted
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(work,), name=type(self).__name__, daemon=True
        )
        self._thread.start()

    @property
    def is_busy(self) -> bool:
        """Whether it has not ended yet."""
        return self.state in (JobState.WAITING, JobState.RUNNING)

    def cancel(self) -> None:
        """Stop at the next step; nothing is left of the work."""
        self._stop.set()

    def join(self) -> None:
        """Wait until nothing more will happen."""
        self._thread.join()

    def _goes_on(self) -> bool:
        return not self._stop.is_set() and self.is_wanted()

    def _progress(self, share: float) -> bool:
        self.share = share
        return self._goes_on()

    def _run(self, work: Callable[[Progress], bool]) -> None:
        while not _slots.acquire(timeout=WAIT_S):
            if not self._goes_on():
                self.state = JobState.CANCELLED
                return
        state = JobState.FAILED  # unless it comes to an end
        try:
            self.state = JobState.RUNNING
            is_done = self._goes_on() and work(self._progress)
            state = JobState.DONE if is_done else JobState.CANCELLED
        except NvcoreError as error:
            self.error = str(error)
        finally:
            self.state = state
            _slots.release()
