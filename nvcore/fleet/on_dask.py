"""Scans on a Dask cluster: a task for each batch, a few at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Final

from nvcore.errors import InputError
from nvcore.extras import needs
from nvcore.fleet.scan import Job

TASKS: Final = 20_000
"""Tasks that the scheduler is given at a time."""
CONNECT_S: Final = 10.0


def run_on_dask(job: Job, scheduler: str) -> Iterator[str]:
    """Run a scan by the workers of a scheduler until all is done; keys of batches as they are.

    If the scheduler goes away, another one is waited for, which gets what is missing by then.

    Parameters
    ----------
    scheduler
        Address, such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    InputError
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
                tasks = client.map(job.run, left[:TASKS], pure=False)
                batch_of = {task.key: batch for task, batch in zip(tasks, left, strict=False)}
                for task in as_completed(tasks, loop=client.loop):
                    failure = task.exception() if task.status == "error" else None
                    if isinstance(failure, KilledWorker):  # its worker, some times: another round
                        failure = None
                    elif failure is not None:
                        break
                    elif task.result() == "done":
                        is_stuck = False
                        yield batch_of[task.key]
        except (OSError, CancelledError) as error:
            if time.monotonic() - last_sign_s > job.options.patience_s:
                raise InputError(f"there is no scheduler at {scheduler}") from error
        if failure is not None:
            raise failure
        if is_stuck:  # others are at work on these, or there is no scheduler
            threading.Event().wait(job.options.poll_s)
