"""What the server does when it starts and when it ends."""

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
from ui.serving.preparing import begin_to_prepare
from ui.session import ending, folders

_end = threading.Event()


def is_ending() -> bool:
    """Whether the server was told to end: it waits for the answers that are on their way."""
    return _end.is_set()


def hear_of_the_end() -> None:
    """Know of the signals to end, which go on to whom they are for."""
    if threading.current_thread() is not threading.main_thread():
        return
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _heard(signal.getsignal(number)))


def _heard(handler: Any) -> Callable[[int, FrameType | None], Any]:
    def hear(number: int, frame: FrameType | None) -> Any:
        _end.set()
        if callable(handler):
            return handler(number, frame)
        if handler != signal.SIG_IGN:  # what the system does by itself
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        return None

    return hear


@asynccontextmanager
async def lifespan(_app: Any) -> AsyncIterator[None]:
    """Ends sessions on the server's own loop, and studies that are over.

    Uploads go with the server, however it is stopped.
    """
    ending.close_sessions_on(asyncio.get_running_loop())
    hear_of_the_end()
    guard_connections()
    begin_to_prepare()
    deleting = asyncio.create_task(keep_deleting_ended())
    try:
        yield
    finally:
        deleting.cancel()
        folders.remove_own()
