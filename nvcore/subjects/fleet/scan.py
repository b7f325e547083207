"""Scans: compare all recordings of a store, batch by batch, on any engine.

A scan keeps its state in the folder of its results (`nvcore.subjects.fleet.folder`). Any number of
processes on any number of machines can work on it, and any of them may die.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from queue import SimpleQueue
from subprocess import PIPE, Popen
from typing import Any, Final

import pyarrow as pa
from obstore.exceptions import BaseError

from nvcore.common.errors import InputError, NvcoreError, StoreError
from nvcore.common.wording import one_line, shortened
from nvcore.metrics.kernels import thread_count
from nvcore.subjects.fleet.batch import scan_batch
from nvcore.subjects.fleet.folder import done_in, plan_in, write_batch
from nvcore.subjects.fleet.leases import ATTEMPTS, LEASE_S, HeldError, Lease
from nvcore.subjects.fleet.location import LONGEST_REASON, Location
from nvcore.subjects.fleet.plan import Plan
from nvcore.subjects.fleet.results import gather
from nvcore.subjects.fleet.store import Snapshot

WHOLE_ATTEMPTS: Final = 2
"""Attempts at a whole batch. Afterwards its recordings are compared one at a time."""


@dataclass(frozen=True)
class Options:
    """Options for running a scan, which do not affect its results.

    Attributes
    ----------
    storage
        Keys and values for the storage of the store and of the results, as in object_store.
    clock
        Function that returns seconds since 1970, for leases.
    run
        Function that compares the tables of whole recordings.
    is_checked
        True if the parent process has checked the programs.
    """

    storage: tuple[tuple[str, str], ...] = ()
    clock: Callable[[], float] = time.time
    run: Callable[..., dict[str, pa.Table]] = scan_batch
    is_checked: bool = False


@dataclass(frozen=True)
class Job:
    """Scan that workers can take part in: locations of store and results, plan and options."""

    store: str
    out: str
    plan: str
    options: Options = Options()

    def run(self, batch: str) -> str:
        """Compare the recordings of a batch (by its key) and write the results, unless done before.

        Returns
        -------
        str
            ``done``, or ``busy`` if another worker has the batch or it has to wait for others.

        Raises
        ------
        InputError
            If the programs differ from those of the plan.
        StoreError
            If storage fails, such as a full disk. Finished batches stay.
        """
        out, *_ = _open(self)
        lease_of = partial(Lease, out, clock=self.options.clock)
        done, lease = f"done/{batch}.json", lease_of(batch)
        if out.find(done):
            return "done"
        if lease.is_late and not all(lease_of(other).is_late for other in self.missing()):
            return "busy"
        with suppress(HeldError), lease_of("last") if lease.is_late else nullcontext(), lease:
            results = _compared(self, batch, lease)
            out.create(done, write_batch(out, batch, results))
            del results
            pa.default_memory_pool().release_unused()  # it keeps the peak usage
            _glibc("malloc_trim", 0)
            return "done"
        return "busy"

    def missing(self, among: slice = slice(None)) -> list[str]:
        """List the keys of unfinished batches of the plan, or of a slice of its batches."""
        out, plan, _ = _open(self)
        done = done_in(out)
        return [batch.key for batch in plan.batches[among] if batch.key not in done]


@lru_cache(maxsize=2)
def _open(job: Job) -> tuple[Location, Plan, Snapshot]:
    """Return results, plan and store of a job, opened once per process."""
    _glibc("mallopt", -8, 1)  # M_ARENA_MAX: a heap per thread would hold on to freed memory
    out = Location(job.out, dict(job.options.storage))
    plan = plan_in(out, job.plan)
    if plan is None:
        raise StoreError("cannot be read (the plan of the scan is not there)", file=out.uri)
    if not job.options.is_checked:
        plan.check_programs("all workers need the same: install these")
    return out, plan, Snapshot(Location(job.store, out.options), plan.versions)


def _compared(job: Job, batch: str, lease: Lease) -> dict[str, pa.Table]:
    """Compare the recordings of a batch, one at a time if they fail together."""
    _, plan, store = _open(job)
    params, run = plan.params, job.options.run
    [recordings] = [of.recordings for of in plan.batches if of.key == batch]
    if len(lease.killed_at) < WHOLE_ATTEMPTS:
        try:
            tables = store.read(recordings, params.sources)
            pa.default_memory_pool().release_unused()  # the pieces of joined tables
            return run(tables, params)
        except Exception as error:  # noqa: BLE001  # find out which recording causes it
            lease.tell(failed=_reason(error))
    parts, reasons, faults = [], {}, 0
    for name in recordings:
        n_killed = lease.killed_at.count(name)
        try:
            if n_killed > ATTEMPTS:
                raise InputError(f"{n_killed} workers ended without a word while they compared it")
            lease.tell(at=name)
            parts.append(run(store.read([name], params.sources), params))
        except Exception as error:
            reasons[name] = _reason(error)
            faults += not isinstance(error, NvcoreError)
            if faults == len(recordings) > 1:  # no single recording is to blame
                raise
    for part in parts:
        reasons |= dict(zip(*part["quarantine"].to_pydict().values(), strict=True))
    return gather(parts, reasons, has_frames=params.frames)


def _glibc(name: str, *values: int) -> None:
    """Call a function of glibc, or do nothing with another C library."""
    with suppress(AttributeError, OSError, TypeError):
        getattr(ctypes.CDLL(None), name)(*values)


def _reason(error: Exception) -> str:
    """Describe in one line why a recording fails, or raise the error if storage caused it."""
    is_of_system = isinstance(error, OSError) and error.errno is not None  # the file is not corrupt
    is_of_storage = is_of_system and not isinstance(error, FileNotFoundError)
    if is_of_storage or isinstance(error, StoreError | BaseError):
        raise error
    kind = "" if isinstance(error, NvcoreError) else f"{type(error).__name__}: "
    return shortened(one_line(f"{kind}{error}"), LONGEST_REASON)


def end_on_request() -> None:
    """Turn SIGTERM into SystemExit, so that the process releases its batch."""
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))


Engine = Callable[[Job], Iterable[str]]
"""Runs missing batches by `Job.run`, and yields the keys of finished batches. It may skip some, and
is called again until none is missing."""


def drive(job: Job, engine: Engine) -> Iterator[str]:
    """Run all missing batches on an engine, and yield the key of each finished batch."""
    wait_s = 0.0
    while job.missing():
        time.sleep(wait_s)
        wait_s = min(2 * wait_s, LEASE_S / 4) or 0.2
        for batch in engine(job):
            wait_s = 0.0  # grows while other scans hold all missing batches
            yield batch


def in_process(job: Job, part: int = 0, n_parts: int = 1) -> Iterator[str]:
    """Run all missing batches, those of this part first, and yield the keys of finished ones.

    This part is every `n_parts`-th batch of the plan from `part` on.
    """
    yield from (key for key in job.missing(slice(part, None, n_parts)) if job.run(key) == "done")
    left = job.missing()
    start = len(left) * part // n_parts  # each part begins at another batch
    yield from (key for key in left[start:] + left[:start] if job.run(key) == "done")


def in_pool(job: Job, n_workers: int) -> Iterator[str]:
    """Run all missing batches in `n_workers` processes, and yield keys as batches are done.

    A worker that is killed is replaced. The workers end when the generator is closed.

    Raises
    ------
    NvcoreError
        If a worker raises it, or workers die before they begin. Finished batches stay.
    RuntimeError
        If a worker raises another exception. The text is its traceback.
    """
    missing = {*job.missing()}
    n_workers = min(n_workers, len(missing))
    job = replace(job, options=replace(job.options, is_checked=True))
    messages: SimpleQueue[tuple[Popen[str], str]] = SimpleQueue()
    workers: dict[Popen[str], int] = {}
    begun, n_stillborn = set[Popen[str]](), 0

    def start(part: int) -> None:
        content = pickle.dumps((job, part, n_workers))
        n_threads = str(max(thread_count() // n_workers, 1))
        path = os.pathsep.join(map(str, sys.path))
        worker = Popen(
            [sys.executable, "-P", "-c", "from nvcore.subjects.fleet.scan import work; work()"],
            env=os.environ | {"OMP_NUM_THREADS": n_threads, "PYTHONPATH": path},
            process_group=0,  # Ctrl+C is for this process alone, which ends its workers
            stdin=PIPE,
            stdout=PIPE,
            encoding="ascii",
        )
        workers[worker] = part
        threading.Thread(target=listen, args=(worker, content), daemon=True).start()

    def listen(worker: Any, content: bytes) -> None:
        """Send a worker its job, queue its messages, and queue an empty one when it ends."""
        with worker:
            with suppress(BrokenPipeError):  # the worker has died
                os.write(worker.stdin.fileno(), content)
            for line in worker.stdout:
                messages.put((worker, line))
        messages.put((worker, ""))

    try:
        for part in range(n_workers):
            start(part)
        while workers and missing:
            worker, line = messages.get()
            if line:
                begun.add(worker)
                n_stillborn = 0
                message = pickle.loads(bytes.fromhex(line))  # noqa: S301  # from our own process
                if isinstance(message, Exception):
                    raise message
                if message in missing:
                    missing.remove(message)
                    yield message
                continue
            part = workers.pop(worker)
            n_stillborn += worker not in begun
            if n_stillborn == 3:  # in a row
                raise InputError(
                    f"workers die before they begin (exit code {worker.returncode}); is there "
                    "memory for so many workers?"
                )
            if worker.returncode != 0:  # it was killed: another worker replaces it
                start(part)
    finally:
        for worker in workers:
            worker.terminate()
        for worker in workers:
            worker.wait()


def work() -> None:
    """Run as a worker of `in_pool` until no batch is missing, or the parent ends."""
    out = os.dup(1)  # closed when the process ends, not before
    os.dup2(2, 1)  # printed text must not mix with the messages
    try:
        job, part, n_parts = pickle.load(sys.stdin.buffer)  # noqa: S301  # from our own process
    except EOFError:  # the parent died before it sent the job
        return

    def tell(message: str | Exception) -> None:
        with suppress(BrokenPipeError):  # the parent has died: `end` follows
            os.write(out, pickle.dumps(message).hex().encode() + b"\n")

    def end() -> None:
        os.read(0, 1)
        os.kill(os.getpid(), signal.SIGTERM)

    end_on_request()
    threading.Thread(target=end, daemon=True).start()
    try:
        tell("")
        for batch in drive(job, partial(in_process, part=part, n_parts=n_parts)):
            tell(batch)
    except NvcoreError as error:
        tell(error)
    except Exception:  # noqa: BLE001  # which need not pickle
        tell(RuntimeError(traceback.format_exc()))
    finally:  # the parent may terminate it while it exits
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
