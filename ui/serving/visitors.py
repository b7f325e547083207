"""Refuses what is more than the server takes: visitors, and annotation files held in memory.

Streamlit keeps annotation files in memory until their form is opened, and limits each by itself
only (``server.maxUploadSize``). Pictures go through a route of ours, which has limits of its own.
"""

from __future__ import annotations

import asyncio
import logging
import os
import re
import secrets
import time
from collections import Counter
from http import HTTPStatus
from ipaddress import IPv6Address, ip_address
from typing import Final

from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from streamlit import runtime

from ui.answers import text_answer
from ui.serving.life import is_ending
from ui.settings.limits import MEBI, Limits

METRICS_TOKEN: Final = "NVCORE_METRICS_TOKEN"  # noqa: S105  # its name
"""Whoever sends it (``Authorization: Bearer``) may read the metrics; without it nobody may."""
IDLE_S: Final = 60.0
"""How long an upload may send nothing."""
SLOWEST: Final = 10_000
"""Bytes per second that an upload has to bring, beyond `IDLE_S`: while it lasts it takes room."""
LOOK_S: Final = 0.5
"""How often a waiting upload looks whether the server is about to end."""
TRY_AGAIN_LATER: Final = 1013
"""Close code of a WebSocket."""
STREAM: Final = "/_stcore/stream"
METRICS: Final = "/_stcore/metrics"
UPLOAD: Final = re.compile(r"/_stcore/upload_file/(?P<session>[^/]+)/[^/]+$")
OF_ADDRESS: Final = 64
"""Leading bits of an address of IPv6 that are one network's: who has one has all below it."""
_LOG = logging.getLogger("nvcore.ui")


