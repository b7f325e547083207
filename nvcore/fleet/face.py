"""The calls of Python users: `nvcore.scan`, `nvcore.scan_status`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from nvcore.arguments import PathLike, called_with
from nvcore.errors import InputError, ParameterError
from nvcore.extras import needs
from nvcore.fleet.arguments import ScanArguments
from nvcore.memory import free_bytes
from nvcore.params import Params
from nvcore.progress import with_time_left
from nvcore.wording import aligned, number

if TYPE_CHECKING:
    from nvcore.fleet.results import Summary
    from nvcore.fleet.scan import Engine, Job, Status

BYTES_OF_WORKER = 1_000_000_000


@dataclass(frozen=True, eq=False)
class Scan:
    """What a scan came to.

    Attributes
    ----------
    summary
        Of all recordings; `measures` is its table.
    status
        With the plan, and how many recordings could not be compared.
    """

    summary: Summary
    status: Status

    def __str__(self) -> str:
        measures = self.summary.measures()
        rows = [("", self.status.plan.params.x, self.status.plan.params.y, "n")]
        rows += [
            (row.label, *(number(value, ".4g") for value in (row.x, row.y)), f"{row.n:,}")
            for row in measures.itertuples()
        ]
        return "\n".join([*aligned(rows), "", str(self.status)])


@called_with(ScanArguments)
def scan(arguments: ScanArguments) -> Scan:
    """Compare two systems on all recordings of a store; what was done before is not done again.

    Parameters
    ----------
    store
        Folder or URI of a store, as ``nvcore ingest`` makes it.
    out
        Folder or URI of the results. Each run of the same scan goes on where the last one ended,
        also several at a time; a store that has grown, or another setting, is a new scan, for which
        the same folder serves.
    x, y, truth
        Names in the store: the newest version of each recording, or that of a number or label
        behind ``@``.
    params
        Settings of the comparison; None: by default.
    frames
        Whether the table of frames is kept.
    workers
        Processes on this machine; None: one for each core and each free GB of memory.
    shard
        ``"17/300"``: in this process, beginning with the 17th of 300 parts of the batches.
    scheduler
        Address of a Dask scheduler, whose workers then do it.
    engine
        What runs the batches otherwise: a function of a job (`nvcore.fleet.scan.Engine`).
    retry
        Whether recordings in quarantine are tried again.
    storage
        Keys and values for the object store, as object_store has them; else by the environment.
    progress
        Called with the share of the batches that are done.

    Returns
    -------
    Scan
        When every batch is done.

    Raises
    ------
    InputError
        If the store or `out` cannot be used, no recording has both systems, or a part of the same
        scan was made with other versions of nvcore, numba, numpy or pyarrow.
    StoreError
        If storage fails or is full; what is done by then is kept.

    Examples
    --------
    >>> done = scan("fleet", "night-vision", x="FIR", y="NIR")  # doctest: +SKIP
    >>> done.summary.measures()  # doctest: +SKIP
    """
    if (
        sum(way is not None for way in (arguments.workers, arguments.shard, arguments.scheduler))
        > 1
    ):
        raise ParameterError("workers, shard, scheduler: give one of them")
    part, n_parts = _part(arguments.shard)
    with needs("fleet", "scans need"):
                from nvcore.fleet.location import Location
        from nvcore.fleet.results import ScanParams
        from nvcore.fleet.scan import Job, Options, begin, drive, finish, forget_quarantined, status
        from nvcore.fleet.store import Store
    store = Store(Location(str(arguments.store), arguments.storage))
    out = Location(str(arguments.out), arguments.storage)
    if out.list("sources/"):
        raise InputError("is a store; write the results elsewhere, or below it", file=out.uri)
    params = ScanParams(
        arguments.x,
        arguments.y,
        arguments.truth,
        arguments.params or Params(),
        frames=arguments.frames,
    )
    plan = begin(store, out, params)
    if arguments.retry:
        forget_quarantined(out, plan)
    options = Options(storage=tuple(arguments.storage.items()))
    job = Job(plan.store, out.uri, plan.key, options)
    n = len(plan.batches)
    done = {batch.key for batch in plan.batches}.difference(job.missing())
    progress = with_time_left(arguments.progress)
    progress(len(done) / n, f"{len(done)} of {n} batches")
    for batch in drive(job, _engine(arguments, job)):
        done.add(batch)
        progress(len(done) / n, f"{len(done)} of {n} batches")
    return Scan(finish(out, plan), status(out))


def _engine(arguments: ScanArguments, job: Job) -> Engine:
    """What runs the batches."""
    if arguments.engine is not None:
        return arguments.engine
    if arguments.scheduler is not None:
        from nvcore.fleet.on_dask import on_dask

        return partial(on_dask, scheduler=arguments.scheduler)
    if arguments.shard is not None:
        from nvcore.fleet.scan import in_process

        part, n_parts = _part(arguments.shard)
        return partial(in_process, part=part, n_parts=n_parts)
    from nvcore.fleet.pool import in_pool

    n_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    free = free_bytes()
    n_fit = n_cores if free is None else free // BYTES_OF_WORKER
    n_workers = arguments.workers or max(1, min(n_cores or 1, n_fit or 1, len(job.missing())))
    return partial(in_pool, n_workers=n_workers)


def _part(shard: str) -> tuple[int, int]:
    """Number of the part from 0, and of how many, of ``17/300``."""
    try:
        part, n_parts = map(int, shard.split("/"))
    except ValueError:
        part, n_parts = -1, 0
    if not 0 <= part <= n_parts or n_parts < 1:
        raise ParameterError(f"shard: expected a part such as 17/300, got {shard!r}")
    return part % n_parts, n_parts


def scan_status(out: PathLike, *, storage: dict[str, str] | None = None) -> Status:
    """How far the scan is whose results are written there.

    Raises
    ------
    InputError
        If there is none.
    """
    with needs("fleet", "scans need"):
        from nvcore.fleet.location import Location
        from nvcore.fleet.scan import status
    return status(Location(str(out), storage or {}))
