"""One pass over the pictures of recordings: this thread reads, others work, results in order."""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Final, TypeVar

from nvcore.errors import MediaError
from nvcore.pictures.base import Picture, Pictures
from nvcore.progress import POLL_S, Progress
from nvcore.wording import count_text, duration_text, one_line

T = TypeVar("T")
AHEAD: Final = 2
"""Pictures read ahead for each thread."""


def pictures_of(
    pictures: Pictures, indices: Iterable[tuple[int, int]], faults: list[str]
) -> Iterator[tuple[int, Picture]]:
    """Number and picture of each.

    Parameters
    ----------
    indices
        A number of the caller's, such as the frame, and the index of its picture.
    faults
        Why a picture cannot be read is added to it; such pictures are passed over.
    """
    for number, index in indices:
        try:
            picture = pictures.read(int(index))
        except MediaError as error:
            faults.append(one_line(str(error)))
        else:
            yield int(number), picture


def in_order(
    work: Callable[[int, Picture], T],
    pictures: Iterable[tuple[int, Picture]],
    poll: Callable[[], None],
    *,
    n_threads: int | None = None,
    begin: Callable[[], None] | None = None,
) -> Generator[T]:
    """Results of ``work(number, picture)`` in the order of the pictures.

    This thread reads the pictures (those of a video are decoded one after another), others work.

    Parameters
    ----------
    poll
        Called while waiting; it may raise `CancelledError`.
    n_threads
        Pictures at a time; None: as many as there are cores.
    begin
        Called by each of these threads before its first picture.
    """
    n_threads = n_threads or os.cpu_count() or 1
    waiting: deque[Future[T]] = deque()

    def oldest() -> T:
        future = waiting[0]
        while not wait([future], POLL_S).done:
            poll()
        waiting.popleft()
        return future.result()

    with ThreadPoolExecutor(n_threads, initializer=begin) as pool:
        try:
            for number, picture in pictures:
                waiting.append(pool.submit(work, number, picture))
                if len(waiting) > AHEAD * n_threads:
                    yield oldest()
            while waiting:
                yield oldest()
        finally:
            for future in waiting:
                future.cancel()


class PictureClock:
    """Counts the pictures of a pass, and says how long the rest will take."""

    def __init__(self, n_pictures: int, progress: Progress):
        self.n_pictures, self.n_done, self._progress = n_pictures, 0, progress
        self._began = time.perf_counter()

    @property
    def seconds(self) -> float:
        """Since the pass began."""
        return time.perf_counter() - self._began

    def count(self, n_more: int, name: str) -> None:
        """So many more are done, of the recording of this name."""
        self.n_done += n_more
        words = f"{name}: {self.n_done:,} of {count_text(self.n_pictures, 'picture')}"
        if self.n_done:
            left = self.seconds / self.n_done * (self.n_pictures - self.n_done)
            words += f", {duration_text(round(left))} left"
        self._progress(self.n_done / max(1, self.n_pictures), words)
