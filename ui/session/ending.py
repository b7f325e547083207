"""Ends a session and closes its workspace some time after its browser has disconnected.

Streamlit lets a session whose browser stays away end by itself, but only when the next visitor
comes: until then its uploads would stay, on disk and in memory.
"""

from __future__ import annotations

import asyncio
import logging
import threading
import time
import weakref
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final, Protocol

from streamlit import runtime
from streamlit.runtime.scriptrunner import get_script_run_ctx

from ui.settings.limits import limits_of_environment

GRACE_S: Final = 150.0
"""How long a browser may stay away.

With `INTERVAL_S` less than ``server.disconnectedSessionTTL``: a session that Streamlit has given
up can no longer be ended.
"""
INTERVAL_S: Final = 20.0


class Closable(Protocol):
    """A resource that is closed when its session ends."""

    def close(self) -> None:
        """Release the resource."""


@dataclass
class _Watched:
    """A resource of a session, and when the session's browser was last connected."""

    what: weakref.ref[Closable]
    is_alive: Callable[[], bool]
    session_id: str | None = None
    seen_s: float = field(default_factory=time.monotonic)


_LOG = logging.getLogger("nvcore.ui")
_watched: list[_Watched] = []
_lock = threading.Lock()
_threads: list[threading.Thread] = []
_loops: list[asyncio.AbstractEventLoop] = []
"""The loop on which Streamlit's sessions may be ended, if it is known."""


def close_sessions_on(loop: asyncio.AbstractEventLoop) -> None:
    """Use this event loop, Streamlit's own, to end sessions."""
    _loops[:] = [loop]


def end_with_session(what: Closable) -> None:
    """Close a resource when the browser of the running session has gone, if there is a session."""
    context = get_script_run_ctx(suppress_warning=True)
    if context is None or not runtime.exists():
        return
    session_id = context.session_id
    watch(
        what,
        lambda: runtime.exists() and runtime.get_instance().is_active_session(session_id),
        session_id=session_id,
    )
    with _lock:
        if not _threads or not _threads[-1].is_alive():
            _threads[:] = [threading.Thread(target=_run, name="session-end", daemon=True)]
            _threads[0].start()


def watch(what: Closable, is_alive: Callable[[], bool], *, session_id: str | None = None) -> None:
    """Close a resource and end its session once `is_alive` was false for `GRACE_S`; see `sweep`."""
    with _lock:
        _watched.append(_Watched(weakref.ref(what), is_alive, session_id))


def of_session(session_id: str) -> list[Closable]:
    """Resources of this session."""
    with _lock:
        things = [entry.what() for entry in _watched if entry.session_id == session_id]
    return [what for what in things if what is not None]


def is_in_use(what: Closable) -> bool:
    """Whether the browser of a session that uses this resource is connected."""
    with _lock:
        watched = list(_watched)
    return any(entry.what() is what and entry.is_alive() for entry in watched)


def sweep(now_s: float) -> None:
    """Close resources whose browser has been gone too long; `now_s` is from ``time.monotonic``.

    Of more than the server takes visitors, those that have been away longest end at once: who opens
    and closes tabs all the time should not fill the memory.
    """
    with _lock:
        watched = list(_watched)
    away = []
    for entry in watched:
        if entry.what() is not None and entry.is_alive():
            entry.seen_s = now_s
        else:
            away.append(entry)
    away.sort(key=lambda entry: entry.seen_s)
    n_too_many = len(away) - limits_of_environment().max_visitors
    for number, entry in enumerate(away):
        what = entry.what()
        if what is None or number < n_too_many or now_s - entry.seen_s > GRACE_S:
            with _lock:
                _watched.remove(entry)  # first: what cannot be closed is not tried again
                is_last = not any(other.what() is what for other in _watched)
            if is_last:  # another session may have taken it over
                _close(what)
            if not entry.is_alive():
                _end(entry.session_id)


def _close(what: Closable | None) -> None:
    try:
        if what is not None:
            what.close()
    except Exception as error:  # noqa: BLE001  # the others are closed all the same
        _LOG.warning("what a session left could not be removed: %s", error)


def _end(session_id: str | None) -> None:
    """Make Streamlit drop the session and its uploaded files."""
    if session_id is not None and runtime.exists() and _loops and not _loops[0].is_closed():
        _loops[0].call_soon_threadsafe(runtime.get_instance().close_session, session_id)


def _run() -> None:
    while True:
        time.sleep(INTERVAL_S)
        sweep(time.monotonic())
