"""Scans: the comparison of all recordings of a store, batch by batch, on whatever runs them.

A scan keeps all it knows in the folder of its results, so that any number of processes on any
number of machines can work on it, and any of them may die:

    plans/<plan>.json              what is compared, by which programs, and in which batches
    stages/<inputs>-<settings>.zip what a later scan with other settings reuses of a batch
    leases/<batch>/<attempt>.json  who is at work on a batch, and until when the others wait
    done/<batch>.json              which files a batch has given
    <table>/<batch>-<hash>.parquet its rows of each table of results, listed in a Delta table
    newest.json                    which plan was begun last
    summary.json                   which plan the tables are of, and their versions
    finished/<plan>.json           the same of each plan that was finished

A batch is named by all its results depend on, a file by its content: what two processes do twice is
the same. Leases and what is done are created on condition that they are not there yet.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, Final

import pyarrow as pa
import pyarrow.parquet as pq
from deltalake import DeltaTable
from deltalake.exceptions import CommitFailedError, TableNotFoundError
from deltalake.transaction import AddAction, RemoveAction
from obstore.exceptions import BaseError

from nvcore.errors import InputError, NvcoreError, StoreError
from nvcore.fleet.batch import scan_batch
from nvcore.fleet.leases import Lease, attempt_of, claim, is_held
from nvcore.fleet.location import LONGEST_REASON, Location
from nvcore.fleet.plan import SUMMARY, Batch, Plan, is_finished, newest_plan, plan_in
from nvcore.fleet.results import ScanParams, Summary, gather
from nvcore.fleet.reuse import Frozen, can_reuse, stage_key
from nvcore.fleet.store import Snapshot
from nvcore.wording import count_text, one_line, shortened

WHOLE_ATTEMPTS: Final = 2
"""Attempts at a whole batch; afterwards its recordings are taken one at a time."""
ATTEMPTS: Final = 2
"""Workers that a single recording may end before it is left out."""
COMMIT_ATTEMPTS: Final = 30
"""At the version of a table of results, of processes that finish at once."""
_M_ARENA_MAX: Final = -8
"""Of mallopt(3)."""


Clock = Callable[[], float]
"""Seconds since 1970."""


@dataclass(frozen=True)
class Options:
    """How a scan is run; no result depends on it.

    Attributes
    ----------
    storage
        Keys and values for the storage of the store and of the results, as object_store has them.
    lease_s
        How long a batch waits for its worker, if that gives no sign of life, until another takes
        it. The clocks of machines should differ by less.
    poll_s
        How long a worker that finds no free batch waits at first.
    patience_s
        How long a scheduler that does not answer is waited for.
    clock
        Seconds since 1970, for leases.
    keep
        Whether each batch keeps what a later scan with other settings reuses.
    run
        What is called on the tables of whole recordings: `scan_batch`.
    """

    storage: tuple[tuple[str, str], ...] = ()
    lease_s: float = 120.0
    poll_s: float = 0.2
    patience_s: float = 300.0
    clock: Clock = time.time
    keep: bool = True
    run: Callable[..., tuple[dict[str, pa.Table], Summary]] = scan_batch


def run_batch(
    store_uri: str, out_uri: str, plan_key: str, batch_key: str, options: Options = Options()
) -> str:
    """Compare the recordings of a batch and write what comes out; harmless if it was done before.

    The one function that every engine calls.

    Parameters
    ----------
    store_uri, out_uri
        Where the store and the results are.
    plan_key, batch_key
        `Plan.key`, `Batch.key`.

    Returns
    -------
    str
        ``done``, or ``busy`` if another worker is at it.

    Raises
    ------
    InputError
        If the programs are others than the plan's.
    StoreError
        If storage cannot be written to or read from, as where a disk is full; what is done stays.
    """
    out, read, its_plan, batches = _opened(store_uri, out_uri, plan_key, options.storage)
    its_plan.check_programs()
    done = f"done/{batch_key}.json"
    if out.find(done):
        return "done"
    lease = claim(out, batch_key, options.lease_s, options.clock)
    if lease is None:
        return "busy"
    with lease:
        if not out.find(done):  # its last worker may just have ended
            parts = _compared(batches[batch_key], read, its_plan.params, out, lease, options)
            out.create(done, _write(out, batch_key, *parts))
            del parts
            _give_back_memory()
    return "done"


@lru_cache(maxsize=2)
def _opened(
    store_uri: str, out_uri: str, plan_key: str, storage: tuple[tuple[str, str], ...]
) -> tuple[Location, Callable[..., dict[str, pa.Table]], Plan, dict[str, Batch]]:
    """Results, reader of the store, plan and its batches: once a process."""
    _use_one_heap()
    out = Location(out_uri, dict(storage))
    found = plan_in(out, plan_key)
    if found is None:
        raise StoreError("cannot be read (the plan of the scan is not there)", file=out.uri)
    snapshot = Snapshot(Location(store_uri, dict(storage)), found.versions)
    read = partial(snapshot.read, sources=found.params.sources)
    return out, read, found, {batch.key: batch for batch in found.batches}


def _compared(
    batch: Batch,
    read: Callable[[Sequence[str]], dict[str, pa.Table]],
    params: ScanParams,
    out: Location,
    lease: Lease,
    options: Options,
) -> tuple[dict[str, pa.Table], Summary]:
    """Results of a batch, of its recordings one at a time if they fail together."""
    if lease.n_killed < WHOLE_ATTEMPTS:
        try:
            return _compared_at_once(batch, read, params, out, options)
        except Exception as error:  # noqa: BLE001  # whatever it is: which recording is it about?
            _give_up_without_storage(error)
            lease.tell(failed=_reason(error))
    parts, reasons, faults = [], {}, 0
    for name in batch.recordings:
        n_killed = lease.killed_at.count(name)
        if n_killed >= ATTEMPTS:
            reasons[name] = f"{n_killed} workers ended without a word while they compared it"
            continue
        lease.tell(at=name)
        try:
            parts.append(options.run(read([name]), params)[0])
        except Exception as error:
            _give_up_without_storage(error)
            faults += not isinstance(error, NvcoreError)
            if faults == len(batch.recordings) > 1:  # then it is no fault of theirs
                raise
            reasons[name] = _reason(error)
    for part in parts:
        reasons |= dict(zip(*part["quarantine"].to_pydict().values(), strict=True))
    results = gather(parts, reasons, has_frames=params.frames)
    return results, Summary.of(results, params)


def _compared_at_once(
    batch: Batch,
    read: Callable[[Sequence[str]], dict[str, pa.Table]],
    params: ScanParams,
    out: Location,
    options: Options,
) -> tuple[dict[str, pa.Table], Summary]:
    """Results of a batch, with what an earlier scan has kept of it, or keeping that for others."""
    key = stage_key(params)
    path = f"stages/{batch.inputs}-{key[:16]}.zip"
    stages: dict[str, Frozen] | None = {} if options.keep and can_reuse(params) else None
    if stages is not None:
        with suppress(FileNotFoundError):
            # from far away in one piece: a request takes longer than what it saves
            stages[key] = out.open(path) if out.path else out.read(path)
    kept = None if stages is None else stages.get(key)
    tables = read(batch.recordings)
    if kept is None:
        tables["boxes"]  # read now: a damaged file is no fault of all of these recordings
        pa.default_memory_pool().release_unused()  # the pieces that they were put together from
    results = options.run(tables, params, stages=stages)
    content = stages.get(key) if stages else None
    if isinstance(content, bytes) and content is not kept:
        out.write(path, content)
    return results


def _use_one_heap() -> None:
    """Have all threads allocate from one heap: each would keep what it has freed."""
    with suppress(AttributeError, OSError, TypeError):  # glibc alone has it
        ctypes.CDLL(None).mallopt(_M_ARENA_MAX, 1)


def _give_back_memory() -> None:
    """Return what was freed to the system: allocators keep as much as the largest batch took."""
    pa.default_memory_pool().release_unused()
    with suppress(AttributeError, OSError, TypeError):  # glibc alone has it
        ctypes.CDLL(None).malloc_trim(0)


def _reason(error: Exception) -> str:
    """What happened, in one line."""
    kind = "" if isinstance(error, NvcoreError) else f"{type(error).__name__}: "
    return shortened(one_line(f"{kind}{error}"), LONGEST_REASON)


def _give_up_without_storage(error: Exception) -> None:
    """Raise what is no fault of a recording: the storage fails, and would for all others.

    A damaged file is an OSError, too, but not one of the system.
    """
    is_of_system = isinstance(error, OSError) and error.errno is not None
    if isinstance(error, StoreError | BaseError) or (
        is_of_system and not isinstance(error, FileNotFoundError)
    ):
        raise error


def _write(out: Location, key: str, tables: dict[str, pa.Table], summary: Summary) -> bytes:
    """Write the results of a batch; what is to be known of them, as JSON."""
    files = {}
    for name, table in tables.items():
        content = _as_parquet(table)
        sha256 = hashlib.sha256(content).hexdigest()
        path = f"{name}/{key}-{sha256[:8]}.parquet"
        out.write(path, content)
        files[name] = {"path": path, "size": len(content), "sha256": sha256, "rows": len(table)}
    known = {"files": files, "summary": summary.given()}
    return json.dumps(known, sort_keys=True).encode()


@dataclass(frozen=True)
class Job:
    """What a worker has to know: where a scan is, and how to run it."""

    store: str
    out: str
    plan: str
    options: Options = Options()

    def run(self, batch: str) -> str:
        """See `run_batch`."""
        return run_batch(self.store, self.out, self.plan, batch, self.options)

    def missing(self, among: slice = slice(None)) -> list[str]:
        """Keys of the batches, or of these of the plan, that are not done, in the plan's order."""
        out, _, _, batches = _opened(self.store, self.out, self.plan, self.options.storage)
        done = _done_in(out)
        return [batch for batch in [*batches][among] if batch not in done]


