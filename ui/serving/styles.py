"""Puts the app's styles into Streamlit's page, so that nothing is ever drawn unstyled.

Written by the app they would arrive after the first tiles, which would then jump.
"""

from __future__ import annotations

from typing import Final

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ui.session.state import ROOT
from ui.streamlit_inside.server import with_styles

SHEETS: Final = ("style", "measures")
CONDITIONS: Final = ("accept-encoding", "if-none-match", "if-modified-since")
"""Request headers that would bring the page compressed, or a 304 for Streamlit's unchanged file."""
VALIDATORS: Final = ("etag", "last-modified")


def styles() -> str:
    """The app's style sheets in a ``<style>`` element."""
    sheets = (ROOT / "ui" / "assets" / f"{name}.css" for name in SHEETS)
    return f"<style>\n{''.join(sheet.read_text(encoding='utf-8') for sheet in sheets)}</style>\n"


class OwnStyles:
    """Adds the styles to the end of every page."""

    def __init__(self, app: ASGIApp):
        self.app, self._styles = app, styles().encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """ASGI."""
        is_read = scope["type"] == "http" and scope["method"] == "GET"
        if not is_read or "text/html" not in Headers(scope=scope).get("accept", ""):
            await self.app(scope, receive, send)
            return
        asked = MutableHeaders(raw=list(scope["headers"]))
        for name in CONDITIONS:
            del asked[name]
        start: Message = {}
        body = bytearray()

        async def send_with_styles(message: Message) -> None:
            if message["type"] == "http.response.start":
                if (
                    not Headers(raw=message["headers"])
                    .get("content-type", "")
                    .startswith("text/html")
                ):
                    await send(message)
                else:
                    start.update(message)
            elif not start:
                await send(message)
            else:
                body.extend(message.get("body", b""))
                if not message.get("more_body"):
                    await self._send_page(start, bytes(body), send)

        await self.app({**scope, "headers": asked.raw}, receive, send_with_styles)

    async def _send_page(self, start: Message, page: bytes, send: Send) -> None:
        styled = with_styles(page, self._styles)
        headers = MutableHeaders(raw=list(start["headers"]))
        headers["content-length"] = str(len(styled))
        for name in VALIDATORS:
            del headers[name]
        await send({**start, "headers": headers.raw})
        await send({"type": "http.response.body", "body": styled})
