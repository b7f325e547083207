"""A video that is written in the background while its page stays alive."""

from __future__ import annotations

import threading
from collections.abc import Callable
from enum import Enum, auto
from pathlib import Path
from typing import Final

from nvcore.errors import NvcoreError

MOST_AT_ONCE: Final = 2
"""Videos that all sessions together write at a time; further ones wait."""
WAIT_S: Final = 0.2

Progress = Callable[[float], bool]
"""Told the share that is done; says whether to go on."""

_slots = threading.BoundedSemaphore(MOST_AT_ONCE)


class JobState(Enum):
    """How far a job has come."""

    WAITING = auto()
    RUNNING = auto()
    DONE = auto()
    CANCELLED = auto()
    FAILED = auto()


class VideoJob:
    """One video; starts at once, or when another has ended.

    Attributes
    ----------
    path
        Where it is written; there is a file only once the job is done.
    name
        File name for the download.
    share
        What is done, 0..1.
    error
        Why it failed, in words.
    is_wanted
        Whether the session still shows what the video shows.
    """

    def __init__(
        self,
        path: Path,
        name: str,
        write: Callable[[Progress], bool],
        is_wanted: Callable[[], bool],
    ):
        """Start.

        Parameters
        ----------
        write
            Writes the video; whether it was finished. It must not hold the session's workspace,
            which would then never end.
        is_wanted
            False once the session has ended or shows something else: the job then ends, too.
        """
        self.path, self.name = path, name
        self.share, self.error = 0.0, ""
        self.state = JobState.WAITING
        self.is_wanted = is_wanted
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self._run, args=(write,), name="video export", daemon=True
        )
        self._thread.start()

    def cancel(self) -> None:
        """Stop after the current frame; nothing is left of the video."""
        self._stop.set()

    def join(self) -> None:
        """Wait until nothing more will happen."""
        self._thread.join()

    def discard(self) -> None:
        """Cancel, and remove the video if it is there."""
        self.cancel()
        self.join()
        self.path.unlink(missing_ok=True)

    def _goes_on(self) -> bool:
        return not self._stop.is_set() and self.is_wanted()

    def _progress(self, share: float) -> bool:
        self.share = share
        return self._goes_on()

    def _run(self, write: Callable[[Progress], bool]) -> None:
        while not _slots.acquire(timeout=WAIT_S):
            if not self._goes_on():
                self.state = JobState.CANCELLED
                return
        state = JobState.FAILED  # unless it comes to an end
        try:
            self.state = JobState.RUNNING
            is_done = self._goes_on() and write(self._progress)
            state = JobState.DONE if is_done else JobState.CANCELLED
        except NvcoreError as error:
            self.error = str(error)
        finally:
            self.state = state
            _slots.release()
