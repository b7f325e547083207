"""Access to Streamlit's log-in: its configuration, addresses and cookie."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, Final

from streamlit.auth_util import (
    get_cookie_with_chunks,
    get_secrets_auth_section,
    is_authlib_installed,
)
from streamlit.proto.ForwardMsg_pb2 import ForwardMsg
from streamlit.user_info import generate_login_redirect_url
from streamlit.web.server.starlette.starlette_app_utils import decode_signed_value
from streamlit.web.server.starlette.starlette_server_config import USER_COOKIE_NAME

LOG_IN: Final = "/auth/login"
LOG_OUT: Final = "/auth/logout"
CALLBACK: Final = "/oauth2callback"

has_authlib = is_authlib_installed
"""Whether Authlib is installed in a version that Streamlit supports."""
address_of = generate_login_redirect_url
"""Return the address where the log-in with a provider begins, by the provider's name."""


def section_of_secrets() -> Mapping[str, Any] | None:
    """Return the section ``[auth]`` of ``secrets.toml``, or None."""
    section = get_secrets_auth_section()
    return section.to_dict() if section else None


def signed_user(cookies: Mapping[str, str], secret: str, *, hours: float) -> bytes | None:
    """Return the signed user data in the cookies, or None if invalid or older than `hours`."""
    return get_cookie_with_chunks(partial(_decoded, cookies, secret, hours), USER_COOKIE_NAME)


def _decoded(cookies: Mapping[str, str], secret: str, hours: float, name: str) -> bytes | None:
    value = cookies.get(name)
    if value is None:
        return None
    try:
        signed = value.encode("latin-1")
    except UnicodeEncodeError:
        return None
    return decode_signed_value(secret, name, signed, max_age_days=hours / 24)


def reload_message() -> bytes:
    """Return a WebSocket message that makes a browser reload the page."""
    message = ForwardMsg()
    message.auth_redirect.url = ""  # the current address
    return bytes(message.SerializeToString())
