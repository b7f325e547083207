"""Connections that ask nothing are closed; an address has its share of tabs. With real sockets."""

from __future__ import annotations

import asyncio
import resource
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
import uvicorn
from starlette.responses import PlainTextResponse
from starlette.types import Receive, Scope, Send
from uvicorn.protocols.http.auto import AutoHTTPProtocol

from ui.serving import connections
from ui.serving.connections import guard_connections, time_headers
from ui.serving.visitors import VisitorLimits
from ui.settings.limits import Limits

HEADERS_S = 0.3
PATIENCE_S = 30.0
REQUEST = b"GET / HTTP/1.1\r\nHost: a\r\n\r\n"
KEY = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"


async def app(scope: Scope, receive: Receive, send: Send) -> None:
    """Answers in more time than headers may take; keeps WebSockets open."""
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.accept"})
        while (await receive())["type"] != "websocket.disconnect":
            pass
    elif scope["type"] == "http":
        await asyncio.sleep(2 * HEADERS_S)
        await PlainTextResponse("fine")(scope, receive, send)


@pytest.fixture
def connect() -> Iterator[Callable[[], socket.socket]]:
    """Connects to a server that takes three tabs of an address."""
    protocol = type("Timed", (AutoHTTPProtocol,), {})
    time_headers(protocol, HEADERS_S)
    limited = VisitorLimits(app, Limits(max_visitors_of_address=3))
    config = uvicorn.Config(
        limited, http=protocol, ws="websockets-sansio", lifespan="off", log_level="critical"
    )
    server = uvicorn.Server(config)
    with ExitStack() as stack:
        listener = stack.enter_context(socket.socket())
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        thread = threading.Thread(target=server.run, args=([listener],))
        thread.start()

        def open_connection() -> socket.socket:
            opened = socket.create_connection(listener.getsockname(), PATIENCE_S)
            return stack.enter_context(opened)

        yield open_connection
        server.should_exit = server.force_exit = True
        thread.join(PATIENCE_S)
        assert not thread.is_alive()


def has_closed(connection: socket.socket) -> bool:
    """Whether the server closes the connection without a word, in time."""
    try:
        return connection.recv(100) == b""
    except ConnectionResetError:
        return True


def visit(connection: socket.socket, by: str) -> int:
    """Status of the handshake of a tab, from this address by a proxy's word."""
    connection.sendall(
        f"GET /_stcore/stream HTTP/1.1\r\nHost: a\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        f"X-Forwarded-For: {by}\r\n{KEY}\r\n".encode()
    )
    return int(connection.recv(12).split()[1])


@pytest.mark.parametrize("sent", [b"", b"G", b"GET / HTTP/1.1\r\nHost: a\r\nX-A: b"])
def test_a_connection_that_sends_no_whole_headers_is_closed(connect, sent: bytes):
    connection = connect()
    connection.sendall(sent)
    assert has_closed(connection)


def test_a_drop_now_and_then_does_not_keep_a_connection(connect):
    connection = connect()
    connection.settimeout(HEADERS_S / 10)
    connection.sendall(b"GET / HTTP/1.1\r\n")
    for _ in range(int(PATIENCE_S * 10 / HEADERS_S)):
        try:
            connection.sendall(b"X-A: b\r\n")
            if has_closed(connection):
                return
        except TimeoutError:
            continue
        except OSError:
            return
    pytest.fail("it is still open")


def test_a_second_request_has_the_same_time(connect):
    connection = connect()
    connection.sendall(REQUEST)
    answer = b""
    while not answer.endswith(b"fine"):
        answer += connection.recv(1000)
    connection.sendall(REQUEST[:-2])
    assert has_closed(connection)


def test_an_answer_may_take_longer_than_headers(connect):
    connection = connect()
    connection.sendall(REQUEST)
    assert connection.recv(15) == b"HTTP/1.1 200 OK"


def test_an_open_tab_may_be_silent(connect):
    tab, other = connect(), connect()
    assert visit(tab, "203.0.113.9") == 101
    assert has_closed(other)  # the time is over
    tab.sendall(b"\x89\x80\x00\x00\x00\x00")  # ping
    answer = b""
    while b"\x8a\x00" not in answer:
        answer += tab.recv(1000)


def test_an_address_has_so_many_tabs_and_leaves_the_others_to_others(connect):
    tabs = [connect() for _ in range(8)]
    assert [visit(tab, "203.0.113.9") for tab in tabs[:4]] == [101, 101, 101, 403]
    assert visit(tabs[4], "203.0.113.10") == 101
    page = connect()
    page.sendall(
        b"GET / HTTP/1.1\r\nHost: a\r\nAccept: text/html\r\nX-Forwarded-For: 203.0.113.9\r\n\r\n"
    )
    text = b""
    while not text.endswith(b"again later."):
        text += page.recv(1000)
    assert text.startswith(b"HTTP/1.1 503")
    assert b"3 tabs from one address" in text


def test_this_machine_has_all_tabs(connect):
    assert [visit(connect(), "127.0.0.1") for _ in range(4)] == [101] * 4


def test_who_has_a_network_of_ipv6_has_one_share(connect):
    addresses = [f"2001:db8::{number}" for number in range(1, 5)]
    statuses = [visit(connect(), address) for address in addresses]
    assert statuses == [101, 101, 101, 403]
    assert visit(connect(), "2001:db8:0:1::1") == 101


def test_a_server_opens_as_many_files_as_it_may(monkeypatch: pytest.MonkeyPatch):
    taken: list[Any] = []
    monkeypatch.setattr(connections, "time_headers", taken.append)
    monkeypatch.setattr(resource, "getrlimit", lambda _: (1024, 4096))
    monkeypatch.setattr(resource, "setrlimit", lambda _, limits: taken.append(limits))
    guard_connections.__wrapped__()
    assert taken == [AutoHTTPProtocol, (4096, 4096)]
