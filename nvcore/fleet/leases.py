"""Leases: which worker has the right to a batch, and how earlier attempts ended."""

from __future__ import annotations

import hashlib
import json
import os
import secrets
import socket
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from nvcore.errors import StoreError
from nvcore.fleet.location import Location
from nvcore.wording import one_line


def seal(content: Mapping[str, Any]) -> bytes:
    """Write JSON with a checksum of the content."""
    return json.dumps({"content": content, "sha256": _checksum(content)}).encode()


def unseal(text: bytes) -> dict[str, Any] | None:
    """Read JSON that `seal` wrote, or return None if it is damaged."""
    with suppress(ValueError, TypeError, KeyError):
        sealed = json.loads(text)
        content: dict[str, Any] = sealed["content"]
        return content if sealed["sha256"] == _checksum(content) else None
    return None


def _checksum(content: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


class Lease:
    """The right to work on a batch, renewed by a thread as long as the work goes on.

    Attributes
    ----------
    n_killed
        Earlier attempts that ended without a word.
    killed_at
        Recordings at which they were, where they compared them one at a time.
    """

    def __init__(
        self,
        out: Location,
        path: str,
        earlier: Sequence[Mapping[str, Any]],
        lease_s: float,
        clock: Callable[[], float],
    ):
        self._out, self._path, self._lease_s, self._clock = out, path, lease_s, clock
        lost = [attempt for attempt in earlier if attempt["ended"] is None]
        self.n_killed = len(lost)
        self.killed_at = [attempt["at"] for attempt in lost if attempt["at"] is not None]
        self._state: dict[str, Any] = {
            "host": _host(),
            "pid": os.getpid(),
            "token": secrets.token_hex(8),  # no two leases have the same content
            "at": None,
            "ended": None,
        }
        self._lock, self._is_over = threading.Lock(), threading.Event()

    @property
    def most_killed(self) -> int:
        """Largest number of attempts that one recording has ended."""
        return max(map(self.killed_at.count, self.killed_at), default=0)

    def content(self, **changes: Any) -> bytes:
        """Return the content of its file, with a new time of expiry."""
        self._state |= {"expires": self._clock() + self._lease_s, **changes}
        return seal(self._state)

    def tell(self, **changes: str) -> None:
        """Say at which recording the work is (`at`), or why the batch failed as a whole."""
        with self._lock:  # a write that is slow would else undo a later one
            self._out.write(self._path, self.content(**changes))

    def __enter__(self) -> Lease:
        threading.Thread(target=self._renew, daemon=True).start()
        return self

    def __exit__(self, kind: type[BaseException] | None, error: object, _: object) -> None:
        self._is_over.set()
        ended = "done" if kind is None else one_line(f"{kind.__name__}: {error}")
        try:
            self.tell(ended=ended)
        except StoreError:  # it will expire
            if kind is None:
                raise

    def _renew(self) -> None:
        while not self._is_over.wait(self._lease_s / 4):
            with suppress(StoreError), self._lock:  # at worst, two workers do the same
                if not self._is_over.is_set():
                    self._out.write(self._path, self.content())


def claim(out: Location, key: str, lease_s: float, clock: Callable[[], float]) -> Lease | None:
    """Claim a batch, or return None if another worker has it.

    Parameters
    ----------
    lease_s
        How long it holds if its owner gives no sign of life.
    clock
        Seconds since 1970.
    """
    earlier = [attempt_of(out.read(entry.path)) for entry in out.list(f"leases/{key}/")]
    if earlier and is_held(earlier[-1], clock()):
        return None
    path = f"leases/{key}/{len(earlier) + 1:04}.json"
    lease = Lease(out, path, earlier, lease_s, clock)
    return lease if out.create(path, lease.content()) else None


def attempt_of(content: bytes) -> dict[str, Any]:
    """Read the file of a lease, or take a damaged one for a lost attempt."""
    lost = {"host": "", "pid": 0, "at": None, "ended": None, "expires": 0.0}
    return unseal(content) or lost


@cache
def _host() -> str:
    """Name of the machine since it was started, and of what numbers processes in it."""
    names = [socket.gethostname()]
    with suppress(OSError):  # Linux alone has them
        names.append(Path("/proc/sys/kernel/random/boot_id").read_text().strip())
        names.append(str(Path("/proc/self/ns/pid").readlink()))
    return " ".join(names)


def is_held(attempt: Mapping[str, Any], now: float) -> bool:
    """Whether the worker of a lease may be at work, which is known of processes on this host."""
    if attempt["ended"] is not None or attempt["expires"] <= now:
        return False
    if os.name != "posix" or attempt["host"] != _host():
        return True
    try:
        os.kill(attempt["pid"], 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # another user's
        return True
    return True
