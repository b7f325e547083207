"""The engine of processes on this machine: one that dies costs its batch, and is replaced."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Final

from nvcore.errors import InputError, NvcoreError
from nvcore.fleet.scan import Job, drive, end_on_request, in_process
from nvcore.metrics.kernels import thread_count

STILLBORN: Final = 3
"""Workers in a row that may die before they begin to work."""


def in_pool(job: Job, n_workers: int) -> Iterator[str]:
    """Run all batches that are missing in so many processes; keys of batches as they are done.

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

    def start(part: int) -> None:
        ours, theirs = context.Pipe(duplex=False)
        process = context.Process(target=_work, args=(theirs, job, part, n_workers), daemon=True)
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
