"""Asks an ASGI app for an answer without a server; bodies come in chunks, or break off."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from starlette.applications import Starlette
from starlette.types import ASGIApp

from ui.session.routes import routes_below


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def text(self) -> str:
        return self.body.decode()


def ask(address: str, **request: Any) -> Answer:
    """What `asked` returns, where nothing else is going on."""
    return asyncio.run(asked(address, **request))


async def asked(
    address: str,
    *,
    method: str = "GET",
    headers: dict[str, str] | None = None,
    chunks: Iterable[bytes] = (b"",),
    breaks_off: bool = False,
    app: ASGIApp | None = None,
) -> Answer:
    """What an app answers, by itself the routes; `breaks_off`: the client goes after the chunks."""
    parts = urlsplit(address)
    sent = {"host": "testserver", **(headers or {})}
    scope = {
        "type": "http", "asgi": {"version": "3.0", "spec_version": "2.4"}, "http_version": "1.1",
        "method": method, "scheme": "http", "root_path": "",
        "path": parts.path, "raw_path": parts.path.encode(),
        "query_string": parts.query.encode(errors="surrogateescape"),
        "server": ("testserver", 80), "client": None,
        "headers": [(name.lower().encode(), value.encode()) for name, value in sent.items()],
    }  # fmt: skip
    bodies = list(chunks)
    messages: list[dict[str, Any]] = [
        {"type": "http.request", "body": body, "more_body": breaks_off or i < len(bodies) - 1}
        for i, body in enumerate(bodies)
    ]
    messages.append({"type": "http.disconnect"})
    answered: list[dict[str, Any]] = []

    async def receive() -> dict[str, Any]:
        return messages.pop(0)

    async def send(message: Any) -> None:
        answered.append(message)

    await (app or Starlette(routes=routes_below("")))(scope, receive, send)
    start, *rest = answered
    return Answer(
        start["status"],
        {name.decode(): value.decode() for name, value in start["headers"]},
        b"".join(message.get("body", b"") for message in rest),
    )


def put(address: str, content: bytes, **headers: str) -> Answer:
    stated = {"content-length": str(len(content)), **headers}
    return ask(address, method="PUT", headers=stated, chunks=[content])
