"""Whose pages may talk to the server: those that it sent, under a name that is its own.

A page of another site could otherwise give its own name to this server's address (DNS rebinding),
and read all that a visitor has open. An attacker needs a name of the internet for that: numbers,
names without a dot and those of the machine itself are fine, any other the operator has to allow.
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
    """Whether a request to this host, as its header says, is meant for this server."""
    if st.get_option("server.allowedHosts"):
        return is_allowed_host(host)
    name = _hostname(host)
    return name is not None and (
        _is_number(name) or "." not in name or name.endswith(".localhost") or name in own_names()
    )


def is_own_origin(origin: str | None, host: str | None) -> bool:
    """Whether a request comes from this server's own page, or no browser says where from.

    The origin is the host that was asked, or one of ``server.corsAllowedOrigins``, where a proxy
    gives another host on.
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
    """Names of this server; the first call asks the network, which may take seconds."""
    settings = login()
    addresses = [*allowed_origins(), *([] if settings is None else [settings.origin])]
    names = [urlsplit(address).hostname for address in addresses]
    names += [st.get_option("browser.serverAddress"), socket.gethostname(), socket.getfqdn()]
    return frozenset(name.lower().rstrip(".") for name in names if name)