def _done_in(out: Location) -> set[str]:
    entries = out.list("done/")
    for entry in entries:
        if not entry.size:  # of a machine that failed
            out.delete(entry.path)
    names = (entry.path for entry in entries if entry.size)
    return {name.removeprefix("done/").removesuffix(".json") for name in names}


def end_on_request() -> None:
    """Have SIGTERM end this process by an exception, so that it gives its batch back."""
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))


Engine = Callable[[Job], Iterable[str]]
"""Runs missing batches of a job, `Job.run` for each, and gives keys of those that are done.

It may leave some: it is called again until none is missing.
"""


def drive(job: Job, engine: Engine) -> Iterator[str]:
    """Have an engine run all batches that are missing; keys of those that are done, as they are."""
    wait_s = job.options.poll_s
    while job.missing():
        n_done = 0
        for n_done, batch in enumerate(engine(job), 1):  # noqa: B007  # counted
            yield batch
        wait_s = job.options.poll_s if n_done else min(2 * wait_s, job.options.lease_s / 4)
        if not n_done:  # others are at work on all of these
            threading.Event().wait(wait_s)


def in_process(job: Job, part: int = 0, n_parts: int = 1) -> Iterator[str]:
    """The engine of one process: every n-th batch from `part` on, then what others have left."""
    own = job.missing(slice(part % n_parts, None, n_parts))
    yield from (batch for batch in own if job.run(batch) == "done")
    left = job.missing()
    start = len(left) * part // n_parts  # each at another place
    yield from (batch for batch in left[start:] + left[:start] if job.run(batch) == "done")


