"""Shared by the app's own routes: authorisation and short answers."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import wraps
from http import HTTPStatus
from typing import Final

from starlette.requests import Request
from starlette.responses import Response

from ui.access.origins import is_own_origin
from ui.access.people import is_same, key_of
from ui.answers import PRIVATE, text_answer
from ui.session.workspace import Workspace, workspace_of

Route = Callable[[Request], Awaitable[Response]]
Handler = Callable[[Request, Workspace | None], Awaitable[Response]]
MOST_DIGITS: Final = 12


@dataclass(frozen=True)
class Place:
    """A route below the address of a session, and its handler.

    Attributes
    ----------
    path
        As Starlette writes it: ``"frame/{recording}/{row}.jpg"``.
    """

    path: str
    answer: Route
    method: str = "GET"


_GUARDS: Final = {
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
}
CACHED: Final = {"Cache-Control": "private, max-age=3600", **_GUARDS}
NOT_CACHED: Final = {**PRIVATE, **_GUARDS}


def index_in(request: Request, name: str) -> int:
    """A path parameter that is an index from 0; anything else becomes an index out of range."""
    text = request.path_params[name]
    is_index = text.isascii() and text.isdigit() and len(text) < MOST_DIGITS
    return int(text) if is_index else 10**MOST_DIGITS


def for_owner(*, sent: str = "") -> Callable[[Handler], Route]:
    """Decorator of routes for a workspace's owner; they receive it, None if the session has ended.

    Parameters
    ----------
    sent
        What is sent, in the plural: only our own page may; empty: nothing is.
    """

    def guard(handle: Handler) -> Route:
        @wraps(handle)
        async def route(request: Request) -> Response:
            if sent and not is_own_page(request):
                return say(HTTPStatus.FORBIDDEN, f"{sent} come from the app's own page only")
            space = workspace_of(request.path_params["token"])
            if not is_owner(request, space):
                return say(HTTPStatus.FORBIDDEN, "log in as the one whose session this is")
            return await handle(request, space)

        return route

    return guard


def is_owner(request: Request, space: Workspace | None) -> bool:
    """Whether the sender may use the workspace; true if there is none."""
    key = key_of(request.cookies)
    return key is not None and (space is None or is_same(space.owner, key))


def is_own_page(request: Request) -> bool:
    """Whether the request comes from our own page; other programs send no origin."""
    if request.headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
        return False
    return is_own_origin(request.headers.get("origin"), request.headers.get("host"))


def say(status: int, text: str) -> Response:
    """A plain-text answer."""
    return text_answer(status, text, NOT_CACHED)


def not_found(text: str) -> Response:
    """A 404 answer with the reason."""
    return say(HTTPStatus.NOT_FOUND, text)
