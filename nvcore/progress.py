"""How far a long computation is: the one callback for it, and steps that run side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from typing import Final, TypeVar

T = TypeVar("T")
Progress = Callable[[float, str], None]
"""Called with the share that is done, 0..1, and in a few words what comes next.

It may raise `concurrent.futures.CancelledError`: the work then ends and leaves nothing.
"""

POLL_S: Final = 0.05
"""Poll interval for cancellation while other threads work, seconds."""


def no_progress(_share: float, _what: str) -> None:
    """A `Progress` that nobody looks at."""


def part_of(progress: Progress, start: float, end: float) -> Progress:
    """Progress of a part of the work, from one share of the whole to another."""

    def tell(share: float, what: str) -> None:
        progress(start + (end - start) * share, what)

    return tell


def run_steps(
    jobs: Sequence[Callable[[], T]], executor: Executor | None, progress: Progress, what: str
) -> list[T]:
    """Results of all jobs, in their order.

    Parameters
    ----------
    executor
        Runs the jobs; None: this thread, one after the other.
    progress
        Called from this thread before each job and at the end, and now and then while other
        threads work. If it raises, jobs under way in other threads end by themselves, the others
        are never begun.
    what
        For `progress`.
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
            done, pending = wait(pending, POLL_S, FIRST_COMPLETED)
            for future in done:
                future.result()  # an error ends the work here
        progress(1.0, what)
    finally:
        for future in pending:
            future.cancel()
    return [future.result() for future in futures]
