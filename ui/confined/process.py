"""Processes that may take so much memory and time, and calls into them."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, Final, TypeVar, cast

from nvcore.errors import InputError, NvcoreError
from ui.confined.transfer import Fault, receive_answer

T = TypeVar("T")

MOST_JOBS: Final = 2
"""Calls at a time, each in a process of its own; others wait."""
NEEDED: Final = frozenset((
    "PATH", "HOME", "XDG_CACHE_HOME", "TMPDIR", "TEMP", "TMP", "LANG", "LANGUAGE", "TZ",
    "LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "COVERAGE_PROCESS_START",
))  # fmt: skip
NEEDED_STARTS: Final = ("LC_", "PYTHON", "NUMBA_", "OMP_", "OPENBLAS_", "MKL_", "OPENCV_")
"""Variables that the processes are given, and starts of such."""

_jobs = threading.BoundedSemaphore(MOST_JOBS)


@dataclass(frozen=True)
class Allowance:
    """What a process may take.

    Attributes
    ----------
    memory_mb
        MiB beyond what it has when it starts.
    seconds
        For one call.
    """

    memory_mb: int
    seconds: float


MODELS: Final = Allowance(memory_mb=3000, seconds=60.0)
"""For opening a model, and for what it makes of one picture."""


class Process:
    """A process that answers calls, one after another; not for several threads at once."""

    def __init__(self, allowance: Allowance) -> None:
        """Start it.

        Raises
        ------
        InputError
            If there is no room for another process, or the server is about to end.
        """
        self._allowance = allowance
        try:
            self._ours = _nursery.connect()
            self._number: int = self._ours.recv()
            self._ours.send(allowance.memory_mb)
        except (EOFError, OSError) as error:  # what it is forked from has ended just now
            raise InputError("there is no room for another process; try again later") from error

    def call(self, function: Callable[..., T], *arguments: Any, what: str) -> T:
        """What a function returns there; after any error but its own the process has ended.

        Parameters
        ----------
        function, arguments
            Of some module, and such as can be sent to another process.
        what
            What is done, for errors: ``"reading the files"``.

        Raises
        ------
        NvcoreError
            What the function raises.
        InputError
            If it takes more than it may, raises anything else, or ends without an answer.
        """
        try:
            self._ours.send((function, arguments))
            is_ready = self._ours.poll(self._allowance.seconds)
            answer: tuple[bool, Any] = receive_answer(self._ours) if is_ready else (False, None)
        except (EOFError, OSError) as error:
            self.end()
            raise InputError(f"{what} took too much memory, or ended in a fault") from error
        is_fine, value = answer
        if is_fine:
            return cast(T, value)
        if isinstance(value, NvcoreError):
            raise value
        self.end()
        if isinstance(value, Fault):
            raise InputError(
                f"{what} ended in a fault of the program ({value.text}); the traceback is in the "
                "server's log"
            )
        budget = f"{self._allowance.seconds:g} s"
        if is_ready:
            budget = f"{self._allowance.memory_mb} MB of memory"
        raise InputError(f"{what} took more than {budget}, and was stopped")

    @property
    def has_ended(self) -> bool:
        """Whether calls are no longer answered."""
        return self._ours.closed

    def end(self) -> None:
        """Stop it at once."""
        if not self._ours.closed:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._number, signal.SIGKILL)
            self._ours.close()


class SteadyProcess:
    """A process that is started by the first call, and again by the next one if it has ended.

    Any thread may call; one call is answered after another.
    """

    def __init__(self, allowance: Allowance) -> None:
        self._allowance, self._lock = allowance, threading.Lock()
        self._process: Process | None = None

    def call(self, function: Callable[..., T], *arguments: Any, what: str) -> T:
        """What a function returns in the process; see `Process.call`."""
        with self._lock:
            if self._process is None or self._process.has_ended:
                self._process = Process(self._allowance)
            return self._process.call(function, *arguments, what=what)

    def close(self) -> None:
        """End the process; the next call starts another."""
        with self._lock:
            if self._process is not None:
                self._process.end()


def call(function: Callable[..., T], *arguments: Any, allowance: Allowance, what: str) -> T:
    """What a function returns in a process of its own; see `Process.call`."""
    with _jobs:
        process = Process(allowance)
        try:
            return process.call(function, *arguments, what=what)
        finally:
            process.end()


def warm_up() -> None:
    """Start what processes are forked from, so that the first call need not wait for it."""
    call(os.getpid, allowance=Allowance(memory_mb=100, seconds=300), what="starting")


class _Nursery:
    """`ui.confined.nursery`, started when it is first needed; it ends with this process."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._control: socket.socket | None = None
        self._process: subprocess.Popen[bytes] | None = None

    def connect(self) -> Connection:
        """Our end of a connection to a new process."""
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
            number = theirs.fileno()
            with theirs:
                self._process = subprocess.Popen(  # noqa: S603  # our own module
                    [sys.executable, "-m", "ui.confined.nursery", str(number)],
                    pass_fds=[number],
                    process_group=0,  # with its own processes it ends after the server, at once
                    env={
                        **_needed_environment(),
                        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
                        "OPENBLAS_NUM_THREADS": "1",
                    },
                )
        return self._control


def _needed_environment() -> dict[str, str]:
    """What decoders need of the environment: whoever breaks out of one finds no secret in it."""
    return {
        name: value
        for name, value in os.environ.items()
        if name in NEEDED or name.startswith(NEEDED_STARTS)
    }


_nursery = _Nursery()
