"""Python API of stores and scans, such as `nvcore.ingest` and `nvcore.scan`, with arguments.

Commands import this module for its arguments, so calls import numpy and the packages for stores.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click

from nvcore.common.arguments import INPUTS, OUTPUT, PathLike, argument, arguments, called_with
from nvcore.common.errors import InputError, ParameterError
from nvcore.common.progress import Progress, no_progress, with_time_left
from nvcore.common.wording import aligned, number, one_line
from nvcore.settings.params import Params, params_from

if TYPE_CHECKING:
    from nvcore.dataset import Dataset
    from nvcore.inputs.session import Session
    from nvcore.subjects.fleet.folder import Status
    from nvcore.subjects.fleet.ingest import Ingested
    from nvcore.subjects.fleet.query import Top
    from nvcore.subjects.fleet.results import Summary
    from nvcore.subjects.fleet.scan import Engine
    from nvcore.subjects.fleet.store import Store

BYTES_OF_WORKER: Final = 1_000_000_000
RUN: Final = "How it is run"
SELECTION: Final = "Selection"
FRAMES_PER_BATCH: Final = 100_000
"""Default size of batches, for which a worker takes about 0.9 GB with 11 boxes per frame."""


@arguments
class ScanArguments:
    """Arguments of `nvcore.scan`."""

    store: PathLike | Store
    out: PathLike = argument(
        OUTPUT,
        "Folder of the results: a path, or a URI such as s3://bucket/results.",
        metavar="URI",
    )
    _: KW_ONLY
    x: str = argument(
        INPUTS,
        "System X, by its name in the store: its newest version, or FIR@2, or FIR@name.",
        metavar="SYSTEM",
    )
    y: str = argument(INPUTS, "System Y, likewise.", metavar="SYSTEM")
    truth: str = argument(
        INPUTS, "The truth, likewise, such as truth@1.", default="truth", metavar="SOURCE"
    )
    params: Params | None = None
    frames: bool = argument(
        OUTPUT, "Keep the table with a row for each frame, too.", default=False, is_flag=True
    )
    workers: int | None = argument(
        RUN,
        "Processes on this machine. Default: one for each core and each free GB of memory.",
        default=None,
        type=click.IntRange(min=1),
    )
    frames_per_batch: int = argument(
        RUN,
        "Frames that a worker compares at a time. Smaller batches take less memory and lose less "
        "when a worker dies, larger ones make fewer files.",
        default=FRAMES_PER_BATCH,
        type=click.IntRange(min=1_000),
    )
    shard: str | None = argument(
        RUN,
        "In this process alone, beginning with its part of the batches: 17/300 is task 17 of an "
        "array job with 300 (counted from 0 or 1). A task ends when all batches are done; those of "
        "tasks that died are done by others.",
        default=None,
        metavar="I/N",
    )
    scheduler: str | None = argument(
        RUN, "Address of a Dask scheduler, whose workers do it.", default=None, metavar="ADDRESS"
    )
    engine: Engine | None = None
    retry: bool = argument(
        RUN, "Try again the recordings that are in quarantine.", default=False, is_flag=True
    )
    recompute: bool = argument(
        RUN,
        "Compute anew what another program, or other versions of the libraries, wrote there.",
        default=False,
        is_flag=True,
    )
    storage: Mapping[str, str] = field(default_factory=dict)
    progress: Progress = no_progress


@arguments
class TopArguments:
    """Arguments of `nvcore.top`."""

    results: PathLike
    _: KW_ONLY
    table: str = argument(
        SELECTION,
        "Which results: encounters, events, intervals, episodes, recordings, or frames where the "
        "scan has kept them.",
        default="encounters",
        metavar="TABLE",
    )
    by: str | None = argument(
        SELECTION,
        "A column, with or without its unit and the letter of a system: severity is the larger one "
        "of both. Default: severity; saliency of events, depth of intervals, duration of episodes, "
        "similarity of frames.",
        default=None,
        metavar="COLUMN",
    )
    where: str = argument(
        SELECTION,
        "Only rows for which this holds, such as \"tag.road = 'rural' and n_frames > 10\" "
        "(docs/fleet.md).",
        default="",
        metavar="CONDITION",
    )
    n: int = argument(
        SELECTION, "Number of rows.", flag="-n", default=20, type=click.IntRange(min=1), metavar="N"
    )
    reverse: bool = argument(SELECTION, "The best first.", default=False, is_flag=True)
    storage: Mapping[str, str] = field(default_factory=dict)


@arguments
class OpenArguments:
    """Arguments of `nvcore.export_recording`."""

    source: PathLike
    recording: str
    out: PathLike | None = argument(
        OUTPUT,
        "Write the recording as a session into this folder, and start nothing.",
        default=None,
        metavar="DIR",
    )
    _: KW_ONLY
    force: bool = argument(OUTPUT, "Replace files of that folder.", default=False, is_flag=True)
    x: str | None = argument(
        INPUTS,
        "System X of a store, as for scan. Default: those of the scan, or the recording's only two "
        "systems.",
        default=None,
        metavar="SYSTEM",
    )
    y: str | None = argument(INPUTS, "System Y, likewise.", default=None, metavar="SYSTEM")
    truth: str | None = argument(INPUTS, "The truth, likewise.", default=None, metavar="SOURCE")
    storage: Mapping[str, str] = field(default_factory=dict)


def ingest(
    *inputs: PathLike | Session | Dataset,
    store: PathLike | Store,
    labels: Mapping[str, str] | None = None,
    truth_kind: str = "",
    newest: bool = False,
    storage: Mapping[str, str] | None = None,
) -> Ingested:
    """Append new and changed recordings to a store, changed ones as new versions.

    Parameters
    ----------
    inputs
        Session files, folders that are searched for session files, sessions, or datasets made by
        `load`. Inputs that cannot be read are skipped entirely (see `Ingested.errors`).
    store
        A folder, ``s3://bucket/folder`` (with the server's settings from the environment), or the
        result of `open_store`. A missing store is created.
    labels
        Labels of these versions, by ``truth`` or the system's name: ``{"FIR": "2026-03"}``.
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
        Appended versions, and errors by input.

    Raises
    ------
    InputError
        If a folder contains no session file.
    ParameterError
        If `storage` is given with an opened store.
    StoreError
        If the store cannot be read or written. Batches that were appended before stay.

    Examples
    --------
    >>> done = ingest("drives", store="fleet", labels={"FIR": "2026-03"})  # doctest: +SKIP
    >>> len(done.recordings), done.errors  # doctest: +SKIP
    (10, {})
    """
    from nvcore.subjects.fleet.ingest import ingest_all
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.store import Store

    if not isinstance(store, Store):
        store = Store(Location(store, storage))
    elif storage is not None:
        raise ParameterError("storage: the store that is given has its own")
    return ingest_all(_named(inputs), store, truth_kind=truth_kind, labels=labels, newest=newest)


def _named(
    inputs: tuple[PathLike | Session | Dataset, ...],
) -> Iterator[tuple[str, Callable[[], Dataset]]]:
    from nvcore.api.inputs import load
    from nvcore.dataset import Dataset
    from nvcore.inputs.session import Session
    from nvcore.subjects.fleet.ingest import sessions_in

    for place, of in enumerate(inputs):
        if isinstance(of, Session | Dataset):
            yield f"input {place + 1}", partial(load, of)
        else:
            yield from sessions_in([Path(of)], load)


def open_store(uri: PathLike, *, storage: Mapping[str, str] | None = None) -> Store:
    """Open a store of recordings: `Store.snapshot` shows its content, `ingest` appends to it.

    Parameters
    ----------
    uri
        A folder, or ``s3://bucket/folder``.
    storage
        Settings of the server, by keys such as ``aws_endpoint_url``. The environment sets the
        others (``AWS_ENDPOINT_URL``).

    Raises
    ------
    InputError
        If the URI is invalid for a store. Whether the store exists is checked later.
    """
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.store import Store

    return Store(Location(uri, storage))


@dataclass(frozen=True, eq=False)
class Scan:
    """Result of a scan.

    Attributes
    ----------
    summary
        Measures of all recordings, with `measures` as the table.
    status
        Plan, and number of recordings that could not be compared.
    notes
        Damaged files of earlier results, whose batches were computed anew, and settings of the
        ingested sessions that the scan does not use.
    """

    summary: Summary
    status: Status
    notes: Sequence[str] = ()

    def __str__(self) -> str:
        measures = self.summary.measures()
        rows = [("", self.summary.params.x, self.summary.params.y, "n")]
        rows += [
            (label, number(x, ".4g"), number(y, ".4g"), f"{n:,}")
            for label, x, y, n in measures[["label", "x", "y", "n"]].to_numpy().tolist()
        ]
        given = self.summary.params.params.given().items() - Params().given().items()
        settings = ", ".join(f"{name} {value}" for name, value in sorted(given))
        lines = [f"with {settings}" if settings else "with the settings by default"]
        lines += [f"note: {note}" for note in self.notes]
        return "\n".join([*aligned(rows), "", *map(one_line, lines), str(self.status)])


def scan(*given: Any, params: Params | None = None, **named: Any) -> Scan:
    """Compare two systems on all recordings of a store (parameters: `_scan`)."""
    own = inspect.signature(ScanArguments).parameters
    settings = {name: named.pop(name) for name in [*named] if name not in own}
    if settings:
        params = params_from({**(params or Params()).given(), **settings})
    return _scan(*given, params=params, **named)


@called_with(ScanArguments)
def _scan(arguments: ScanArguments) -> Scan:
    """Compare two systems on all recordings of a store, or resume a scan that was stopped.

    Each run of the same scan continues where the last one ended. Several may run at a time. A store
    with new content, or another setting, is a new scan, which may use the same folder.

    Parameters
    ----------
    store
        Folder or URI of a store that ``nvcore ingest`` wrote, or the result of `open_store`.
    params
        Settings of the comparison. None: the default ones. Each may also be a keyword argument, as
        in `nvcore.compare`: ``alpha=0.8``.
    engine
        A function of a job that runs the batches (`nvcore.subjects.fleet.scan.Engine`).
    storage
        Keys and values for the object store, as in object_store. The environment sets the others.
    progress
        Called with the share of finished batches.

    Returns
    -------
    Scan
        When every batch is done.

    Raises
    ------
    InputError
        If the store or `out` cannot be used, no recording has both systems, or existing results
        are from another program.
    StoreError
        If storage fails or is full. Finished batches are kept.

    Examples
    --------
    >>> done = scan("fleet", "night-vision", x="FIR", y="NIR")  # doctest: +SKIP
    >>> done.summary.measures()  # doctest: +SKIP
    """
    from nvcore.subjects.fleet.folder import (
        Status,
        begin,
        finish,
        forget_quarantined,
        repair,
        status,
    )
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.results import ScanParams
    from nvcore.subjects.fleet.scan import Job, Options, drive
    from nvcore.subjects.fleet.store import Store, other_settings

    ways = (arguments.workers, arguments.shard, arguments.scheduler, arguments.engine)
    if sum(way is not None for way in ways) > 1:
        raise ParameterError("workers, shard, scheduler, engine: give one of them")
    if arguments.retry and arguments.shard is not None:
        raise ParameterError("retry: each task would undo what others have done; run it by itself")
    part, n_parts = _part(arguments.shard)
    store = arguments.store
    if not isinstance(store, Store):
        store = Store(Location(str(store), arguments.storage))
    storage = dict(arguments.storage) or store.location.options
    out = Location(str(arguments.out), storage)
    if out.list("sources/"):
        raise InputError("is a store; write the results elsewhere, or below it", file=out.uri)
    names = arguments.x, arguments.y, arguments.truth
    params = ScanParams(*names, arguments.params or Params(), frames=arguments.frames)
    snapshot = store.snapshot()
    plan = begin(
        snapshot,
        out,
        params,
        recompute=arguments.recompute,
        frames_per_batch=arguments.frames_per_batch,
    )
    notes = [f"computed anew: {of}" for of in repair(out, plan, slice(part, None, n_parts))]
    compared = [name for batch in plan.batches for name in batch.recordings]
    notes += filter(None, [other_settings(snapshot.recordings.loc[compared], params.params)])
    if arguments.retry:
        forget_quarantined(out, plan)
    job = Job(plan.store, out.uri, plan.key, Options(storage=tuple(storage.items())))
    n = len(plan.batches)
    done = {batch.key for batch in plan.batches}.difference(job.missing())
    progress = with_time_left(arguments.progress)
    progress(len(done) / n, f"{len(done)} of {n} batches")
    for batch in drive(job, _engine(arguments, max(batch.n_frames for batch in plan.batches))):
        done.add(batch)
        progress(len(done) / n, f"{len(done)} of {n} batches")
    summary = finish(out, plan)
    if summary.quarantined:
        return Scan(summary, status(out, plan), notes)
    return Scan(summary, Status(plan, n, plan.n_frames, 0, 0, 0, is_finished=True), notes)


scan.__doc__ = _scan.__doc__  # with all parameters
scan.__signature__ = inspect.signature(_scan)  # type: ignore[attr-defined]


def _engine(arguments: ScanArguments, largest: int) -> Engine:
    """Choose the engine that runs the batches.

    `largest` is the number of frames of the largest batch.
    """
    from nvcore.common.memory import free_bytes
    from nvcore.subjects.fleet.scan import in_pool, in_process

    if arguments.engine is not None:
        return arguments.engine
    if arguments.scheduler is not None:
        from nvcore.subjects.fleet.on_dask import on_dask

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


def _part(shard: str | None) -> tuple[int, int]:
    """Parse a shard such as ``17/300`` into its number, from 0, and the number of shards."""
    try:
        part, n_parts = map(int, (shard or "0/1").split("/"))
    except ValueError:
        part, n_parts = -1, 0
    if not 0 <= part <= n_parts or n_parts < 1:
        raise ParameterError(f"shard: expected a part such as 17/300, got {shard!r}")
    return part % n_parts, n_parts


def scan_status(out: PathLike, *, storage: dict[str, str] | None = None) -> Status:
    """Return the progress of the scan that writes its results to `out`.

    Raises
    ------
    InputError
        If there is no scan, or one of its files is damaged.
    """
    from nvcore.subjects.fleet.folder import status
    from nvcore.subjects.fleet.location import Location

    return status(Location(str(out), storage or {}))


@called_with(TopArguments)
def top(arguments: TopArguments) -> Top:
    """Find the worst rows in a scan's results, each with the frame to look at.

    Parameters
    ----------
    results
        Folder or URI of the results, or of a folder that contains a single one with results.
    where
        A condition on the columns of the table, on those of the recordings (``unit``, ``fps``, or
        ``recording.n_frames`` if the table also has such a column) and on tags: ``"tag.night"``,
        ``"tag.road = 'rural' and n_frames > 10"``. Empty: all rows.
    storage
        As of `nvcore.scan`.

    Returns
    -------
    Top
        Result with the DataFrame `table`.

    Raises
    ------
    InputError
        If there are no results, no such table or column, or the condition is invalid.

    Examples
    --------
    >>> top("night-vision", by="severity", where="tag.road = 'rural'")  # doctest: +SKIP
    """
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.query import results_in, worst

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
    """Write a recording of a store as a session that reproduces the numbers of the scan.

    Parameters
    ----------
    source
        Folder or URI of a scan's results, whose X, Y, settings and versions are used, or of a
        store, whose newest versions are used with default settings.
    recording
        Name of the recording.
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
    from nvcore.subjects.fleet.location import Location
    from nvcore.subjects.fleet.opening import recording_of, write_recording

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
