"""Leases: which worker has the right to a batch, and how earlier attempts ended."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import socket
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Final

from nvcore.errors import StoreError
from nvcore.fleet.location import Location
from nvcore.wording import one_line

LEASE_S: Final = 120.0
"""How long a batch waits for a worker that gives no sign of life, until another one takes it. The
clocks of machines should differ by less."""
ATTEMPTS: Final = 2
"""Workers that a recording may kill before its batch waits for all others. After one more kill the
recording is left out."""


def seal(content: Mapping[str, Any]) -> bytes:
    """Write JSON with a checksum of the content."""
    sha256 = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    return json.dumps({"content": content, "sha256": sha256}).encode()


def unseal(text: bytes) -> dict[str, Any] | None:
    """Read JSON that `seal` wrote, or return None if it is damaged."""
    with suppress(ValueError, TypeError, KeyError):
        content: dict[str, Any] = json.loads(text)["content"]
        return content if seal(content) == text else None
    return None


class HeldError(Exception):
    """Another worker has the lease."""


class Lease:
    """The right to work on a batch, held and renewed by a thread from entry to exit.

    Entry raises HeldError if another worker has it.

    Attributes
    ----------
    killed_at
        The recording, or None for all of the batch, that each earlier attempt that ended without
        a word was comparing.
    is_late
        Whether no worker has the batch, and it has to wait for all others.
    """

    def __init__(self, out: Location, key: str, *, clock: Callable[[], float]):
        earlier = [attempt_of(out.read(entry.path)) for entry in out.list(f"leases/{key}/")]
        self._is_held = bool(earlier) and is_held(earlier[-1], clock())
        self.killed_at = [attempt["at"] for attempt in earlier if attempt["ended"] is None]
        most = max(map(self.killed_at.count, filter(None, self.killed_at)), default=0)
        self.is_late = most >= ATTEMPTS and not self._is_held
        self._out, self._path = out, f"leases/{key}/{len(earlier) + 1:04}.json"
        self._state = attempt_of(b"") | {"host": _host(), "pid": os.getpid()}
        self._state["token"] = secrets.token_hex(8)  # no two leases have the same content
        self._clock, self._lock, self._is_over = clock, threading.Lock(), threading.Event()

    def _content(self, **changes: str) -> bytes:
        """Return the content of its file, with a new time of expiry."""
        self._state |= {"expires": self._clock() + LEASE_S, **changes}
        return seal(self._state)

    def tell(self, **changes: str) -> None:
        """Renew it, and say at which recording the work is (`at`), or why the batch `failed`."""
        with self._lock:  # a write that is slow would else undo a later one
            self._out.write(self._path, self._content(**changes))

    def __enter__(self) -> Lease:
        if self._is_held or not self._out.create(self._path, self._content()):
            raise HeldError
        threading.Thread(target=self._renew, daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, _: object) -> None:
        self._is_over.set()
        with suppress(*[StoreError] if kind else []):  # it will expire
            self.tell(ended=one_line(f"{kind.__name__}: {error}") if kind else "done")

    def _renew(self) -> None:
        while not self._is_over.wait(LEASE_S / 4):
            with suppress(StoreError), self._lock:  # at worst, two workers do the same
                if not self._is_over.is_set():
                    self._out.write(self._path, self._content())


def attempt_of(content: bytes) -> dict[str, Any]:
    """Read the file of a lease, or take a damaged one for a lost attempt."""
    return unseal(content) or {"host": "", "pid": 0, "at": None, "ended": None, "expires": 0.0}


@cache
def _host() -> str:
    """Name of the machine since it was started, and of what numbers processes in it."""
    name = socket.gethostname()
    with suppress(OSError):  # Linux alone has them
        name += " " + Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        name += f" {Path('/proc/self/ns/pid').readlink()}"
    return name


def is_held(attempt: Mapping[str, Any], now: float) -> bool:
    """Whether the worker of a lease may be at work, which is known of processes on this host."""
    if attempt["ended"] is not None or attempt["expires"] <= now:
        return False
    try:
        if os.name == "posix" and attempt["host"] == _host():
            os.kill(attempt["pid"], 0)
    except OSError as error:
        return isinstance(error, PermissionError)  # it is another user's
    return True
