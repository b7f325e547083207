"""Processes with limits on memory and time, and calls into them."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Final, TypeVar, cast

from nvcore.common.errors import InputError, NvcoreError
from nvcore.common.progress import Progress
from ui.confined.transfer import Fault, Step, receive_answer

T = TypeVar("T")

MOST_CALLS: Final = 2
"""Maximum number of concurrent calls by `call`. Others wait. Background jobs do not count."""
N_THREADS: Final = max(1, (os.cpu_count() or 1) // 2)
"""Threads of a run over pictures. The other cores are for visitors."""
POLL_S: Final = 0.3
"""Interval at which a call asks whether it is cancelled, s."""
NEEDED: Final = frozenset((
    "PATH", "HOME", "XDG_CACHE_HOME", "TMPDIR", "TEMP", "TMP", "LANG", "LANGUAGE", "TZ",
    "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "COVERAGE_PROCESS_START",
))  # fmt: skip
NEEDED_STARTS: Final = ("LC_", "PYTHON", "NUMBA_", "OMP_", "OPENBLAS_", "MKL_", "OPENCV_")
"""Prefixes of environment variables that the processes inherit besides `NEEDED`."""

_turns = threading.BoundedSemaphore(MOST_CALLS)


@dataclass(frozen=True)
class Allowance:
    """Limits of a process.

    Attributes
    ----------
    memory_mb
        MiB beyond its size at the start.
    seconds
        Time limit of a call or, if it has progress, between two steps of its progress.
    """

    memory_mb: int
    seconds: float


MODELS: Final = Allowance(memory_mb=3000, seconds=60.0)
"""Limits for opening a model, and for its output on one picture."""


class Process:
    """Process that starts with the first call, and restarts with a call after it has ended.

    Any thread may call. Calls are answered one at a time.
    """

    def __init__(self, allowance: Allowance) -> None:
        self._allowance, self._lock = allowance, threading.Lock()
        self._ours: Connection | None = None
        self._number = 0

    def call(
        self,
        function: Callable[..., T],
        *arguments: Any,
        what: str,
        progress: Progress | None = None,
    ) -> T:
        """Call a function in the process. Any error other than `NvcoreError` ends the process.

        Parameters
        ----------
        function, arguments
            A module-level function, and arguments that can be pickled.
        what
            Subject of error messages: ``"reading the files"``.
        progress
            Receives the function's progress, and is polled in between. If it raises CancelledError,
            the process ends.

        Raises
        ------
        NvcoreError
            If the function raises it.
        InputError
            If the function exceeds its allowance, raises anything else, or ends without an answer,
            or if no process can be started.
        """
        with self._lock:
            connection = self._ours or self._start()
            try:
                connection.send((function, arguments, progress is not None))
                answer = self._receive(connection, progress)
            except (EOFError, OSError) as error:
                self._end()
                raise InputError(f"{what} took too much memory, or ended in a fault") from error
            except CancelledError:
                self._end()
                raise
            is_fine, value = (False, None) if answer is None else answer
            if is_fine:
                return cast(T, value)
            if isinstance(value, NvcoreError):
                raise value
            self._end()
        if isinstance(value, Fault):
            raise InputError(
                f"{what} ended in a fault of the program ({value.text}); the traceback is in the "
                "server's log"
            )
        if answer is not None:
            excess = f"took more than {self._allowance.memory_mb} MB of memory"
        else:
            excess = "took more than" if progress is None else "stood still for"
            excess = f"{excess} {self._allowance.seconds:g} s"
        raise InputError(f"{what} {excess}, and was stopped")

    def close(self) -> None:
        """End the process once no call is under way."""
        with self._lock:
            self._end()

    def _start(self) -> Connection:
        try:
            self._ours = _nursery.connect()
            self._number = self._ours.recv()
            self._ours.send(self._allowance.memory_mb)
        except (EOFError, OSError) as error:  # the nursery has just ended
            self._ours = None
            raise InputError("there is no room for another process; try again later") from error
        return self._ours

    def _end(self) -> None:
        if self._ours is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._number, signal.SIGKILL)
            self._ours.close()
            self._ours = None

    def _receive(
        self, connection: Connection, progress: Progress | None
    ) -> tuple[bool, Any] | None:
        """Return the answer, or None if it does not come in time."""
        if progress is None:
            is_ready = connection.poll(self._allowance.seconds)
            return receive_answer(connection) if is_ready else None
        step, since = Step(0.0, ""), time.monotonic()
        while time.monotonic() - since < self._allowance.seconds:
            progress(step.share, step.words)
            if not connection.poll(POLL_S):
                continue
            answer: Step | tuple[bool, Any] = receive_answer(connection)
            if not isinstance(answer, Step):
                return answer
            if answer.share != step.share:
                since = time.monotonic()
            step = answer
        return None


def call(
    function: Callable[..., T],
    *arguments: Any,
    allowance: Allowance,
    what: str,
    progress: Progress | None = None,
) -> T:
    """Call a function in a process of its own, as `Process.call`.

    A call with progress is a background job, and `ui.jobs.background` limits these.
    """
    turn = _turns if progress is None else contextlib.nullcontext()
    with turn, contextlib.closing(Process(allowance)) as process:
        return process.call(function, *arguments, what=what, progress=progress)


def warm_up() -> None:
    """Start the nursery, so that the first call need not wait for it."""
    call(os.getpid, allowance=Allowance(memory_mb=100, seconds=300), what="starting")


class _Nursery:
    """`ui.confined.nursery`, started on first use. It ends with this process."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._control: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None

    def connect(self) -> Connection:
        """Return our end of a connection to a new process."""
        ours, theirs = socket.socketpair()
        with theirs, self._lock:
            try:
                socket.send_fds(self._started(), [b"+"], [theirs.fileno()])
            except (BrokenPipeError, ConnectionResetError):  # it was killed
                self._control = None
                socket.send_fds(self._started(), [b"+"], [theirs.fileno()])
        return Connection(ours.detach())

    def _started(self) -> socket.socket:
        if self._control is None:
            self._control, theirs = socket.socketpair()
            with theirs:
                environment = {  # code that breaks out of a decoder finds no secret in it
                    name: value
                    for name, value in os.environ.items()
                    if name in NEEDED or name.startswith(NEEDED_STARTS)
                }
                environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
                environment["OPENBLAS_NUM_THREADS"] = "1"
                self._process = subprocess.Popen(  # noqa: S603  # our own module
                    [sys.executable, "-m", "ui.confined.nursery", str(theirs.fileno())],
                    pass_fds=[theirs.fileno()],
                    process_group=0,  # it kills its own group at once when the server ends
                    env=environment,
                )
        return self._control


_nursery = _Nursery()
