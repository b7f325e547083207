"""Steps of a long computation: side by side, with progress, and stopped on a wish."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from typing import Final, TypeVar

T = TypeVar("T")
Progress = Callable[[int, int], None]
"""Told how many of how many steps are done."""

POLL_S: Final = 0.05
"""How long a wish to stop may go unheard while other threads work."""


def run_steps(
    jobs: Sequence[Callable[[], T]],
    executor: Executor | None,
    progress: Progress | None,
    is_cancelled: Callable[[], bool] | None,
) -> list[T]:
    """Results of all jobs, in their order.

    Parameters
    ----------
    executor
        Runs the jobs; None: this thread, one after the other.
    progress
        Called from this thread, after each job.
    is_cancelled
        Asked between jobs. Those under way in other threads end by themselves, the others are
        taken back.

    Raises
    ------
    concurrent.futures.CancelledError
        If `is_cancelled` said so.
    """
    tell = progress or (lambda _done, _total: None)
    stop = is_cancelled or (lambda: False)
    if executor is None:
        results: list[T] = []
        for job in jobs:
            if stop():
                raise CancelledError
            results.append(job())
            tell(len(results), len(jobs))
        return results
    futures: list[Future[T]] = [executor.submit(job) for job in jobs]
    pending, n_done = set(futures), 0
    try:
        while pending:
            if stop():
                raise CancelledError
            done, pending = wait(pending, POLL_S, FIRST_COMPLETED)
            for future in done:
                future.result()  # an error ends the map here
                n_done += 1
                tell(n_done, len(jobs))
    finally:
        for future in pending:
            future.cancel()
    return [future.result() for future in futures]
