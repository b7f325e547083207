"""Scans on a Dask cluster: a task for each batch, a few at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING, Final

from nvcore.errors import InputError
from nvcore.extras import needs
from nvcore.fleet.scan import Job

if TYPE_CHECKING:
    from distributed import Future

TASKS_A_THREAD: Final = 3
"""Tasks that the scheduler is given at a time, for each thread of its workers."""
CONNECT_S: Final = 10.0


def run_on_dask(job: Job, scheduler: str) -> Iterator[str]:
    """Run a scan by a scheduler's workers until all its batches are done; keys of batches as they are.

    If the scheduler goes away, another one is waited for, which gets what is missing by then.

    Parameters
    ----------
    scheduler
        Address, such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    InputError, OSError
        What a worker gave up with, or if there is no scheduler for `Options.patience_s`.
    """
    with needs("dask", "scans on Dask need"):
        from distributed import CancelledError, Client, KilledWorker, as_completed
    last_sign_s = time.monotonic()
    while left := job.missing():
        failure: BaseException | None = None
        is_stuck = True
        try:
            with Client(scheduler, timeout=CONNECT_S, set_as_default=False) as client:
                last_sign_s = time.monotonic()
                waiting, batches = iter(left), {}

                def submit(n: int) -> list[Future]:
                    new = [(client.submit(job.run, b, pure=False), b) for b in islice(waiting, n)]
                    batches.update({task.key: batch for task, batch in new})
                    return [task for task, _ in new]

                n_threads = sum(client.nthreads().values())
                tasks = as_completed(submit(TASKS_A_THREAD * max(1, n_threads)))
                for task in tasks:
                    failure = task.exception() if task.status == "error" else None
                    if failure is None and task.result() == "done":
                        is_stuck = False
                        yield batches[task.key]
                    if failure is not None and not isinstance(failure, KilledWorker):
                        break
                    failure = None
                    tasks.update(submit(1))
        except (OSError, CancelledError) as error:
            if time.monotonic() - last_sign_s > job.options.patience_s:
                raise InputError(f"there is no scheduler at {scheduler}") from error
        if failure is not None:
            raise failure
        if is_stuck:  # others are at work on these, or there is no scheduler
            threading.Event().wait(job.options.poll_s)
