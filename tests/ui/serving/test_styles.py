"""The styles in the page: there before anything is drawn, and never those of an older version."""

from __future__ import annotations

import asyncio
from pathlib import Path

import streamlit
from asgi import Answer, asked
from starlette.staticfiles import StaticFiles

from ui.serving.styles import OwnStyles, styles

PAGES = Path(streamlit.__file__).parent / "static"
AS_PAGE = {"accept": "text/html,*/*;q=0.8", "accept-encoding": "gzip"}


def answer(path: str, **headers: str) -> Answer:
    app = OwnStyles(StaticFiles(directory=PAGES, html=True))
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return asyncio.run(asked(path, headers={**AS_PAGE, **named}, app=app))


def test_the_page_has_the_styles_after_its_head():
    page = (PAGES / "index.html").read_text(encoding="utf-8")
    head, end = page.rsplit("</body>", 1)
    got = answer("/")
    assert got.text == f"{head}{styles()}</body>{end}"
    assert ".nv-tiles" in styles()
    assert got.headers["content-length"] == str(len(got.body))


def test_a_page_that_the_browser_has_is_sent_again_since_our_part_may_be_newer():
    original = asyncio.run(asked("/", app=StaticFiles(directory=PAGES, html=True)))
    got = answer("/", if_none_match=original.headers["etag"])
    assert got.status == 200
    assert not {"etag", "last-modified"} & set(got.headers)


def test_what_is_no_page_stays_as_it_is():
    picture = answer("/favicon.png")
    assert picture.body == (PAGES / "favicon.png").read_bytes()
    assert "etag" in picture.headers
