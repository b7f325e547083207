"""Scans: the comparison of all recordings of a store, batch by batch, on whatever runs them.

A scan keeps its state in the folder of its results (`nvcore.fleet.folder`), so that any number of
processes on any number of machines can work on it, and any of them may die.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Final, NamedTuple

import pyarrow as pa
from obstore.exceptions import BaseError

from nvcore.errors import InputError, NvcoreError, StoreError
from nvcore.fleet.batch import scan_batch
from nvcore.fleet.folder import done_in, plan_in, write_batch
from nvcore.fleet.leases import Lease, claim, seal
from nvcore.fleet.location import LONGEST_REASON, Location
from nvcore.fleet.plan import Batch, Plan
from nvcore.fleet.results import ScanParams, gather
from nvcore.fleet.store import Snapshot
from nvcore.metrics.kernels import thread_count
from nvcore.wording import one_line, shortened

WHOLE_ATTEMPTS: Final = 2
"""Attempts at a whole batch; afterwards its recordings are compared one at a time."""
ATTEMPTS: Final = 2
"""Workers that a recording may end before its batch has to wait for all others. After one more it
is left out."""
STILLBORN: Final = 3
"""Workers in a row that may die before they begin to work."""
_M_ARENA_MAX: Final = -8
"""Of mallopt(3)."""

Read = Callable[[Sequence[str]], dict[str, pa.Table]]
"""Reads recordings of a store."""


@dataclass(frozen=True)
class Options:
    """Options for running a scan, on which no result depends.

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
        Returns seconds since 1970, for leases.
    run
        Compares the tables of whole recordings: `scan_batch`.
    is_checked
        Whether the process that started this one has checked the programs.
    """

    storage: tuple[tuple[str, str], ...] = ()
    lease_s: float = 120.0
    poll_s: float = 0.2
    patience_s: float = 300.0
    clock: Callable[[], float] = time.time
    run: Callable[[dict[str, pa.Table], ScanParams], dict[str, pa.Table]] = scan_batch
    is_checked: bool = False


@dataclass(frozen=True)
class Job:
    """A scan that a worker can take part in: where it is, and how to run it."""

    store: str
    out: str
    plan: str
    options: Options = Options()

    def run(self, batch: str) -> str:
        """Compare the recordings of a batch and write the results, unless done before.

        All engines call this method.

        Parameters
        ----------
        batch
            `Batch.key`.

        Returns
        -------
        str
            ``done``, or ``busy`` if another worker is at it, or others have to be done first.

        Raises
        ------
        InputError
            If the programs are others than the plan's.
        StoreError
            If storage cannot be written or read, as where a disk is full; what is done stays.
        """
        out, options = self._opened.out, self.options
        if out.find(f"done/{batch}.json"):
            return "done"
        late = {entry.path[len("late/") : -len(".json")] for entry in out.list("late/")}
        if batch not in late:
            return self._run(batch, is_last=False)
        if {*self.missing()} - late:
            return "busy"
        alone = claim(out, "last", options.lease_s, options.clock)
        if alone is None:
            return "busy"
        with alone:
            return self._run(batch, is_last=True)

    def _run(self, batch: str, *, is_last: bool) -> str:
        opened, options = self._opened, self.options
        out, done = opened.out, f"done/{batch}.json"
        lease = claim(out, batch, options.lease_s, options.clock)
        if lease is None:
            return "busy"
        with lease:
            if out.find(done):  # its last worker may just have ended
                return "done"
            if lease.most_killed >= ATTEMPTS and not is_last:
                out.write(f"late/{batch}.json", seal({}))
                return "busy"
            params = opened.plan.params
            results = _compared(opened.batches[batch], opened.read, params, lease, options)
            out.create(done, write_batch(out, batch, results))
            del results
            _give_back_memory()
        return "done"

    def missing(self, among: slice = slice(None)) -> list[str]:
        """List the keys of batches, or of these of the plan, that are not done, in its order."""
        done = done_in(self._opened.out)
        return [batch for batch in [*self._opened.batches][among] if batch not in done]

    @property
    def _opened(self) -> _Opened:
        options = self.options
        return _open(self.store, self.out, self.plan, options.storage, options.is_checked)


class _Opened(NamedTuple):
    out: Location
    read: Read
    plan: Plan
    batches: dict[str, Batch]


@lru_cache(maxsize=2)
def _open(
    store: str, out_uri: str, plan_key: str, storage: tuple[tuple[str, str], ...], is_checked: bool
) -> _Opened:
    """Open store and results, once a process."""
    _use_one_heap()
    out = Location(out_uri, dict(storage))
    found = plan_in(out, plan_key)
    if found is None:
        raise StoreError("cannot be read (the plan of the scan is not there)", file=out.uri)
    if not is_checked:
        found.check_programs("all workers need the same: install these")
    snapshot = Snapshot(Location(store, dict(storage)), found.versions)
    read = partial(snapshot.read, sources=found.params.sources)
    return _Opened(out, read, found, {batch.key: batch for batch in found.batches})


def _compared(
    batch: Batch, read: Read, params: ScanParams, lease: Lease, options: Options
) -> dict[str, pa.Table]:
    """Compare the recordings of a batch, one at a time if they fail together."""
    if lease.n_killed < WHOLE_ATTEMPTS:
        try:
            tables = read(batch.recordings)
            tables["boxes"]  # read now: a damaged file is no fault of all of these recordings
            pa.default_memory_pool().release_unused()  # the pieces they were put together from
            return options.run(tables, params)
        except Exception as error:  # noqa: BLE001  # whatever it is: which recording is it about?
            _give_up_without_storage(error)
            lease.tell(failed=_reason(error))
    parts, reasons, faults = [], {}, 0
    for name in batch.recordings:
        n_killed = lease.killed_at.count(name)
        if n_killed > ATTEMPTS:
            reasons[name] = f"{n_killed} workers ended without a word while they compared it"
            continue
        lease.tell(at=name)
        try:
            parts.append(options.run(read([name]), params))
        except Exception as error:
            _give_up_without_storage(error)
            faults += not isinstance(error, NvcoreError)
            if faults == len(batch.recordings) > 1:  # then it is no fault of theirs
                raise
            reasons[name] = _reason(error)
    for part in parts:
        reasons |= dict(zip(*part["quarantine"].to_pydict().values(), strict=True))
    return gather(parts, reasons, has_frames=params.frames)


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
    """Describe an error in one line."""
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


def end_on_request() -> None:
    """Have SIGTERM end this process by an exception, so that it gives its batch back."""
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))


Engine = Callable[[Job], Iterable[str]]
"""Runs missing batches of a job, `Job.run` for each, and gives keys of those that are done.

