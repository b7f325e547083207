"""A server takes so many visitors and so many bytes, and keeps its metrics to itself."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
from pathlib import Path
from typing import Any

import pytest
from asgi import Answer, ask
from starlette.responses import PlainTextResponse
from starlette.types import Receive, Scope, Send

from nvcore.common.errors import InputError
from ui.serving import life, visitors
from ui.serving.headers import SecureHeaders
from ui.serving.visitors import METRICS_TOKEN, TRY_AGAIN_LATER, VisitorLimits
from ui.settings.limits import MEBI, Limits, limits_of_environment

UPLOAD = "/base/_stcore/upload_file/session/file"
STREAM = {"type": "websocket", "path": "/base/_stcore/stream"}
HTML = {"accept": "text/html,*/*"}
PAGE = os.sysconf("SC_PAGE_SIZE")


async def inner(scope: Scope, receive: Receive, send: Send) -> None:
    """An app behind the limits: reads what is sent, and answers."""
    while (await receive()).get("more_body"):
        pass
    await PlainTextResponse("fine")(scope, receive, send)


def limited(**limits: int) -> VisitorLimits:
    return VisitorLimits(inner, Limits(**limits))


def upload(app: VisitorLimits, n_bytes: int | str) -> Answer:
    return ask(UPLOAD, method="PUT", headers={"content-length": str(n_bytes)}, app=app)


def test_a_visitor_more_than_the_server_takes_is_told_to_come_later():
    async def visit() -> tuple[list[dict[str, Any]], list[dict[str, Any]], list[dict[str, Any]]]:
        leaves, is_in = asyncio.Event(), asyncio.Event()

        async def stream(scope: Scope, receive: Receive, send: Send) -> None:
            if scope["type"] == "http":
                await PlainTextResponse("page")(scope, receive, send)
                return
            await send({"type": "websocket.accept"})
            is_in.set()
            await leaves.wait()

        app = VisitorLimits(stream, Limits(max_visitors=1))
        answers: list[list[dict[str, Any]]] = [[], [], []]

        async def connect(number: int) -> None:
            async def receive() -> dict[str, Any]:
                return {"type": "websocket.connect"}

            async def send(message: Any) -> None:
                answers[number].append(message)

            await app(dict(STREAM), receive, send)

        first = asyncio.create_task(connect(0))
        await is_in.wait()
        await connect(1)
        leaves.set()
        await first
        await connect(2)
        return answers[0], answers[1], answers[2]

    first, second, third = asyncio.run(visit())
    assert first == third == [{"type": "websocket.accept"}]
    assert second == [{"type": "websocket.close", "code": TRY_AGAIN_LATER}]


def test_a_page_says_that_the_server_is_full(monkeypatch: pytest.MonkeyPatch):
    app = limited(max_visitors=1)
    assert ask("/overview", headers=HTML, app=app).status == 200
    app._n_visitors = 1
    answer = ask("/overview", headers=HTML, app=app)
    assert (answer.status, "1 visitors at a time" in answer.text) == (503, True)
    assert ask("/nv/token/boxes/0/0", app=app).status == 200  # of a visitor who is there


def test_files_in_memory_are_capped_for_each_visitor_and_for_all(monkeypatch: pytest.MonkeyPatch):
    held = {"session": 0, None: 0}
    monkeypatch.setattr(visitors, "held_bytes", lambda session=None: held[session])
    app = limited(max_upload_mb=2, max_uploads_mb=3)
    assert upload(app, 2 << 20).status == 200
    assert upload(app, (2 << 20) + 1).status == 413
    held.update({"session": 1 << 20, None: 1 << 20})
    assert upload(app, 1 << 20).status == 200
    assert "A visitor may upload 2 MB" in upload(app, (1 << 20) + 1).text
    held[None] = 3 << 20
    assert "room for 0.0 MB." in upload(app, 1).text
    assert upload(app, "").status == upload(app, "-1").status == 411


def test_files_in_memory_take_a_third_of_what_the_control_group_leaves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def machine(held_mb: int) -> None:
        """Of 2048 MiB the server has 100 and its visitors' files."""
        (tmp_path / "proc/self/statm").write_text(f"0 {(100 + held_mb) * MEBI // PAGE} 0\n")
        monkeypatch.setattr(visitors, "held_bytes", lambda _=None: held_mb * MEBI)

    (tmp_path / "proc/self").mkdir(parents=True)
    (tmp_path / "proc/meminfo").write_text("MemAvailable:  60000000 kB\nSwapFree: 0 kB\n")
    (tmp_path / "sys/fs/cgroup").mkdir(parents=True)
    (tmp_path / "sys/fs/cgroup/memory.max").write_text(f"{2048 * MEBI}\n")
    app = VisitorLimits(inner, Limits(max_upload_mb=10_000), tmp_path)
    sent = []
    for n_held in range(5):  # a third of 1948 MiB is 649
        machine(190 * n_held)
        sent.append(upload(app, 190 * MEBI))
    assert [answer.status for answer in sent] == [200, 200, 200, 413, 413]
    assert "The file has 190.0 MB, the server room for 79.3 MB." in sent[3].text
    machine(0)  # they have gone
    assert upload(app, 190 * MEBI).status == 200
    (tmp_path / "sys/fs/cgroup/memory.max").write_text("max\n")
    assert [upload(app, n * MEBI).status for n in (2048, 2049)] == [200, 413]
    (tmp_path / "proc/meminfo").unlink()  # as outside Linux
    assert [upload(app, n * MEBI).status for n in (2048, 2049)] == [200, 413]
    app = VisitorLimits(inner, Limits(max_upload_mb=10_000, max_uploads_mb=5000), tmp_path)
    assert [upload(app, n * MEBI).status for n in (5000, 5001)] == [200, 413]


