"""Configuration of the visitors' log-in, which is optional.

The section ``[auth]`` of a TOML file has the keys of Streamlit's ``st.login``, and two of our own,
``allow`` and ``hours`` (docs/hosting.md). The file is given by ``nvcore app --login FILE`` or
`VARIABLE`, or else is Streamlit's own ``secrets.toml``. An error in it stops the start, so that a
server never runs without the requested log-in.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final
from urllib.parse import urlsplit

import streamlit as st

from nvcore.common.errors import InputError
from nvcore.common.extras import needs
from nvcore.inputs.session.toml_text import parse_toml
from ui.settings.start import argument, base_path
from ui.streamlit_inside.login import CALLBACK, has_authlib, section_of_secrets

FLAG: Final = "--login"
VARIABLE: Final = "NVCORE_LOGIN"
HOURS: Final = 12.0
MAX_HOURS: Final = 24.0 * 30
"""Lifetime of Streamlit's cookie."""
SECRET_CHARACTERS: Final = 32
DEFAULT: Final = "default"
"""Streamlit's name of the provider whose keys are in ``[auth]`` itself."""
PROVIDER_KEYS: Final = ("client_id", "client_secret", "server_metadata_url")
LOCAL: Final = ("localhost", "127.0.0.1", "::1")

_LOG = logging.getLogger("nvcore.ui")


@dataclass(frozen=True)
class Login:
    """Settings of the log-in.

    Attributes
    ----------
    section
        The whole section ``[auth]``, for Streamlit.
    providers
        Names of the providers to choose from.
    cookie_secret
        Secret that signs the cookie with the user's identity.
    redirect_uri
        Address to which the provider sends the browser back, as the browser sees it.
    allow
        E-mail addresses and domains to admit, in lower case. None: everybody with an account.
    hours
        Duration of a log-in.
    """

    section: Mapping[str, Any]
    providers: tuple[str, ...]
    cookie_secret: str
    redirect_uri: str
    allow: frozenset[str] | None
    hours: float

    @property
    def origin(self) -> str:
        """Origin of the app, as the browser sees it."""
        parts = urlsplit(self.redirect_uri)
        return f"{parts.scheme}://{parts.netloc}"

    @property
    def is_secure(self) -> bool:
        """Whether the app is served over TLS, so that cookies can be marked as secure."""
        return self.redirect_uri.startswith("https://")

    def admits(self, email: str) -> bool:
        """Whether a person with this e-mail address, verified by the provider, may enter."""
        if self.allow is None:
            return True
        name, _, domain = email.lower().rpartition("@")
        if not email.isascii() or not name or "@" in name:
            return False
        return f"{name}@{domain}" in self.allow or domain in self.allow


@cache
def login() -> Login | None:
    """Return the log-in settings, read once, or None if nobody has to log in.

    Raises
    ------
    InputError
        If the settings are invalid.
    MissingExtraError
        If the packages for it are missing.
    """
    path = argument(FLAG, VARIABLE)
    section = section_of(Path(path)) if path else _section_of_secrets()
    if section is None:
        return None
    with needs("login", "log-in needs"):
        import authlib  # noqa: F401
        import httpx  # noqa: F401
    if not has_authlib():
        raise InputError("log-in needs a newer Authlib: pip install --upgrade 'nvcore[login]'")
    settings = read_login(section, file=path or "secrets.toml", base=base_path())
    if settings.allow is None:
        _LOG.warning("everybody with an account at the provider may enter: [auth] has no 'allow'")
    return settings