def finish(out: Location, its_plan: Plan) -> Summary:
    """Merge what the batches of a plan gave, and list their files in Delta tables.

    Any number of processes may do so. Tables with the results of a plan that was begun later, and
    is finished, stay.

    Raises
    ------
    InputError
        If batches are missing.
    """
    with ThreadPoolExecutor(16) as pool:
        paths = [f"done/{batch.key}.json" for batch in its_plan.batches]
        try:
            done = [json.loads(text) for text in pool.map(out.read, paths)]
        except FileNotFoundError as error:
            raise InputError("some batches of the scan are missing", file=out.uri) from error
    summary = Summary.merge([Summary.parse(batch["summary"]) for batch in done])
    newest = newest_plan(out)
    if newest is None or newest.key == its_plan.key or not is_finished(out, newest):
        versions = {
            name: _list_files(out.child(name), [batch["files"][name] for batch in done])
            for name in done[0]["files"]
        }
        known = {"plan": its_plan.key, "tables": versions, "left_out": its_plan.left_out}
        out.write("summary.parquet", _as_parquet(pa.table(dict(summary.measures()))))
        for path in (SUMMARY, f"finished/{its_plan.key}.json"):
            out.write(path, json.dumps(known, indent=1).encode())
    return summary


def _list_files(folder: Location, files: Sequence[Mapping[str, Any]]) -> int:
    """Version of a folder's Delta table that holds these files alone."""
    wanted = {file["path"].rpartition("/")[2]: file for file in files}
    with folder.open(next(iter(wanted))) as file:
        schema = pq.read_schema(file)
    storage: dict[str, Any] = {"storage_options": folder.delta_options}
    for attempt in range(COMMIT_ATTEMPTS):
        with folder.at("", "written"), suppress(CommitFailedError):  # another was faster
            try:
                table = DeltaTable(folder.uri, **storage)
            except TableNotFoundError:
                table = DeltaTable.create(folder.uri, schema, mode="ignore", **storage)
            there = {uri.rpartition("/")[2] for uri in table.file_uris()}
            if there == wanted.keys():
                return table.version()
            now = int(time.time() * 1000)
            actions: list[AddAction | RemoveAction] = [
                *(
                    AddAction(name, of["size"], {}, 0, True, json.dumps({"numRecords": of["rows"]}))
                    for name, of in wanted.items()
                    if name not in there
                ),
                *(RemoveAction(name, True, now) for name in sorted(there - wanted.keys())),
            ]
            table.create_write_transaction(actions, "append", schema)
            continue
        time.sleep(0.1 * attempt)
    raise StoreError("cannot be written (other processes are always faster)", file=folder.uri)


