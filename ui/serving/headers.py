"""Security headers of every answer."""

from __future__ import annotations

import base64
import hashlib
import os
from typing import Final

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ui.streamlit_inside.server import inline_scripts

FRAMED_BY: Final = "NVCORE_FRAME_ANCESTORS"
"""Environment variable with the sites that may embed the app, in the syntax of a content security
policy. Default: only the app itself."""


def content_policy(framed_by: str = "'self'") -> str:
    """Return the content security policy.

    Scripts and data come from the app only. Inline styles are allowed because Streamlit and Plotly
    write them. Blobs are allowed for the viewer's script and the colour maps.
    """
    digests = (hashlib.sha256(script.encode()).digest() for script in inline_scripts())
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    sources = {
        "default-src": "'self'",
        "script-src": f"'self' blob: 'wasm-unsafe-eval' {hashes}",
        "style-src": "'self' 'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "media-src": "'self' data: blob:",
        "font-src": "'self' data:",
        "connect-src": "'self' data: blob:",
        "worker-src": "'self' blob:",
        "object-src": "'none'",
        "base-uri": "'self'",
        "form-action": "'self'",
        "frame-ancestors": framed_by,
    }
    return "; ".join(f"{name} {value}" for name, value in sources.items())


class SecureHeaders:
    """Middleware that adds security headers, unless an answer sets them itself."""

    def __init__(self, app: ASGIApp):
        self.app = app
        self._headers = {
            "Content-Security-Policy": content_policy(os.environ.get(FRAMED_BY) or "'self'"),
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "same-origin",
            "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
            "Cross-Origin-Opener-Policy": "same-origin",
        }

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI connection."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def send_with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in self._headers.items():
                    headers.setdefault(name, value)
            await send(message)

        await self.app(scope, receive, send_with_headers)
