"""The gate: nothing but the way to the provider is open to who has not logged in."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Iterator
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
from asgi import Answer, ask
from people import cookies, header, log_in_by
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route
from starlette.types import Receive, Scope, Send
from streamlit.proto.ForwardMsg_pb2 import ForwardMsg
from streamlit.web.server.starlette.starlette_routes import create_host_config_routes

from ui.access import people as module
from ui.access.origins import own_names
from ui.access.people import end_log_in, key_of
from ui.serving import gate
from ui.serving.gate import Gate, OwnPages
from ui.session.routes import routes_below
from ui.session.workspace import Workspace
from ui.streamlit_inside import server

PAGE = {"accept": "text/html,*/*"}
STREAM = "/_stcore/stream"


async def inner(scope: Scope, receive: Receive, send: Send) -> None:
    """An app behind the gate; over a WebSocket it says how many messages it got."""
    if scope["type"] == "http":
        await PlainTextResponse("inside", headers={"set-cookie": "a=b"})(scope, receive, send)
        return
    await receive()
    await send({"type": "websocket.accept"})
    while (await receive())["type"] == "websocket.receive":
        await send({"type": "websocket.send", "text": "heard"})
    await send({"type": "websocket.send", "text": "late"})


@pytest.fixture
def behind(tmp_path: Path) -> Iterator[Gate]:
    with log_in_by(tmp_path, allow=["lab.example"]):
        yield Gate(inner)


@pytest.mark.parametrize(
    "path",
    [
        *("/", "/data", "/static/js/index.js", "/media/a.png", "/nv/token/boxes/0/0"),
        *("/_stcore/upload_file/a/b", "/_stcore/agent/x", "/nv/token/upload/oauth2callback"),
        *("/x/oauth2callback", "/oauth2callback/", "/_stcore/health/x", "//oauth2callback"),
    ],
)
def test_who_has_not_logged_in_gets_nothing(behind: Gate, path: str):
    assert (ask(path, app=behind).status, ask(path, app=behind).text) == (401, "log in first")
    page = ask(path, headers=PAGE, app=behind)
    assert (page.status, page.headers["cache-control"]) == (401, "no-store")
    assert "inside" not in page.text


def test_an_address_that_is_no_text_is_answered_as_well(behind: Gate):
    assert ask("/data?x=\udcff", headers=PAGE, app=behind).status == 401


@pytest.mark.parametrize("path", ["/oauth2callback", "/auth/login", "/auth/logout"])
def test_the_way_to_the_provider_and_back_is_open(behind: Gate, path: str):
    assert ask(path, app=behind).text == "inside"


def test_what_else_is_open_is_the_same_for_all_and_says_nothing_of_them(behind: Gate):
    for path in (server.HEALTH, server.HOST_CONFIG):
        assert ask(path, app=behind).text == "inside"
    streamlit = Starlette(routes=create_host_config_routes(""))
    answer = json.loads(ask(server.HOST_CONFIG, app=streamlit).text)
    origins = answer.pop("allowedOrigins")
    assert all("streamlit" in origin for origin in origins)  # its own cloud's
    assert sorted(answer) == [
        "blockErrorDialogs", "enableCustomParentMessages", "enforceDownloadInNewTab", "metricsUrl",
        "resourceCrossOriginMode", "useExternalAuthToken",
    ]  # fmt: skip
    assert not any(answer.values())


def test_who_has_logged_in_gets_all_and_cookies_by_tls_alone(behind: Gate):
    answer = ask("/data", headers=header(cookies("anna")), app=behind)
    assert answer.text == "inside"
    assert answer.headers["set-cookie"] == "a=b; Secure"
    assert answer.headers["vary"] == "Cookie"


def test_who_is_not_on_the_list_is_told_so_as_text(behind: Gate):
    carl = cookies("carl", email="<b>carl</b>@elsewhere.example")
    page = ask("/data", headers={**PAGE, **header(carl)}, app=behind)
    assert page.status == 403
    assert "&lt;b&gt;carl&lt;/b&gt;@elsewhere.example is not on the list" in page.text
    assert ask("/nv/t/boxes/0/0", headers=header(carl), app=behind).status == 403


def test_one_gets_to_the_address_that_was_asked_for(behind: Gate):
    page = ask("/timeline?frame=3", headers=PAGE, app=behind).text
    assert 'href="/log-in?provider=default&amp;next=%2Ftimeline%3Fframe%3D3"' in page
    way = ask("/log-in?provider=default&next=%2Ftimeline%3Fframe%3D3", app=behind)
    assert way.status == 302
    assert way.headers["location"].startswith("/auth/login?provider=")
    wanted = way.headers["set-cookie"].partition(";")[0].removeprefix("nvcore_wanted=")
    back = ask("/", headers=header({**cookies("anna"), "nvcore_wanted": wanted}), app=behind)
    assert (back.status, back.headers["location"]) == (302, "/timeline?frame=3")
    assert 'nvcore_wanted=""' in back.headers["set-cookie"]


@pytest.mark.parametrize("other", ["https://evil.example/", "//evil.example", r"/\evil.example"])
def test_and_never_to_another_server(behind: Gate, other: str):
    assert "set-cookie" not in ask(f"/log-in?next={other}", app=behind).headers
    wanted = {**cookies("anna"), "nvcore_wanted": other}
    assert ask("/", headers=header(wanted), app=behind).headers["location"] == "/"


def test_a_provider_that_is_not_set_up_is_not_found(behind: Gate):
    assert ask("/log-in?provider=evil", app=behind).status == 404


def test_a_log_out_ends_the_log_in(behind: Gate):
    anna = header(cookies("anna"))
    ask("/auth/logout", headers=anna, app=behind)
    assert ask("/data", headers=anna, app=behind).status == 401


def test_files_are_sent_to_one_s_own_session_alone(behind: Gate, monkeypatch: pytest.MonkeyPatch):
    class Space:
        owner = key_of(cookies("anna"))

    monkeypatch.setattr(gate, "workspace_of_session", {"s": Space()}.get)

    def sent(session: str, by: str) -> int:
        path = f"/_stcore/upload_file/{session}/file"
        return ask(path, method="PUT", headers=header(cookies(by)), app=behind).status

    assert (sent("s", "anna"), sent("s", "bert"), sent("other", "anna")) == (200, 403, 403)


def connect(
    app: Any, sent: list[Any], *, protocols: str = "streamlit, x, s", **headers: str
) -> list[dict[str, Any]]:
    """What comes over a WebSocket; `sent` are messages, or calls between them."""
    answered: list[dict[str, Any]] = []
    given = {"host": "localhost", "sec-websocket-protocol": protocols, **headers}
    scope = {
        "type": "websocket", "path": STREAM, "query_string": b"", "server": ("localhost", 80),
        "headers": [(name.encode(), value.encode()) for name, value in given.items()],
    }  # fmt: skip
    messages = [{"type": "websocket.connect"}, *sent, {"type": "websocket.disconnect"}]

    async def receive() -> dict[str, Any]:
        message = messages.pop(0)
        if callable(message):
            message()
            message = messages.pop(0)
        return message

    async def send(message: Any) -> None:
        answered.append(message)

    asyncio.run(app(scope, receive, send))
    return answered


HELLO = {"type": "websocket.receive", "bytes": b""}


def is_sent_away(answered: list[dict[str, Any]]) -> bool:
    """Whether the page is told to load itself anew, and no more."""
    *_, told, closed = answered
    message = ForwardMsg.FromString(told["bytes"])
    return message.WhichOneof("type") == "auth_redirect" and closed["type"] == "websocket.close"


def test_a_session_is_for_who_has_logged_in(behind: Gate):
    strangers = connect(behind, [HELLO])
    assert len(strangers) == 3
    assert is_sent_away(strangers)
    heard = connect(behind, [HELLO], **header(cookies("anna")))
    assert [message.get("text") for message in heard] == [None, "heard", "late"]


def test_a_session_of_somebody_else_is_not_taken_up_again(
    behind: Gate, monkeypatch: pytest.MonkeyPatch
):
    class Space:
        owner = key_of(cookies("anna"))

    monkeypatch.setattr(gate, "workspace_of_session", {"s": Space()}.get)
    assert is_sent_away(connect(behind, [HELLO], **header(cookies("bert"))))
    (closed,) = connect(behind, [HELLO], protocols=", x, s", **header(cookies("bert")))
    assert closed["type"] == "websocket.close"
    assert len(connect(behind, [HELLO], **header(cookies("anna")))) == 3
    other = connect(behind, [HELLO], protocols="streamlit, x", **header(cookies("bert")))
    assert other[1].get("text") == "heard"


def test_an_open_page_hears_of_the_end_of_the_log_in_with_its_next_message(behind: Gate):
    anna = cookies("anna")
    sent = [HELLO, lambda: end_log_in(anna), HELLO, HELLO]
    for protocols in ("streamlit", ""):
        module._ended.clear()
        answered = connect(behind, sent, protocols=protocols, **header(anna))
        assert [message.get("text") for message in answered[:2]] == [None, "heard"]
        assert len(answered) == 4
        assert is_sent_away(answered)


@pytest.mark.parametrize(
    "route",
    [route for route in routes_below("") if "{token}" in route.path],
    ids=attrgetter("path"),
)
def test_what_a_session_has_is_for_its_owner_alone(space: Workspace, behind: Gate, route: Route):
    owner = key_of(cookies("anna"))
    assert owner is not None
    space.owner = owner
    (method,) = set(route.methods) - {"HEAD"}

    def answer(token: str, **headers: str) -> Answer:
        place = re.sub("{.*?}", "0", route.path.replace("{token}", token))
        return ask(place, method=method, headers=headers)

    assert answer(space.token).status == 403
    assert answer(space.token, **header(cookies("bert"))).status == 403
    assert answer(space.token, **header(cookies("anna"))).status not in (200, 403)  # has nothing
    unknown = answer("guess", **header(cookies("anna")))
    assert (unknown.status, space.token in unknown.text) == (404, False)


def test_the_machine_s_name_is_asked_for_before_the_first_request(
    monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
):
    request.addfinalizer(own_names.cache_clear)
    own_names.cache_clear()
    monkeypatch.setattr("socket.getfqdn", lambda: "lab-3.corp.example")
    app = OwnPages(inner)
    monkeypatch.setattr("socket.getfqdn", None)  # whoever asks again fails
    assert ask("/data", headers={"host": "lab-3.corp.example"}, app=app).status == 200


def test_pages_of_others_and_names_of_others_are_refused():
    app = OwnPages(inner)
    assert ask("/data", app=app).text == "inside"
    foreign = ask("/data", headers={"host": "evil.example"}, app=app)
    assert (foreign.status, "STREAMLIT_SERVER_ALLOWED_HOSTS" in foreign.text) == (421, True)
    assert ask("/_stcore/health", headers={"host": "evil.example"}, app=app).status == 200
    sent = [
        ask("/x", method="PUT", headers={"host": "localhost", "origin": origin}, app=app).status
        for origin in ("http://localhost", "http://localhost:3000", "http://evil.example", "null")
    ]
    assert sent == [200, 403, 403, 403]
    assert ask("/x", method="PUT", headers={"sec-fetch-site": "cross-site"}, app=app).status == 403
    (closed,) = connect(app, [HELLO], origin="http://localhost:3000")
    assert closed["type"] == "websocket.close"
    assert len(connect(app, [HELLO], origin="http://localhost")) == 3
