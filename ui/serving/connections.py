"""Limits on connections: time to send the request headers, and open file descriptors."""

from __future__ import annotations

import contextlib
import resource
from asyncio import BaseTransport
from functools import cache
from typing import Any, Final

from uvicorn.protocols.http.auto import AutoHTTPProtocol

HEADERS_S: Final = 20.0
"""Time limit for sending the request headers. uvicorn itself waits forever."""
MAX_FILES: Final = 65536
"""Wanted limit of open files, more than the ports that a single client has."""


@cache
def guard_connections() -> None:
    """Time out slow request headers, and raise the process's limit of open files."""
    time_headers(AutoHTTPProtocol)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = MAX_FILES if hard == resource.RLIM_INFINITY else min(hard, MAX_FILES)
    if soft not in (resource.RLIM_INFINITY, wanted) and soft < wanted:
        with contextlib.suppress(OSError, ValueError):  # macOS may accept fewer than it reports
            resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def time_headers(protocol: type[Any], seconds: float = HEADERS_S) -> None:
    """Abort connections that take longer than `seconds` to send their request headers.

    This patches the class in place, because Streamlit builds uvicorn's configuration itself and
    does not accept a subclass.

    Parameters
    ----------
    protocol
        One of uvicorn's HTTP/1.1 protocols. It has its own limit between two requests, 5 s.
    """
    made, received, lost = (
        protocol.connection_made,
        protocol.data_received,
        protocol.connection_lost,
    )

    def watch(connection: Any) -> None:
        cycle, timer = connection.cycle, getattr(connection, "headers_timer", None)
        is_asked = cycle is not None and not cycle.response_complete
        is_other = connection.transport.get_protocol() is not connection  # upgraded to a WebSocket
        if timer is not None and (is_asked or is_other):
            timer.cancel()
            connection.headers_timer = None
        elif timer is None and not (is_asked or is_other):
            abort = connection.transport.abort
            connection.headers_timer = connection.loop.call_later(seconds, abort)

    def connection_made(self: Any, transport: BaseTransport) -> None:
        made(self, transport)
        watch(self)

    def data_received(self: Any, data: bytes) -> None:
        received(self, data)
        watch(self)

    def connection_lost(self: Any, exc: Exception | None) -> None:
        timer = getattr(self, "headers_timer", None)
        if timer is not None:
            timer.cancel()
        lost(self, exc)

    protocol.connection_made = connection_made
    protocol.data_received = data_received
    protocol.connection_lost = connection_lost
