"""Identity of a browser's user, from the cookie that Streamlit signed after the log-in.

Streamlit checks the cookie only when a session begins. This module checks it with each request and
each message: its signature, its age, that it is for this address, that its user has not logged out,
and that the user may enter at all.
"""

from __future__ import annotations

import hashlib
import json
import secrets
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import streamlit as st

from nvcore.common.errors import NvcoreError
from ui.access.login import Login, login
from ui.streamlit_inside.login import signed_user

NOBODY: Final = ""
"""Key of everybody if no log-in is configured."""


@dataclass(frozen=True)
class Person:
    """Person who has logged in.

    Attributes
    ----------
    key
        Hash of provider, issuer and subject, the same for all log-ins of a person.
    log_in
        Hash that identifies this log-in.
    email
        E-mail address verified by the provider. Empty if there is none.
    may_enter
        True if the operator admits this person.
    """

    key: str
    log_in: str
    email: str
    may_enter: bool


_ended: dict[str, float] = {}
"""Time of logging out by log-in. Copies of the cookies of these log-ins are refused."""
_lock = threading.Lock()


def person_of(cookies: Mapping[str, str], settings: Login) -> Person | None:
    """Return the person who has logged in with these cookies, or None."""
    signed = signed_user(cookies, settings.cookie_secret, hours=settings.hours)
    if signed is None:
        return None
    log_in = hashlib.sha256(signed).hexdigest()
    with _lock:
        if log_in in _ended:
            return None
    try:
        claims = json.loads(signed)
    except ValueError:
        return None
    if not isinstance(claims, dict) or claims.get("origin") != settings.origin:
        return None
    who = [claims.get(name) for name in ("provider", "iss", "sub")]
    if claims.get("is_logged_in") is not True or not all(isinstance(part, str) for part in who):
        return None
    email = _verified_email(claims)
    return Person(
        key=hashlib.sha256(json.dumps(who).encode()).hexdigest(),
        log_in=log_in,
        email=email,
        may_enter=settings.admits(email),
    )


def key_of(cookies: Mapping[str, str]) -> str | None:
    """Return the key of the person who may enter with these cookies, or None.

    If no log-in is configured, everybody may enter, as `NOBODY`.
    """
    settings = login()
    if settings is None:
        return NOBODY
    person = person_of(cookies, settings)
    return person.key if person is not None and person.may_enter else None


def owner_of_session() -> str:
    """Return the key of the running session's person.

    Raises
    ------
    NvcoreError
        If nobody has logged in, although the gate lets no session begin without a log-in.
    """
    if login() is None:
        return NOBODY
    key = key_of(st.context.cookies)
    if key is None:
        raise NvcoreError("The log-in has ended. Load the page again to log in.")
    return key


def is_same(owner: str, key: str | None) -> bool:
    """Whether the key is the owner's, compared in constant time."""
    return key is not None and secrets.compare_digest(owner.encode(), key.encode())


def end_log_in(cookies: Mapping[str, str]) -> None:
    """End the log-in with these cookies, and refuse copies of them."""
    settings = login()
    person = None if settings is None else person_of(cookies, settings)
    if settings is None or person is None:
        return
    now = time.time()
    with _lock:
        for log_in, ended in list(_ended.items()):  # oldest first
            if now - ended < 3600 * settings.hours:
                break
            del _ended[log_in]
        _ended[person.log_in] = now


def _verified_email(claims: Mapping[str, Any]) -> str:
    email = claims.get("email")
    return email if isinstance(email, str) and claims.get("email_verified") is True else ""
