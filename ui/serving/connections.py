"""Connections of the server: how long one may take to ask, how many there can be."""

from __future__ import annotations

import contextlib
import resource
from asyncio import BaseTransport
from functools import cache
from typing import Any, Final

from uvicorn.protocols.http.auto import AutoHTTPProtocol

HEADERS_S: Final = 20.0
"""Until a connection has sent the headers of a request: uvicorn by itself waits for ever."""
MOST_FILES: Final = 65536
"""More connections than one client has ports for."""


@cache
def guard_connections() -> None:
    """Time the headers of all requests, and let the process have as many files as it may."""
    time_headers(AutoHTTPProtocol)
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = MOST_FILES if hard == resource.RLIM_INFINITY else min(hard, MOST_FILES)
    if soft not in (resource.RLIM_INFINITY, most) and soft < most:
        with contextlib.suppress(OSError, ValueError):  # macOS may take fewer than it says
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


def time_headers(protocol: type[Any], seconds: float = HEADERS_S) -> None:
    """Let connections end that wait for the headers of a request longer than that.

    Streamlit makes the configuration of uvicorn by itself, so that the class is changed, not one
    derived from it named.

    Parameters
    ----------
    protocol
        One of uvicorn's for HTTP/1.1. Between two requests it has a limit of its own, 5 s.
    """
    made, received, lost = (
        protocol.connection_made,
        protocol.data_received,
        protocol.connection_lost,
    )

    def watch(connection: Any) -> None:
        cycle, timer = connection.cycle, getattr(connection, "headers_timer", None)
        is_asked = cycle is not None and not cycle.response_complete
        is_other = connection.transport.get_protocol() is not connection  # a WebSocket by now
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
