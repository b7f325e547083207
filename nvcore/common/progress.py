"""Progress of a long computation: the callback type, and steps that run in parallel."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from typing import Final, TypeVar

from nvcore.common.wording import duration_text

T = TypeVar("T")
Progress = Callable[[float, str], None]
"""Callback with the share done, 0..1, and a few words on the next step.

It may raise `concurrent.futures.CancelledError`. The work then stops and leaves nothing behind."""

SOON: Final = 0.03
"""Share done from which the time left is shown."""
POLL_S: Final = 0.05
"""Poll interval for cancellation while other threads work, seconds."""


def no_progress(_share: float, _what: str) -> None:
    """Do nothing, as a `Progress`."""


def part_of(progress: Progress, start: float, end: float) -> Progress:
    """Return the progress of a part of the work, from the share `start` to `end` of the whole."""

    def tell(share: float, what: str) -> None:
        progress(start + (end - start) * share, what)

    return tell


def with_time_left(progress: Progress) -> Progress:
    """Add the time left, estimated from the share done so far, to the words."""
    began = time.perf_counter()

    def tell(share: float, what: str) -> None:
        if SOON <= share < 1:
            left = (time.perf_counter() - began) * (1 - share) / share
            what = f"{what}, about {duration_text(round(left))} left"
        progress(share, what)

    return tell


def run_steps(
    jobs: Sequence[Callable[[], T]], executor: Executor | None, progress: Progress, what: str
) -> list[T]:
    """Run all jobs and return their results in order.

    Parameters
    ----------
    executor
        Executor of the jobs; None: run them in this thread, one after another.
    progress
        Called from this thread before each job and at the end, and regularly while other threads
        work. If it raises, running jobs in other threads finish, and no other job starts.
    what
        Words for `progress`.
    """
    if executor is None:
        results: list[T] = []
        for job in jobs:
            progress(len(results) / len(jobs), what)
            results.append(job())
        progress(1.0, what)
        return results
    futures: list[Future[T]] = [executor.submit(job) for job in jobs]
    pending = set(futures)
    try:
        while pending:
            progress((len(jobs) - len(pending)) / len(jobs), what)
            finished, pending = wait(pending, POLL_S, FIRST_COMPLETED)
            for future in finished:
                future.result()  # raises the job's error
        progress(1.0, what)
    finally:
        for future in pending:
            future.cancel()
    return [future.result() for future in futures]
