"""Access to Streamlit's server: its addresses, allowed hosts and origins, and its page."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

import streamlit
from streamlit.web.server.server_util import allowlisted_origins
from streamlit.web.server.starlette.starlette_websocket import _parse_subprotocols, is_host_allowed

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
"""Return the origins in ``server.corsAllowedOrigins``."""
parse_subprotocols = _parse_subprotocols
"""Return a WebSocket's requested subprotocol, its token, and the session to resume, if any."""


def inline_scripts() -> list[str]:
    """Return the inline scripts of Streamlit's page."""
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    return re.findall(r"<script>(.*?)</script>", page, re.DOTALL)


def page_with(styles: str) -> str:
    """Return Streamlit's page with our styles at its end, so that ours override Streamlit's."""
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    return page.replace(PAGE_END, styles + PAGE_END)
