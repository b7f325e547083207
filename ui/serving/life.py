"""Startup and shutdown of the server."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from types import FrameType
from typing import Any

from ui.serving.answers import keep_deleting_ended
from ui.serving.connections import guard_connections
from ui.serving.preparing import start_preparing
from ui.session import ending, folders

_shutdown = threading.Event()


def is_shutting_down() -> bool:
    """Whether the server was told to stop and only finishes its pending answers."""
    return _shutdown.is_set()


def watch_for_shutdown() -> None:
    """Notice SIGINT and SIGTERM, and pass them on to the handlers installed before."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _noting_shutdown(signal.getsignal(number)))


def _noting_shutdown(handler: Any) -> Callable[[int, FrameType | None], Any]:
    def handle(number: int, frame: FrameType | None) -> Any:
        _shutdown.set()
        if callable(handler):
            return handler(number, frame)
        if handler != signal.SIG_IGN:  # the system's default action
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        return None

    return handle


@asynccontextmanager
async def lifespan(_app: Any) -> AsyncIterator[None]:
    """Start the server's background work; stop it and remove all uploads at shutdown."""
    ending.close_sessions_on(asyncio.get_running_loop())
    watch_for_shutdown()
    guard_connections()
    start_preparing()
    deleting = asyncio.create_task(keep_deleting_ended())
    try:
        yield
    finally:
        deleting.cancel()
        folders.remove_own()
