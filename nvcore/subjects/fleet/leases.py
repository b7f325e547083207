"""Leases: exclusive rights of workers to batches, with a record of earlier attempts."""

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

from nvcore.common.errors import StoreError
from nvcore.common.wording import one_line
from nvcore.subjects.fleet.location import Location

LEASE_S: Final = 120.0
"""Seconds until an unrenewed lease expires. Clocks of machines should differ by less."""
ATTEMPTS: Final = 2
"""Number of workers that a recording may kill before its batch waits for all others. After one
more, the recording goes into quarantine."""


def seal(content: Mapping[str, Any]) -> bytes:
    """Serialize content as JSON with its checksum."""
    sha256 = hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
    return json.dumps({"content": content, "sha256": sha256}).encode()


def unseal(text: bytes) -> dict[str, Any] | None:
    """Parse JSON that `seal` wrote, or return None if it is corrupt."""
    with suppress(ValueError, TypeError, KeyError):
        content: dict[str, Any] = json.loads(text)["content"]
        return content if seal(content) == text else None
    return None


class HeldError(Exception):
    """Another worker has the lease."""


class Lease:
    """Right to work on a batch: a context manager whose thread renews it until exit.

    Entry raises HeldError if another worker has the lease.

    Attributes
    ----------
    killed_at
        Recording that each lost attempt was comparing, or None if it compared the whole batch. An
        attempt is lost if its worker was killed.
    is_late
        True if the batch is free, but has killed so many workers that it waits for all others.
    """

    def __init__(self, out: Location, key: str, *, clock: Callable[[], float]):
        earlier = [attempt_of(out.read(entry.path)) for entry in out.list(f"leases/{key}/")]
        self._is_held = bool(earlier) and is_held(earlier[-1], clock())
        self.killed_at = [attempt["at"] for attempt in earlier if attempt["ended"] is None]
        most = max(map(self.killed_at.count, filter(None, self.killed_at)), default=0)
        self.is_late = most >= ATTEMPTS and not self._is_held
        self._out, self._path = out, f"leases/{key}/{len(earlier) + 1:04}.json"
        self._state = attempt_of(b"") | {"host": _host(), "pid": os.getpid()}
        self._state["token"] = secrets.token_hex(8)  # makes the content of each lease unique
        self._clock, self._lock, self._is_over = clock, threading.Lock(), threading.Event()

    def _content(self, **changes: str) -> bytes:
        """Return the content of the lease's file, with a new expiry time."""
        self._state |= {"expires": self._clock() + LEASE_S, **changes}
        return seal(self._state)

    def tell(self, **changes: str) -> None:
        """Renew the lease, and note the current recording (`at`) or why the batch `failed`."""
        with self._lock:  # otherwise a slow write could undo a later one
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
            with suppress(StoreError), self._lock:  # at worst, two workers do the same work
                if not self._is_over.is_set():
                    self._out.write(self._path, self._content())


def attempt_of(content: bytes) -> dict[str, Any]:
    """Parse the file of a lease. A corrupt file counts as a lost attempt."""
    return unseal(content) or {"host": "", "pid": 0, "at": None, "ended": None, "expires": 0.0}


@cache
def _host() -> str:
    """Identify the machine, its boot and its PID namespace, in which process ids are unique."""
    name = socket.gethostname()
    with suppress(OSError):  # only Linux has these files
        name += " " + Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        name += f" {Path('/proc/self/ns/pid').readlink()}"
    return name


def is_held(attempt: Mapping[str, Any], now: float) -> bool:
    """Return whether a lease's worker may be running, checking its process if on this host."""
    if attempt["ended"] is not None or attempt["expires"] <= now:
        return False
    try:
        if os.name == "posix" and attempt["host"] == _host():
            os.kill(attempt["pid"], 0)
    except OSError as error:
        return isinstance(error, PermissionError)  # the process belongs to another user
    return True
