"""Addresses that lead nowhere say so to programs."""

from __future__ import annotations

import pytest
from asgi import ask
from starlette.responses import HTMLResponse

from ui.serving import headers
from ui.serving.headers import KnownPages

PAGE = HTMLResponse("<title>the app</title>")


@pytest.mark.parametrize("base", ["", "/apps/night"])
@pytest.mark.parametrize(
    ("path", "status"),
    [
        *(("/", 200), ("/index.html", 200), ("/data", 200), ("/data/", 200)),
        *(("/docs", 404), ("/openapi.json", 404), ("/data/more", 404)),
        *(("/nv/token/upload/pictures", 404), ("/media/report.html", 200)),
    ],
)
def test_the_page_has_status_404_where_it_is_none(
    monkeypatch: pytest.MonkeyPatch, base: str, path: str, status: int
):
    monkeypatch.setattr(headers, "base_path", lambda: base)
    answer = ask(f"{base}{path}", app=KnownPages(PAGE, pages=["data"]))
    assert (answer.status, answer.text) == (status, "<title>the app</title>")