It may leave some: it is called again until none is missing.
"""


def drive(job: Job, engine: Engine) -> Iterator[str]:
    """Have an engine run all missing batches, and yield keys as batches are done."""
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


def in_pool(job: Job, n_workers: int) -> Iterator[str]:
    """Run all missing batches in so many processes, and yield keys as batches are done.

    Raises
    ------
    InputError
        What a worker gave up with, or if workers die before they begin. The others are ended then;
        finished batches stay.
    """
    context = multiprocessing.get_context("spawn")
    workers: dict[Connection, tuple[BaseProcess, int]] = {}
    begun: set[Connection] = set()
    missing = set(job.missing())
    of_worker = replace(job, options=replace(job.options, is_checked=True))

    def start(part: int) -> None:
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(
            target=_work, args=(theirs, of_worker, part, n_workers), daemon=True
        )
        with _without_main(), _threads(max(thread_count() // n_workers, 1)):
            process.start()
        theirs.close()  # so that ours ends with the process
        workers[ours] = (process, part)

    n_stillborn = 0
    n_workers = min(n_workers, len(missing))
    for part in range(n_workers):
        start(part)
    try:
        while workers:
            for messages in wait(list(workers)):
                assert isinstance(messages, Connection)
                process, part = workers[messages]
                try:
                    message = messages.recv()
                except EOFError:  # it has ended, or was killed: then another takes its place
                    del workers[messages]
                    process.join()
                    if process.exitcode != 0:
                        n_stillborn += messages not in begun
                        start(part)
                    if n_stillborn == STILLBORN:
                        raise InputError(
                            f"workers die before they begin (exit code {process.exitcode}); is "
                            "there memory for so many workers?"
                        ) from None
                    continue
                begun.add(messages)
                n_stillborn = 0
                if isinstance(message, Exception):
                    raise message
                if message:
                    yield message
                    missing.discard(message)
                    if not missing:  # the others wait in vain
                        return
    finally:
        for process, _ in workers.values():
            process.terminate()
        for process, _ in workers.values():
            process.join()


@contextmanager
def _threads(n: int) -> Iterator[None]:
    """Within it, a process that starts uses so many threads, also within libraries."""
    before = os.environ.get("OMP_NUM_THREADS")
    os.environ["OMP_NUM_THREADS"] = str(n)
    try:
        yield
    finally:
        del os.environ["OMP_NUM_THREADS"]
        if before is not None:
            os.environ["OMP_NUM_THREADS"] = before


@contextmanager
def _without_main() -> Iterator[None]:
    """Within it, a process that starts does not run the user's script: workers need none of it.

    Nor does it end by Ctrl+C, which its parent has, too, and ends it.
    """
    script = vars(sys.modules["__main__"])
    names = ("__file__", "__spec__")
    hidden: dict[str, Any] = {name: script[name] for name in names if name in script}
    script.pop("__file__", None)
    script["__spec__"] = None
    is_main = threading.current_thread() is threading.main_thread()
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN) if is_main else None
    try:
        yield
    finally:
        script.update(hidden)
        if handler is not None:
            signal.signal(signal.SIGINT, handler)


def _work(messages: Connection, job: Job, part: int, n_parts: int) -> None:
    """Life of a worker, which ends with its parent's."""
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end() -> None:
        parent.join()
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=end, daemon=True).start()
    end_on_request()
    try:
        messages.send("")
        for batch in drive(job, partial(in_process, part=part, n_parts=n_parts)):
            messages.send(batch)
    except KeyboardInterrupt:  # the parent has it, too, and says so
        pass
    except NvcoreError as error:  # the parent raises it
        messages.send(error)
    except Exception as error:  # noqa: BLE001  # which need not pickle
        messages.send(RuntimeError("".join(traceback.format_exception(error))))
    finally:  # to be ended at the end is no error
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