@dataclass(frozen=True)
class Status:
    """How far a scan is.

    Attributes
    ----------
    plan
        Of the scan.
    n_done, n_frames_done
        Batches that are done, and their frames.
    n_running
        Batches at which a worker may be.
    n_lost
        Attempts at them, or at batches that wait, that ended without a word.
    n_quarantined
        Recordings that could not be compared, of the batches that are done.
    is_finished
        Whether all is done and the tables were written.
    reason
        Why one of the recordings could not be compared, after its name.
    """

    plan: Plan
    n_done: int
    n_frames_done: int
    n_running: int
    n_lost: int
    n_quarantined: int
    is_finished: bool
    reason: str = ""

    def __str__(self) -> str:
        plan = self.plan
        lines = [
            f"{plan.params.x} and {plan.params.y} of {plan.store}: {self.n_done:,} of "
            f"{count_text(len(plan.batches), 'batch', 'batches')} done, {self.n_frames_done:,} of "
            f"{count_text(plan.n_frames, 'frame')}"
        ]
        if not self.is_finished:
            n = count_text(self.n_running, "batch", "batches")
            is_idle = "; run the scan again to go on" if not self.n_running else ""
            lines += [f"at work on {n}{is_idle}"]
        if self.n_lost:
            lines += [f"{count_text(self.n_lost, 'attempt')} ended without a word; others go on"]
        lines += [
            f"{count_text(n, 'recording')} without {source}, or with one of another version of the "
            "recording, left out"
            for source, n in plan.left_out.items()
        ]
        if self.n_quarantined:
            n = count_text(self.n_quarantined, "recording")
            lines += [f"{n} in quarantine (table quarantine), such as {self.reason}"]
        return "\n".join(map(one_line, lines))


def status(out: Location, its_plan: Plan | None = None, clock: Clock = time.time) -> Status:
    """How far a scan is, if none is given the one that was begun last.

    Raises
    ------
    InputError
        If there is none.
    """
    its_plan = its_plan or newest_plan(out)
    if its_plan is None:
        raise InputError("there is no scan", file=out.uri)
    is_done = _done_in(out)
    done = [batch for batch in its_plan.batches if batch.key in is_done]
    left = {batch.key for batch in its_plan.batches} - is_done
    leases = [entry.path for entry in out.list("leases/") if entry.path.split("/")[1] in left]
    with ThreadPoolExecutor(16) as pool:
        attempts = [*map(attempt_of, pool.map(out.read, leases))]
        of_done = map(json.loads, pool.map(out.read, [f"done/{batch.key}.json" for batch in done]))
        refused = [of for of in (batch["files"]["quarantine"] for batch in of_done) if of["rows"]]
    held = [is_held(attempt, clock()) for attempt in attempts]
    first = None
    if refused:
        with out.open(refused[0]["path"]) as file:
            first = pq.read_table(file).slice(0, 1).to_pylist()[0]
    return Status(
        its_plan,
        len(done),
        sum(batch.n_frames for batch in done),
        sum(held),
        sum(attempt["ended"] is None for attempt in attempts) - sum(held),
        sum(of["rows"] for of in refused),
        not left and is_finished(out, its_plan),
        f"{first['recording']}: {first['reason']}" if first else "",
    )


def forget_quarantined(out: Location, its_plan: Plan) -> None:
    """Have the batches run anew that have recordings in quarantine."""
    stages = out.list("stages/")
    for batch in its_plan.batches:
        done = f"done/{batch.key}.json"
        with suppress(FileNotFoundError):
            if json.loads(out.read(done))["files"]["quarantine"]["rows"]:
                own = [entry for entry in stages if batch.inputs in entry.path]
                for entry in (*own, *out.list(f"leases/{batch.key}/")):
                    out.delete(entry.path)
                out.delete(done)


def _as_parquet(table: pa.Table) -> bytes:
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, compression="zstd", use_dictionary=False)
    return bytes(sink.getvalue())
