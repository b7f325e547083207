"""Streamlit's page with the app's styles, so that nothing is ever drawn unstyled.

Styles drawn by the app itself would arrive after the first tiles, which would then jump.
"""

from __future__ import annotations

from collections.abc import Collection
from http import HTTPStatus
from typing import Final

from starlette.datastructures import Headers
from starlette.responses import HTMLResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ui.session.state import ROOT
from ui.settings.start import base_path
from ui.streamlit_inside.server import FILES, page_with

SHEETS: Final = ("style", "measures")
CONDITIONS: Final = (b"if-none-match", b"if-modified-since")
"""Request headers that would bring a 304 for Streamlit's unchanged file."""


def styles() -> str:
    """Return the app's style sheets in a ``<style>`` element."""
    sheets = (ROOT / "ui" / "assets" / f"{name}.css" for name in SHEETS)
    return f"<style>\n{''.join(sheet.read_text(encoding='utf-8') for sheet in sheets)}</style>\n"


class StyledPages:
    """Sends the styled page in place of Streamlit's, with status 404 at unknown addresses.

    Streamlit alone would answer with status 200.

    Parameters
    ----------
    pages
        Page names as they appear in addresses.
    """

    def __init__(self, app: ASGIApp, pages: Collection[str] = ()):
        self.app, self._pages, self._base = app, {"", "index.html", *pages}, base_path()
        self._page = page_with(styles())

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI connection."""
        name = str(scope.get("path", "")).removeprefix(self._base).strip("/")
        if scope["type"] != "http" or name.partition("/")[0] in FILES:
            await self.app(scope, receive, send)
            return
        status = HTTPStatus.OK if name in self._pages else HTTPStatus.NOT_FOUND
        page = HTMLResponse(self._page, status, {"Cache-Control": "no-cache"})
        is_page = False

        async def send_styled(message: Message) -> None:
            nonlocal is_page
            if message["type"] == "http.response.start":
                kind = Headers(raw=message["headers"]).get("content-type", "")
                is_page = message["status"] == HTTPStatus.OK and kind.startswith("text/html")
                if is_page:
                    await page(scope, receive, send)
            if not is_page:
                await send(message)

        headers = [header for header in scope["headers"] if header[0] not in CONDITIONS]
        await self.app({**scope, "headers": headers}, receive, send_styled)
