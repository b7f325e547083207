"""Streamlit's server: what it answers where, whom it answers, and the page that it sends."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import streamlit
from streamlit.web.server.server_util import allowlisted_origins
from streamlit.web.server.starlette.starlette_websocket import (
    _parse_subprotocols,
    is_host_allowed,
)

HEALTH: Final = "/_stcore/health"
HOST_CONFIG: Final = "/_stcore/host-config"
"""Needed by a page that reconnects after a broken connection."""
STREAM: Final = "/_stcore/stream"
METRICS: Final = "/_stcore/metrics"
UPLOAD: Final = re.compile(r"/_stcore/upload_file/(?P<session>[^/]+)/[^/]+$")
FILES: Final = ("_stcore", "app", "auth", "component", "media", "static")
"""First parts of addresses that hold files and endpoints, not pages."""
STATIC: Final = Path(streamlit.__file__).parent / "static"
PAGE_END: Final = "</body>"

is_allowed_host = is_host_allowed
"""Whether ``server.allowedHosts`` names this host, if it names any."""
allowed_origins = allowlisted_origins
"""Those of ``server.corsAllowedOrigins``."""
parse_subprotocols = _parse_subprotocols
"""The subprotocol that a WebSocket asks for, its token, and the session that it resumes, if any."""


def inline_scripts() -> list[str]:
    """The scripts within the page."""
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    return re.findall(r"<script>(.*?)</script>", page, re.DOTALL)


def page_with(styles: str) -> str:
    """The page with styles of ours: after Streamlit's own in its head, so that ours win."""
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    return page.replace(PAGE_END, styles + PAGE_END)
