"""Engine that runs a scan on a Dask cluster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from typing import Final

from nvcore.common.errors import InputError
from nvcore.common.extras import needs
from nvcore.subjects.fleet.scan import Job

with needs("dask", "scans on Dask need"):
    from distributed import CancelledError, Client, KilledWorker, as_completed
    from distributed.comm.core import CommClosedError

TASKS: Final = 20_000
"""Number of tasks that the scheduler gets at a time."""
PATIENCE_S: Final = 300.0
"""Longest wait for a scheduler that does not answer."""


def on_dask(job: Job, scheduler: str) -> Iterator[str]:
    """Run missing batches on the workers of a Dask scheduler, and yield keys of finished ones.

    If the scheduler disappears, the others are left for the next round, which waits for it.

    Parameters
    ----------
    scheduler
        Address, such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    InputError
        If a worker raises it, or the scheduler does not answer for `PATIENCE_S`.
    """
    try:
        client = Client(scheduler, timeout=PATIENCE_S, set_as_default=False)
    except (AssertionError, OSError, ValueError) as error:
        raise InputError(
            f"there is no Dask scheduler at {scheduler}; expected an address such as "
            "tcp://10.0.0.1:8786"
        ) from error
    with client, suppress(CancelledError, CommClosedError):
        missing = job.missing()[:TASKS]
        batch_of = dict(zip(client.map(job.run, missing, pure=False), missing, strict=True))
        for task in as_completed(batch_of, loop=client.loop):
            with suppress(KilledWorker):  # killed several times: the next round counts how often
                if task.result() == "done":
                    yield batch_of[task]
