"""First check of every request: it must come from our own pages and from a logged-in person.

Without a log-in only the addresses of the log-in itself are open. Pages answer with a log-in
button, everything else with 401. A WebSocket is told to reload the page, immediately if the log-in
ends while it is open.
"""

from __future__ import annotations

from http import HTTPStatus
from typing import Final
from urllib.parse import quote, unquote

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ui.access.login import Login, login
from ui.access.origins import is_own_host, is_own_origin, own_names
from ui.access.page import LOG_IN, NEXT, PROVIDER, is_own_address, log_in_page, refusal_page
from ui.access.people import Person, end_log_in, is_same, key_of, person_of
from ui.responses import PRIVATE, text_answer
from ui.session.lifetime import workspace_of_session
from ui.settings.start import base_path
from ui.streamlit_inside import login as inside_login
from ui.streamlit_inside import server

WANTED: Final = "nvcore_wanted"
"""Cookie with the address requested before the log-in."""
WANTED_S: Final = 600
SAFE: Final = ("GET", "HEAD", "OPTIONS")
POLICY_VIOLATION: Final = 1008
"""Close code of a WebSocket."""


class OwnPages:
    """Middleware that refuses requests for other hosts or from other sites' pages."""

    def __init__(self, app: ASGIApp):
        self.app, self._health = app, f"{base_path()}{server.HEALTH}"
        own_names()  # cached now, so that no request has to wait for it

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI connection."""
        if scope["type"] not in ("http", "websocket") or scope["path"] == self._health:
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        host, origin = headers.get("host"), headers.get("origin")
        is_read = scope["type"] == "http" and scope["method"] in SAFE
        is_foreign = origin is None and headers.get("sec-fetch-site") in ("cross-site", "same-site")
        is_ours = is_own_origin(origin, host) and not is_foreign
        if is_own_host(host) and (is_read or is_ours):
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await _refuse(receive, send)
        else:
            await text_answer(*_foreign_refusal(host))(scope, receive, send)


def _foreign_refusal(host: str | None) -> tuple[HTTPStatus, str]:
    if is_own_host(host):
        return HTTPStatus.FORBIDDEN, "this server accepts requests from its own pages only"
    return (
        HTTPStatus.MISDIRECTED_REQUEST,
        "This server does not answer to that host name. Its operator can allow the name in "
        "STREAMLIT_SERVER_ALLOWED_HOSTS.",
    )


class Gate:
    """Middleware that admits only people who have logged in, if a log-in is configured."""

    def __init__(self, app: ASGIApp):
        self.app, self._login, self._base = app, login(), base_path()
        of_log_in = (inside_login.CALLBACK, inside_login.LOG_IN, inside_login.LOG_OUT)
        paths = (*of_log_in, server.HEALTH, server.HOST_CONFIG, server.METRICS)
        self._public = {f"{self._base}{path}" for path in paths}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle an ASGI connection."""
        settings = self._login
        if settings is None or scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        cookies = HTTPConnection(scope).cookies
        if scope["type"] == "websocket":
            await self._connect(cookies, scope, receive, send)
            return
        send = _with_private_cookies(send, settings)
        path: str = scope["path"]
        if path == f"{self._base}{inside_login.LOG_OUT}":
            end_log_in(cookies)
        answer = (
            None
            if path in self._public
            else self._answer(scope, person_of(cookies, settings), settings)
        )
        await (answer or self.app)(scope, receive, send)

    def _answer(self, scope: Scope, person: Person | None, settings: Login) -> Response | None:
        """Return the gate's own answer, or None to let the app answer."""
        connection, path = HTTPConnection(scope), str(scope["path"])
        if path == f"{self._base}{LOG_IN}":
            return self._redirect_to_provider(connection, settings)
        if person is None or not person.may_enter:
            return self._refusal(connection, scope["method"], person, settings)
        upload = server.UPLOAD.search(path)
        if upload is not None:
            space = workspace_of_session(upload["session"])
            if space is None or not is_same(space.owner, person.key):
                return text_answer(HTTPStatus.FORBIDDEN, "this session belongs to someone else")
        wanted = unquote(connection.cookies.get(WANTED, ""))
        if path in (self._base, f"{self._base}/") and wanted:
            known = is_own_address(wanted, self._base)
            back = RedirectResponse(wanted if known else f"{self._base}/", 302, PRIVATE)
            back.delete_cookie(WANTED, path=f"{self._base}/")
            return back
        return None

    def _refusal(
        self, connection: HTTPConnection, method: str, person: Person | None, settings: Login
    ) -> Response:
        status = HTTPStatus.UNAUTHORIZED if person is None else HTTPStatus.FORBIDDEN
        if method != "GET" or "text/html" not in connection.headers.get("accept", ""):
            return text_answer(status, "log in first" if person is None else "you have no access")
        if person is not None:
            page = refusal_page(person.email, base=self._base)
        else:
            query = connection.scope["query_string"].decode("utf-8", "replace")
            wanted = quote(connection.scope["path"]) + (f"?{query}" if query else "")
            page = log_in_page(settings.providers, base=self._base, wanted=wanted)
        return HTMLResponse(page, status, PRIVATE)

    def _redirect_to_provider(self, connection: HTTPConnection, settings: Login) -> Response:
        query = connection.query_params
        provider = query.get(PROVIDER, settings.providers[0])
        if provider not in settings.providers:
            return text_answer(HTTPStatus.NOT_FOUND, "there is no such provider")
        answer = RedirectResponse(inside_login.address_of(provider), 302, PRIVATE)
        wanted = query.get(NEXT, "")
        if is_own_address(wanted, self._base):
            answer.set_cookie(
                WANTED,
                quote(wanted, safe=""),
                max_age=WANTED_S,
                path=f"{self._base}/",
                httponly=True,
                samesite="lax",
            )
        return answer

    async def _connect(
        self, cookies: dict[str, str], scope: Scope, receive: Receive, send: Send
    ) -> None:
        protocol, _, session = server.parse_subprotocols(Headers(scope=scope))
        key = key_of(cookies)
        if key is None or not _may_reconnect(session, key):
            if not scope["path"].endswith(server.STREAM) or not protocol:
                await _refuse(receive, send)
                return
            await receive()
            await send({"type": "websocket.accept", "subprotocol": protocol})
            await _reload_page(send)
            return
        is_logged_out = False

        async def receive_from_person() -> Message:
            nonlocal is_logged_out
            message = await receive()
            if message["type"] == "websocket.receive" and key_of(cookies) is None:
                is_logged_out = True  # first, since the app may be sending
                await _reload_page(send)
                return {"type": "websocket.disconnect", "code": POLICY_VIOLATION}
            return message

        async def send_to_person(message: Message) -> None:
            if not is_logged_out:
                await send(message)

        await self.app(scope, receive_from_person, send_to_person)


def _may_reconnect(session: str | None, key: str) -> bool:
    """Whether this person may reconnect to the session."""
    space = workspace_of_session(session) if session else None
    return space is None or is_same(space.owner, key)


async def _reload_page(send: Send) -> None:
    """Make the browser reload the page, which then shows the log-in."""
    await send({"type": "websocket.send", "bytes": inside_login.reload_message()})
    await send({"type": "websocket.close", "code": POLICY_VIOLATION})


async def _refuse(receive: Receive, send: Send) -> None:
    await receive()
    await send({"type": "websocket.close", "code": POLICY_VIOLATION})


def _with_private_cookies(send: Send, settings: Login) -> Send:
    """Mark cookies as secure if the app is served over TLS, and make caches vary by cookie."""

    async def send_private(message: Message) -> None:
        if message["type"] == "http.response.start":
            MutableHeaders(scope=message).add_vary_header("Cookie")
            if settings.is_secure:
                message["headers"] = [
                    (name, value if b"; secure" in value.lower() else value + b"; Secure")
                    if name.lower() == b"set-cookie"
                    else (name, value)
                    for name, value in message["headers"]
                ]
        await send(message)

    return send_private
