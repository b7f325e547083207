"""Run over pictures of recordings: one thread decodes, others work, results come in order."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Final, TypeVar

from nvcore.common.errors import MediaError
from nvcore.common.progress import POLL_S, Progress
from nvcore.common.wording import count_text, duration_text, one_line
from nvcore.pictures.base import Picture, Pictures

P = TypeVar("P")
T = TypeVar("T")
AHEAD: Final = 2
"""Pictures decoded ahead for each thread, which limits the memory of a run."""


class PictureRun:
    """A run over pictures, with progress, cancellation and the time left.

    Parameters
    ----------
    n_pictures
        Number of pictures to process.
    progress
        Called for each picture and while waiting. The run stops if it raises `CancelledError`.
    n_threads
        Pictures processed at a time. None: one per core.

    Attributes
    ----------
    begin
        Called by each worker thread before its first picture.
    """

    begin: Callable[[], None] | None = None

    def __init__(self, n_pictures: int, progress: Progress, *, n_threads: int | None = None):
        self.n_pictures, self.n_done = n_pictures, 0
        self.n_threads = n_threads or os.cpu_count() or 1
        self._progress = progress
        self._began = time.perf_counter()

    @property
    def seconds(self) -> float:
        """Seconds since the run began."""
        return time.perf_counter() - self._began

    def over(
        self,
        source: Pictures | None,
        indices: Iterable[tuple[int, int]],
        work: Callable[[int, Picture], T],
        name: str,
        faults: list[str],
    ) -> Generator[T]:
        """Yield ``work(number, picture)`` for each picture of a recording, in order.

        Parameters
        ----------
        source
            Pictures of the recording. None: it has none, and nothing is yielded.
        indices
            The caller's number (such as the frame) and the index of each picture.
        name
            Name of the recording, for `progress`.
        faults
            Collects the errors of pictures that cannot be read. These are skipped.
        """
        if source is None:
            return
        reader, n_before = source.another(), len(faults)
        try:
            yield from self.map(work, _readable(reader, indices, faults), name)
        finally:
            reader.close()
        self.n_pictures -= len(faults) - n_before

    def map(
        self, work: Callable[[int, P], T], pictures: Iterable[tuple[int, P]], name: str
    ) -> Generator[T]:
        """Yield ``work(number, picture)`` for each of these pictures, in order."""
        waiting: deque[Future[T]] = deque()

        def oldest() -> T:
            while not wait([waiting[0]], POLL_S).done:
                self._tell(name)
            result = waiting.popleft().result()
            self.n_done += 1
            self._tell(name)
            return result

        with ThreadPoolExecutor(self.n_threads, initializer=self.begin) as pool:
            try:
                for number, picture in pictures:
                    waiting.append(pool.submit(work, number, picture))
                    if len(waiting) > AHEAD * self.n_threads:
                        yield oldest()
                while waiting:
                    yield oldest()
            finally:
                for future in waiting:
                    future.cancel()

    def _tell(self, name: str) -> None:
        words = f"{name}: {self.n_done:,} of {count_text(self.n_pictures, 'picture')}"
        if self.n_done:
            left = self.seconds / self.n_done * (self.n_pictures - self.n_done)
            words += f", {duration_text(round(left))} left"
        self._progress(self.n_done / max(1, self.n_pictures), words)


def _readable(
    pictures: Pictures, indices: Iterable[tuple[int, int]], faults: list[str]
) -> Iterator[tuple[int, Picture]]:
    for number, index in indices:
        try:
            picture = pictures.read(index)
        except MediaError as error:
            faults.append(one_line(str(error)))
        else:
            yield number, picture


def speed_text(n_pictures: int, seconds: float) -> str:
    """Return the duration of a run, and pictures per second, in words."""
    rate = n_pictures / seconds if seconds > 0 else 0.0
    return f"in {duration_text(seconds)} ({rate:.1f} pictures a second)"
