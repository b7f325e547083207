"""The page: the styles are there before anything is drawn, unknown addresses have status 404."""

from __future__ import annotations

from pathlib import Path

import pytest
import streamlit
from asgi import Answer, ask
from starlette.responses import HTMLResponse
from starlette.staticfiles import StaticFiles

from ui.serving import styles as module
from ui.serving.styles import StyledPages, styles

PAGES = Path(streamlit.__file__).parent / "static"
FILES = StaticFiles(directory=PAGES, html=True)


def answer(path: str, **headers: str) -> Answer:
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return ask(path, headers={"accept-encoding": "gzip", **named}, app=StyledPages(FILES))


def test_the_page_has_the_styles_after_its_head():
    page = (PAGES / "index.html").read_text(encoding="utf-8")
    head, end = page.rsplit("</body>", 1)
    got = answer("/")
    assert got.text == f"{head}{styles()}</body>{end}"
    assert ".nv-tiles" in styles()
    assert got.headers["content-length"] == str(len(got.body))


def test_a_page_that_the_browser_has_is_sent_again_since_our_part_may_be_newer():
    got = answer("/", if_none_match=ask("/", app=FILES).headers["etag"])
    assert got.status == 200
    assert not {"etag", "last-modified"} & set(got.headers)


def test_what_is_no_page_stays_as_it_is():
    picture = answer("/favicon.png")
    assert picture.body == (PAGES / "favicon.png").read_bytes()
    assert "etag" in picture.headers
    report = ask("/media/report.html", app=StyledPages(HTMLResponse("<title>a report</title>")))
    assert (report.status, report.text) == (200, "<title>a report</title>")


@pytest.mark.parametrize("base", ["", "/apps/night"])
@pytest.mark.parametrize(
    ("path", "status"),
    [
        *(("/", 200), ("/index.html", 200), ("/data", 200), ("/data/", 200)),
        *(("/docs", 404), ("/openapi.json", 404), ("/data/more", 404)),
        ("/nv/token/upload/pictures", 404),
    ],
)
def test_the_page_has_status_404_where_it_is_none(
    monkeypatch: pytest.MonkeyPatch, base: str, path: str, status: int
):
    monkeypatch.setattr(module, "base_path", lambda: base)
    got = ask(f"{base}{path}", app=StyledPages(HTMLResponse("Streamlit's"), pages=["data"]))
    assert (got.status, styles() in got.text) == (status, True)
