"""Host and origin checks, which restrict the server to requests from its own pages.

Another site could otherwise point its own host name to this server's address (DNS rebinding), and
read everything that a visitor has open. An attacker needs an internet host name for that. So IP
addresses, names without a dot and the machine's own names are accepted, and the operator has to
allow any other name.
"""

from __future__ import annotations

import socket
from functools import cache
from ipaddress import ip_address
from urllib.parse import urlsplit

import streamlit as st

from ui.access.login import login
from ui.streamlit_inside.server import allowed_origins, is_allowed_host


def is_own_host(host: str | None) -> bool:
    """Whether the host in a request's header is one of this server's own."""
    if st.get_option("server.allowedHosts"):
        return is_allowed_host(host)
    name = _hostname(host)
    return name is not None and (
        _is_number(name) or "." not in name or name.endswith(".localhost") or name in own_names()
    )


def is_own_origin(origin: str | None, host: str | None) -> bool:
    """Whether a request comes from this server's own pages, or has no origin.

    The origin must equal the requested host, or be one of ``server.corsAllowedOrigins`` if a proxy
    replaces the host.
    """
    if not is_own_host(host):
        return False
    return origin is None or _netloc(origin) == host or origin in allowed_origins()


def _netloc(origin: str) -> str | None:
    try:
        return urlsplit(origin).netloc
    except ValueError:
        return None


def _hostname(host: str | None) -> str | None:
    try:
        name = urlsplit(f"//{host or ''}").hostname
    except ValueError:
        return None
    return name.rstrip(".") if name else None


def _is_number(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


@cache
def own_names() -> frozenset[str]:
    """Return the host names of this server. The first call may take seconds (DNS)."""
    settings = login()
    addresses = [*allowed_origins(), *([] if settings is None else [settings.origin])]
    names = [urlsplit(address).hostname for address in addresses]
    names += [st.get_option("browser.serverAddress"), socket.gethostname(), socket.getfqdn()]
    return frozenset(name.lower().rstrip(".") for name in names if name)
