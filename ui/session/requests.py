"""What the app's own routes have in common: who may ask, and short answers."""

from __future__ import annotations

from http import HTTPStatus
from typing import Final

from starlette.requests import Request
from starlette.responses import Response

from ui.access.origins import is_own_origin
from ui.access.people import is_same, key_of
from ui.answers import PRIVATE, text_answer
from ui.session.workspace import Workspace

MOST_DIGITS: Final = 12
_GUARDS: Final = {
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
}
CACHED: Final = {"Cache-Control": "private, max-age=3600", **_GUARDS}
NOT_CACHED: Final = {**PRIVATE, **_GUARDS}


def index_in(request: Request, name: str) -> int:
    """A part of the address that counts from 0; anything else becomes an index beyond all."""
    text = request.path_params[name]
    is_index = text.isascii() and text.isdigit() and len(text) < MOST_DIGITS
    return int(text) if is_index else 10**MOST_DIGITS


def is_owner(request: Request, space: Workspace | None) -> bool:
    """Whether the person with this browser may use the workspace; also where there is none."""
    key = key_of(request.cookies)
    return key is not None and (space is None or is_same(space.owner, key))


def of_somebody_else() -> Response:
    """The answer to who may not use the workspace."""
    return say(HTTPStatus.FORBIDDEN, "log in as the one whose session this is")


def is_own_page(request: Request) -> bool:
    """Whether our own page sends this; programs other than browsers state no origin."""
    if request.headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
        return False
    return is_own_origin(request.headers.get("origin"), request.headers.get("host"))


def say(status: int, text: str) -> Response:
    """An answer in words."""
    return text_answer(status, text, NOT_CACHED)


def not_found(text: str) -> Response:
    """The answer where there is nothing, and why."""
    return say(HTTPStatus.NOT_FOUND, text)
