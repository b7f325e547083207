"""The calls of Python users: `nvcore.ingest`, `open_store`, `scan`, `top`, ..."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final

from nvcore.api.inputs import load
from nvcore.arguments import PathLike, called_with
from nvcore.dataset import Dataset
from nvcore.errors import InputError, ParameterError
from nvcore.fleet.arguments import FRAMES_PER_BATCH, OpenArguments, ScanArguments, TopArguments
from nvcore.fleet.ingest import Ingested, ingest_all, sessions_in
from nvcore.fleet.location import Location
from nvcore.fleet.opening import recording_of, write_recording
from nvcore.fleet.plan import begin
from nvcore.fleet.pool import in_pool
from nvcore.fleet.query import Top, results_in, worst
from nvcore.fleet.results import ScanParams, Summary
from nvcore.fleet.scan import (
    Engine,
    Job,
    Options,
    Status,
    drive,
    finish,
    forget_quarantined,
    in_process,
    status,
)
from nvcore.fleet.store import Snapshot, Store, other_settings
from nvcore.inputs.session import Session
from nvcore.memory import free_bytes
from nvcore.params import Params, params_from
from nvcore.progress import with_time_left
from nvcore.wording import aligned, number, one_line

BYTES_OF_WORKER: Final = 1_000_000_000
SCAN_ARGUMENTS: Final = frozenset(inspect.signature(ScanArguments).parameters)


def ingest(
    *inputs: PathLike | Session | Dataset,
    store: PathLike | Store,
    partition: str | None = None,
    labels: Mapping[str, str] | None = None,
    truth_kind: str = "",
    newest: bool = False,
    storage: Mapping[str, str] | None = None,
) -> Ingested:
    """Append recordings to a store; what is there already is left out, what changed is a version.

    Parameters
    ----------
    inputs
        Session files, folders that are searched for session files, sessions, or datasets made by
        `load`. One that cannot be read is left out whole, see `Ingested.errors`.
    store
        A folder, ``s3://bucket/folder`` (with what the environment says of the server), or what
        `open_store` returns; a new one is made.
    partition
        How a new store is divided: by ``month``, ``unit``, or the key of a tag, such as ``route``
        where recordings have tags such as ``route=A9``.
    labels
        What to call these versions, by ``truth`` or the system's name: ``{"FIR": "2026-03"}``.
    truth_kind
        Whether the ground truth is ``"annotated"`` by people, ``"automatic"``, or ``"absent"``.
        Empty: as the store has it, else annotated.
    newest
        Whether versions that the store has become the newest again.
    storage
        As of `open_store`.

    Returns
    -------
    Ingested
        What was appended, and what could not be.

    Raises
    ------
    InputError
        If a folder holds no session file, or the store is divided in another way.
    ParameterError
        If `partition` or `storage` is given with an opened store.
    StoreError
        If the store cannot be read or written; what was appended until then is in it.

    Examples
    --------
    >>> done = ingest("drives", store="fleet", labels={"FIR": "2026-03"})  # doctest: +SKIP
    >>> len(done.recordings), done.errors  # doctest: +SKIP
    (10, {})
    """
    if not isinstance(store, Store):
        store = Store(Location(store, storage), partition=partition)
    elif partition is not None or storage is not None:
        raise ParameterError("partition, storage: the store that is given has its own")
    return ingest_all(_named(inputs), store, truth_kind=truth_kind, labels=labels, newest=newest)


def _named(
    inputs: tuple[PathLike | Session | Dataset, ...],
) -> Iterator[tuple[str, Callable[[], Dataset]]]:
    for place, of in enumerate(inputs):
        if isinstance(of, Session | Dataset):
            yield f"input {place + 1}", partial(load, of)
        else:
            yield from sessions_in([Path(of)], load)


def open_store(uri: PathLike, *, storage: Mapping[str, str] | None = None) -> Store:
    """A store of recordings: `Store.snapshot` shows what it holds, `ingest` appends to it.

    Parameters
    ----------
    uri
        A folder, or ``s3://bucket/folder``.
    storage
        Of the server, by keys such as ``aws_endpoint_url``; what is not given is taken from the
        environment (``AWS_ENDPOINT_URL``).

    Raises
    ------
    InputError
        If there can be no store at such a place. Whether there is one is asked for later.
    """
    return Store(Location(uri, storage))


@dataclass(frozen=True, eq=False)
class Scan:
    """What a scan came to.

    Attributes
    ----------
    summary
        Of all recordings; `measures` is its table.
    status
        With the plan, and how many recordings could not be compared.
    note
        Settings of the ingested sessions that the scan does not use; empty: none.
    """

    summary: Summary
    status: Status
    note: str = ""

    def __str__(self) -> str:
        measures = self.summary.measures()
        rows = [("", self.summary.params.x, self.summary.params.y, "n")]
        rows += [
            (label, number(x, ".4g"), number(y, ".4g"), f"{n:,}")
            for label, x, y, n in measures[["label", "x", "y", "n"]].to_numpy().tolist()
        ]
        given = self.summary.params.params.given().items() - Params().given().items()
        settings = ", ".join(f"{name} {value}" for name, value in sorted(given))
        settings = f"with {settings}" if settings else "with the settings by default"
        notes = [one_line(f"note: {self.note}")] if self.note else []
        return "\n".join([*aligned(rows), "", one_line(settings), *notes, str(self.status)])


def scan(*given: Any, params: Params | None = None, **named: Any) -> Scan:
    """Compare two systems on all recordings of a store; `_scan` has the parameters."""
    settings = {name: named.pop(name) for name in [*named] if name not in SCAN_ARGUMENTS}
    if settings:
        params = params_from({**asdict(params or Params()), **settings})
    return _scan(*given, params=params, **named)


@called_with(ScanArguments)
def _scan(arguments: ScanArguments) -> Scan:
    """Compare two systems on all recordings of a store; what was done before is not done again.

    Each run of the same scan goes on where the last one ended, also several at a time; a store that
    has grown, or another setting, is a new scan, for which the same folder serves.

    Parameters
    ----------
    store
        Folder or URI of a store, as ``nvcore ingest`` makes it, or what `open_store` returns.
    params
        Settings of the comparison; None: by default. Each may also be given by its name, as to
        `nvcore.compare`: ``alpha=0.8``.
    engine
        What runs the batches otherwise: a function of a job (`nvcore.fleet.scan.Engine`).
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
        scan was made with other versions of nvcore, numba, numpy, pandas, pyarrow or scipy.
    StoreError
        If storage fails or is full; what is done by then is kept.

    Examples
    --------
    >>> done = scan("fleet", "night-vision", x="FIR", y="NIR")  # doctest: +SKIP
    >>> done.summary.measures()  # doctest: +SKIP
    """
    ways = (arguments.workers, arguments.shard, arguments.scheduler, arguments.engine)
    if sum(way is not None for way in ways) > 1:
        raise ParameterError("workers, shard, scheduler, engine: give one of them")
    if arguments.retry and arguments.shard is not None:
        raise ParameterError("retry: each task would undo what others have done; run it by itself")
    store = arguments.store
    if not isinstance(store, Store):
        store = Store(Location(str(store), arguments.storage))
    storage = dict(arguments.storage) or store.location.options
    out = Location(str(arguments.out), storage)
    if out.list("sources/"):
        raise InputError("is a store; write the results elsewhere, or below it", file=out.uri)
    params = ScanParams(
        arguments.x,
        arguments.y,
        arguments.truth,
        arguments.params or Params(),
        frames=arguments.frames,
    )
    plan = begin(store, out, params, frames_per_batch=arguments.frames_per_batch)
    if arguments.retry:
        forget_quarantined(out, plan)
    engine = _engine(arguments, max(batch.n_frames for batch in plan.batches))
    options = Options(storage=tuple(storage.items()), keep=arguments.keep)
    job = Job(plan.store, out.uri, plan.key, options)
    n = len(plan.batches)
    done = {batch.key for batch in plan.batches}.difference(job.missing())
    progress = with_time_left(arguments.progress)
    progress(len(done) / n, f"{len(done)} of {n} batches")
    for batch in drive(job, engine):
        done.add(batch)
        progress(len(done) / n, f"{len(done)} of {n} batches")
    summary = finish(out, plan)
    compared = [name for batch in plan.batches for name in batch.recordings]
    recordings = Snapshot(store.location, plan.versions).recordings.loc[compared]
    note = other_settings(recordings, params.params)
    if summary.quarantined:
        return Scan(summary, status(out, plan), note)
    return Scan(summary, Status(plan, n, plan.n_frames, 0, 0, 0, is_finished=True), note)


scan.__doc__ = _scan.__doc__  # with all parameters
scan.__signature__ = inspect.signature(_scan)  # type: ignore[attr-defined]


def _engine(arguments: ScanArguments, largest: int) -> Engine:
    """What runs the batches, of which the largest has so many frames."""
    if arguments.engine is not None:
        return arguments.engine
    if arguments.scheduler is not None:
        from nvcore.fleet.on_dask import on_dask

        return partial(on_dask, scheduler=arguments.scheduler)
    if arguments.shard is not None:
        part, n_parts = _part(arguments.shard)
        return partial(in_process, part=part, n_parts=n_parts)
    n_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    free = free_bytes()
    each = BYTES_OF_WORKER * max(1, largest / FRAMES_PER_BATCH)
    n_fit = n_cores if free is None else int(free / each)
    n_workers = arguments.workers or max(1, min(n_cores or 1, n_fit or 1))
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
    return status(Location(str(out), storage or {}))


@called_with(TopArguments)
def top(arguments: TopArguments) -> Top:
    """The worst rows of the results of a scan, each with the frame to look at.

    Parameters
    ----------
    results
        Folder or URI that the scan has written to, or of the store, if one lies below it.
    where
        A condition on the columns of the table, on those of the recordings (``unit``, ``fps``, or
        ``recording.n_frames`` where the table has such a column, too) and on tags: ``"tag.night"``,
        ``"tag.road = 'rural' and n_frames > 10"``. Empty: all rows.
    storage
        As of `nvcore.scan`.

    Returns
    -------
    Top
        With `table`, a DataFrame.

    Raises
    ------
    InputError
        If there are no results, no such table or column, or the condition cannot be used.

    Examples
    --------
    >>> top("night-vision", by="severity", where="tag.road = 'rural'")  # doctest: +SKIP
    """
    results = results_in(Location(str(arguments.results), arguments.storage))
    return worst(
        results,
        arguments.table,
        by=arguments.by,
        where=arguments.where,
        n=arguments.n,
        is_reversed=arguments.reverse,
    )


@called_with(OpenArguments)
def export_recording(arguments: OpenArguments) -> Path:
    """Write a recording of a store as a session, which gives the numbers of the scan.

    Parameters
    ----------
    source
        Folder or URI of the results of a scan: X, Y, settings and versions are the scan's. Or of a
        store: its newest versions, with the settings by default.
    recording
        Its name.
    out
        Folder of the session, which `nvcore.load` reads.
    storage
        As of `nvcore.scan`.

    Returns
    -------
    Path
        The session file.

    Raises
    ------
    InputError
        If there is no such recording or source, or the folder cannot be written to.

    Examples
    --------
    >>> dataset = nv.load(export_recording("night-vision", "drive 7", "seven"))  # doctest: +SKIP
    """
    if arguments.out is None:
        raise ParameterError("out: expected the folder of the session")
    dataset, shown = recording_of(
        Location(str(arguments.source), arguments.storage),
        arguments.recording,
        x=arguments.x,
        y=arguments.y,
        truth=arguments.truth,
    )
    return write_recording(dataset, Path(arguments.out), **shown, force=arguments.force)