def read_login(section: Mapping[str, Any], *, file: str, base: str = "") -> Login:
    """Validate the section ``[auth]`` and return its settings.

    Parameters
    ----------
    file
        File of the section, for errors.
    base
        Path below which the app is served, with a leading slash.

    Raises
    ------
    InputError
        If a setting is invalid.
    """
    wrong = _Wrong(file)
    redirect_uri = wrong.text(section, "redirect_uri").replace(
        "{port}", str(st.get_option("server.port"))
    )
    try:
        parts = urlsplit(redirect_uri)
    except ValueError:  # half of an IPv6 address
        parts = urlsplit("")
    if parts.scheme not in ("http", "https") or not parts.hostname:
        raise wrong(f"redirect_uri: expected https://HOST{base}{CALLBACK}, got {redirect_uri!r}")
    if parts.path != f"{base}{CALLBACK}" or parts.query or parts.fragment:
        raise wrong(
            f"redirect_uri: expected a path {base}{CALLBACK} (server.baseUrlPath and {CALLBACK}), "
            f"got {parts.path!r}"
        )
    if parts.scheme == "http" and parts.hostname not in LOCAL:
        raise wrong("redirect_uri: expected https, since cookies can be read on the way by http")
    secret = wrong.text(section, "cookie_secret")
    if len(secret) < SECRET_CHARACTERS:
        raise wrong(
            f"cookie_secret: expected {SECRET_CHARACTERS} random characters or more, got "
            f"{len(secret)}; python -c 'import secrets; print(secrets.token_urlsafe(32))' makes one"
        )
    named = {name: of for name, of in section.items() if isinstance(of, Mapping)}
    named.pop("client_kwargs", None)
    if any(key in section for key in PROVIDER_KEYS):
        named = {DEFAULT: section, **named}
    if not named:
        raise wrong(f"expected {', '.join(PROVIDER_KEYS)}")
    for name, provider in named.items():
        if "_" in name:
            raise wrong(f"provider {name!r}: expected a name without underscores")
        for key in PROVIDER_KEYS:
            wrong.text(provider, key)
    hours = section.get("hours", HOURS)
    if isinstance(hours, bool) or not isinstance(hours, int | float) or not 0 < hours <= MAX_HOURS:
        raise wrong(f"hours: expected a number above 0, {MAX_HOURS:g} at most, got {hours!r}")
    return Login(
        section=section,
        providers=tuple(named),
        cookie_secret=secret,
        redirect_uri=redirect_uri,
        allow=_allowed(section.get("allow"), wrong),
        hours=float(hours),
    )


def _allowed(given: Any, wrong: _Wrong) -> frozenset[str] | None:
    if given is None:
        return None
    if not isinstance(given, list) or not given:
        raise wrong('allow: expected a list such as ["example.com", "anna@partner.example"]')
    allow = set()
    for entry in given:
        text = entry.strip().lower().removeprefix("@") if isinstance(entry, str) else ""
        name, at, domain = text.rpartition("@")
        is_whole = text.isascii() and "." in domain and not set(text) & set(" *,/")
        if not is_whole or (at and not name) or "@" in name:
            raise wrong(f"allow: expected an e-mail address or a domain, got {entry!r}")
        allow.add(text)
    return frozenset(allow)


class _Wrong:
    """Factory of errors about one file."""

    def __init__(self, file: str) -> None:
        self._file = file

    def __call__(self, message: str) -> InputError:
        return InputError(f"[auth]: {message}", file=self._file)

    def text(self, section: Mapping[str, Any], key: str) -> str:
        value = section.get(key)
        if not isinstance(value, str) or not value.strip():
            raise self(f"{key}: expected a text, got {value!r}" if value else f"{key} is missing")
        return value


def section_of(path: Path) -> Mapping[str, Any]:
    """Read the section ``[auth]`` of a TOML file.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or has no such section.
    """
    section = _read(path).get("auth")
    if not isinstance(section, dict):
        raise InputError("has no section [auth]", file=path)
    return section


def _section_of_secrets() -> Mapping[str, Any] | None:
    for name in st.get_option("secrets.files"):
        if Path(name).is_file():
            _read(Path(name))  # Streamlit ignores a file that it cannot read
    return section_of_secrets()


def _read(path: Path) -> dict[str, Any]:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", file=path) from error
    return parse_toml(content, file=path)