@pytest.mark.parametrize("why", ["silent", "the server ends"])
def test_a_sender_that_falls_silent_counts_as_gone_and_all_do_at_the_end(
    why: str, monkeypatch: pytest.MonkeyPatch
):
    if why == "silent":
        monkeypatch.setattr(visitors, "IDLE_S", 0.01)
    else:
        monkeypatch.setattr(life, "_shutdown", threading.Event())
        life._noting_shutdown(lambda *_: None)(signal.SIGTERM, None)
    received: list[str] = []

    async def read(scope: Scope, receive: Receive, send: Send) -> None:
        received.append((await receive())["type"])

    async def put() -> None:
        async def silent() -> Any:
            await asyncio.Event().wait()

        async def send(message: Any) -> None:
            raise AssertionError(message)

        scope = {"type": "http", "method": "PUT", "path": "/nv/token/upload/video", "headers": []}
        await VisitorLimits(read, Limits())(scope, silent, send)

    asyncio.run(put())
    assert received == ["http.disconnect"]


def test_a_sender_that_only_drips_counts_as_gone(monkeypatch: pytest.MonkeyPatch):
    now = [0.0]
    monkeypatch.setattr(visitors.time, "monotonic", lambda: now[0])

    def n_received(n_bytes: int, every_s: float) -> int:
        async def drip() -> Any:
            now[0] += every_s
            return {"type": "http.request", "body": bytes(n_bytes), "more_body": True}

        async def count() -> int:
            receive, n = visitors._with_timeout(drip), 0
            while n < 100 and (await receive())["type"] == "http.request":
                n += 1
            return n

        return asyncio.run(count())

    assert n_received(1, 50.0) < 4
    assert n_received(100 * visitors.MIN_BYTES_PER_S, 50.0) == 100


def test_metrics_are_for_whoever_has_the_token(monkeypatch: pytest.MonkeyPatch):
    def metrics(**headers: str) -> int:
        return ask("/_stcore/metrics", headers=headers, app=limited()).status

    monkeypatch.delenv(METRICS_TOKEN, raising=False)
    assert metrics() == metrics(authorization="Bearer ") == 404
    monkeypatch.setenv(METRICS_TOKEN, "secret")
    assert metrics() == metrics(authorization="Bearer secreT") == 404
    assert metrics(authorization="Bearer secret") == 200


def test_every_answer_has_the_headers_and_keeps_its_own(monkeypatch: pytest.MonkeyPatch):
    async def own(scope: Scope, receive: Receive, send: Send) -> None:
        answer = PlainTextResponse("", headers={"Referrer-Policy": "no-referrer"})
        await answer(scope, receive, send)

    monkeypatch.setenv("NVCORE_FRAME_ANCESTORS", "https://wiki.example")
    headers = ask("/", app=SecureHeaders(own)).headers
    assert headers["content-security-policy"].endswith("frame-ancestors https://wiki.example")
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"


def test_limits_come_from_the_environment(monkeypatch: pytest.MonkeyPatch):
    limits_of_environment.cache_clear()
    monkeypatch.setenv("NVCORE_MAX_VISITORS", "3")
    assert limits_of_environment() == Limits(max_visitors=3)
    limits_of_environment.cache_clear()
    monkeypatch.setenv("NVCORE_MAX_VISITORS", "0")
    with pytest.raises(InputError, match="NVCORE_MAX_VISITORS: expected a whole number above 0"):
        limits_of_environment()