class VisitorLimits:
    """Counts the open connections and the bytes on their way; refuses what is too much.

    The address of a visitor behind a proxy is the one that the proxy tells, where it is trusted:
    uvicorn trusts this machine and ``FORWARDED_ALLOW_IPS``.
    """

    def __init__(self, app: ASGIApp, limits: Limits):
        self.app, self.limits = app, limits
        self._n_visitors = 0
        self._of_address: Counter[str] = Counter()
        self._has_warned = False
        self._on_the_way: Counter[str] = Counter()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """ASGI."""
        path = str(scope.get("path", ""))
        if scope["type"] == "websocket" and path.endswith(STREAM):
            await self._visit(scope, receive, send)
            return
        if scope["type"] == "http":
            upload = UPLOAD.search(path)
            if upload is not None and scope["method"] == "PUT":
                await self._upload(upload["session"], scope, receive, send)
                return
            if scope["method"] == "PUT":
                receive = _impatient(receive)
            refusal = self._refusal(path, scope)
            if refusal is not None:
                await refusal(scope, receive, send)
                return
        await self.app(scope, receive, send)

    async def _visit(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self._full(scope):
            await receive()
            await send({"type": "websocket.close", "code": TRY_AGAIN_LATER})
            return
        address = _address(scope)
        self._n_visitors += 1
        self._of_address[address] += 1
        try:
            await self.app(scope, receive, send)
        finally:
            self._n_visitors -= 1
            self._of_address[address] -= 1
            if not self._of_address[address]:
                del self._of_address[address]

    def _full(self, scope: Scope) -> str:
        """Why there is no room for another tab, in words; empty: there is."""
        most, most_of_address = self.limits.max_visitors, self.limits.max_visitors_of_address
        if self._n_visitors >= most:
            return f"This server takes {most} visitors at a time. Try again later."
        address = _address(scope)
        if not address or self._of_address[address] < most_of_address:
            return ""
        if not self._has_warned:
            self._has_warned = True
            _LOG.warning(
                "One address has %d tabs open, all that it may (NVCORE_MAX_VISITORS_OF_ADDRESS). "
                "Where it is a proxy's, FORWARDED_ALLOW_IPS has to name it.",
                most_of_address,
            )
        return (
            f"This server takes {most_of_address} tabs of one address at a time. Close one, or try "
            "again later."
        )

    async def _upload(self, session: str, scope: Scope, receive: Receive, send: Send) -> None:
        stated = Headers(scope=scope).get("content-length", "")
        if not (stated.isascii() and stated.isdigit() and len(stated) < 19):
            await text_answer(HTTPStatus.LENGTH_REQUIRED, "state the length")(scope, receive, send)
            return
        n_bytes, limits = int(stated), self.limits
        of_session = _held_bytes(session) + self._on_the_way[session] + n_bytes
        of_all = _held_bytes() + self._on_the_way.total() + n_bytes
        if of_session > limits.max_upload_mb * MEBI or of_all > limits.max_uploads_mb * MEBI:
            text = (
                f"a visitor may send {limits.max_upload_mb} MB of annotation files at a time"
                if of_session > limits.max_upload_mb * MEBI
                else "the server holds as many annotation files as it may; try again later"
            )
            await text_answer(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, text)(scope, receive, send)
            return
        self._on_the_way[session] += n_bytes
        try:
            await self.app(scope, _impatient(receive), send)
        finally:
            self._on_the_way[session] -= n_bytes
            if not self._on_the_way[session]:
                del self._on_the_way[session]

    def _refusal(self, path: str, scope: Scope) -> Response | None:
        """Why this is not answered; None: it is."""
        if path.endswith(METRICS) and not _may_read_metrics(Headers(scope=scope)):
            return text_answer(HTTPStatus.NOT_FOUND, "not found")
        if "text/html" in Headers(scope=scope).get("accept", "") and (why := self._full(scope)):
            return text_answer(HTTPStatus.SERVICE_UNAVAILABLE, why)
        return None


def _address(scope: Scope) -> str:
    """The network address of a client, as far as it is one client's; empty: this machine's."""
    try:
        address = ip_address((scope.get("client") or [""])[0])
    except ValueError:  # a proxy that tells something else
        return ""
    if isinstance(address, IPv6Address):
        address = address.ipv4_mapped or address
    if address.is_loopback:
        return ""
    if isinstance(address, IPv6Address):
        return str(int(address) >> (address.max_prefixlen - OF_ADDRESS))
    return str(address)


async def _receive_until(receive: Receive, until: float) -> Message:
    """The next message; at that time (`time.monotonic`) or the server's end, that there is none."""
    message = asyncio.ensure_future(receive())
    while not is_ending() and (left_s := until - time.monotonic()) > 0:
        if (await asyncio.wait({message}, timeout=min(LOOK_S, left_s)))[0]:
            return message.result()
    message.cancel()
    return {"type": "http.disconnect"}


def _impatient(receive: Receive) -> Receive:
    """The same messages; who falls silent or only drips counts as gone, and all do at the end."""
    begin, n_bytes, is_whole = time.monotonic(), 0, False

    async def receive_in_time() -> Message:
        nonlocal n_bytes, is_whole
        if is_whole:
            return await receive()
        until = min(time.monotonic(), begin + n_bytes / SLOWEST) + IDLE_S
        message = await _receive_until(receive, until)
        n_bytes += len(message.get("body", b""))
        is_whole = not message.get("more_body", False)
        return message

    return receive_in_time


def _held_bytes(session: str | None = None) -> int:
    """Bytes of the annotation files that Streamlit holds, of one session or of all."""
    if not runtime.exists():
        return 0
    held = runtime.get_instance().uploaded_file_mgr.file_storage  # type: ignore[attr-defined]
    sessions = list(held.values()) if session is None else [held.get(session, {})]
    return sum(len(file.data) for files in sessions for file in list(files.values()))


def _may_read_metrics(headers: Headers) -> bool:
    token = os.environ.get(METRICS_TOKEN)
    given = headers.get("authorization", "").removeprefix("Bearer ")
    return bool(token) and secrets.compare_digest(given.encode(), str(token).encode())
