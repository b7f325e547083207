"""Limits the number of visitors and the annotation files held in memory.

Streamlit keeps annotation files in memory until their form is opened, and limits only each single
file (``server.maxUploadSize``). Pictures have their own upload route, with its own limits.
"""

from __future__ import annotations

import asyncio
import logging
import os
import secrets
import time
from collections import Counter
from contextlib import suppress
from http import HTTPStatus
from ipaddress import IPv6Address, ip_address
from pathlib import Path
from typing import Final

from starlette.datastructures import Headers
from starlette.responses import Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ui.responses import text_answer
from ui.serving.life import is_shutting_down
from ui.session.lifetime import workspace_of_session
from ui.settings.limits import MEBI, Limits
from ui.streamlit_inside.server import METRICS, STREAM, UPLOAD
from ui.streamlit_inside.sessions import held_bytes, run_again

METRICS_TOKEN: Final = "NVCORE_METRICS_TOKEN"  # noqa: S105  # its name
"""Environment variable with the token for the metrics (``Authorization: Bearer``). If it is unset,
nobody may read them."""
IDLE_S: Final = 60.0
"""Longest pause of an upload."""
MIN_BYTES_PER_S: Final = 10_000
"""Lowest average rate of an upload after `IDLE_S`, because a pending upload reserves memory."""
POLL_S: Final = 0.5
"""Poll interval of a waiting upload for the server's shutdown."""
TRY_AGAIN_LATER: Final = 1013
"""Close code of a WebSocket."""
NETWORK_BITS: Final = 64
"""Leading bits of an IPv6 address that identify a client, which has all addresses with them."""
_LOG = logging.getLogger("nvcore.ui")


class VisitorLimits:
    """Middleware that limits open connections and the bytes being uploaded.

    Behind a trusted proxy, a visitor's address is the one that the proxy reports. uvicorn trusts
    this machine and ``FORWARDED_ALLOW_IPS``.
    """

    def __init__(self, app: ASGIApp, limits: Limits, system: Path = Path("/")):
        """Wrap `app` (see `Limits.uploads_bytes` for `system`)."""
        self.app, self.limits, self.system = app, limits, system
        self._n_visitors = 0
        self._of_address: Counter[str] = Counter()
        self._has_warned = False
        self._pending_bytes: Counter[str] = Counter()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI connection."""
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
                receive = _with_timeout(receive)
            refusal = self._refusal(path, scope)
            if refusal is not None:
                await refusal(scope, receive, send)
                return
        await self.app(scope, receive, send)

    async def _visit(self, scope: Scope, receive: Receive, send: Send) -> None:
        if self._why_full(scope):
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

    def _why_full(self, scope: Scope) -> str:
        """Return why no further tab is accepted, or "" if it is."""
        most, most_of_address = self.limits.max_visitors, self.limits.max_visitors_of_address
        if self._n_visitors >= most:
            return f"This server allows {most} visitors at a time. Try again later."
        address = _address(scope)
        if not address or self._of_address[address] < most_of_address:
            return ""
        if not self._has_warned:
            self._has_warned = True
            _LOG.warning(
                "One address has reached its limit of %d tabs (NVCORE_MAX_VISITORS_OF_ADDRESS). "
                "If it is a proxy, name it in FORWARDED_ALLOW_IPS.",
                most_of_address,
            )
        return (
            f"This server allows {most_of_address} tabs from one address at a time. Close one, or "
            "try again later."
        )

    async def _upload(self, session: str, scope: Scope, receive: Receive, send: Send) -> None:
        stated = Headers(scope=scope).get("content-length", "")
        if not (stated.isascii() and stated.isdigit() and len(stated) < 19):
            answer = text_answer(HTTPStatus.LENGTH_REQUIRED, "Content-Length is missing")
            await answer(scope, receive, send)
            return
        n_bytes = int(stated)
        if why := self._why_too_large(session, n_bytes):
            if (space := workspace_of_session(session)) is not None:
                space.refusal = why
                run_again(session)
            await text_answer(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, why)(scope, receive, send)
            return
        self._pending_bytes[session] += n_bytes
        try:
            await self.app(scope, _with_timeout(receive), send)
        finally:
            self._pending_bytes[session] -= n_bytes
            if not self._pending_bytes[session]:
                del self._pending_bytes[session]

    def _why_too_large(self, session: str, n_bytes: int) -> str:
        """Return why another `n_bytes` are not accepted, or "" if they are."""
        limits, held = self.limits, held_bytes()
        of_session = held_bytes(session) + self._pending_bytes[session] + n_bytes
        if of_session > limits.max_upload_mb * MEBI:
            return (
                f"A visitor may upload {limits.max_upload_mb} MB of annotation files at a time. "
                "Remove some."
            )
        room = limits.uploads_bytes(held, self.system) - held - self._pending_bytes.total()
        if n_bytes > room:
            return (
                f"The file has {n_bytes / MEBI:,.1f} MB, the server room for "
                f"{max(room, 0) / MEBI:,.1f} MB. Send less, or try again later."
            )
        return ""

    def _refusal(self, path: str, scope: Scope) -> Response | None:
        """Return the answer that refuses a request, or None to let the app answer."""
        if path.endswith(METRICS) and not _may_read_metrics(Headers(scope=scope)):
            return text_answer(HTTPStatus.NOT_FOUND, "not found")
        if "text/html" in Headers(scope=scope).get("accept", "") and (why := self._why_full(scope)):
            return text_answer(HTTPStatus.SERVICE_UNAVAILABLE, why)
        return None


def _address(scope: Scope) -> str:
    """Return the identifying part of a client's IP address ("": this machine, or unknown)."""
    try:
        address = ip_address((scope.get("client") or [""])[0])
    except ValueError:  # a proxy reports something else
        return ""
    if isinstance(address, IPv6Address):
        address = address.ipv4_mapped or address
    if address.is_loopback:
        return ""
    if isinstance(address, IPv6Address):
        return str(int(address) >> (address.max_prefixlen - NETWORK_BITS))
    return str(address)


def _with_timeout(receive: Receive) -> Receive:
    """Treat silent or slow senders as disconnected, and all senders at shutdown."""
    begin, n_bytes, is_whole = time.monotonic(), 0, False

    async def receive_in_time() -> Message:
        nonlocal n_bytes, is_whole
        if is_whole:
            return await receive()
        until = min(time.monotonic(), begin + n_bytes / MIN_BYTES_PER_S) + IDLE_S
        message: Message = {"type": "http.disconnect"}
        while not is_shutting_down() and (left_s := until - time.monotonic()) > 0:
            with suppress(TimeoutError):
                message = await asyncio.wait_for(receive(), min(POLL_S, left_s))
                break
        n_bytes += len(message.get("body", b""))
        is_whole = not message.get("more_body", False)
        return message

    return receive_in_time


def _may_read_metrics(headers: Headers) -> bool:
    token = os.environ.get(METRICS_TOKEN)
    given = headers.get("authorization", "").removeprefix("Bearer ")
    return bool(token) and secrets.compare_digest(given.encode(), str(token).encode())
