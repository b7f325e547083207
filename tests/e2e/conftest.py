"""The app's server and the browser for all tests in this folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from app_server import ROOT, open_chromium, serve
from app_visit import Visit
from playwright.sync_api import Browser


@pytest.fixture(scope="session")
def app() -> Iterator[str]:
    """Address of the app, started once."""
    with serve(ROOT / "app.py") as address:
        yield address


# Not for the session: while it is open an event loop runs, and no other test could start one.
@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with open_chromium() as opened:
        yield opened


@pytest.fixture
def visit(browser: Browser, app: str) -> Iterator[Callable[..., Visit]]:
    """Opens a page of the app as one more person; afterwards nothing may have gone wrong."""
    with ExitStack() as visits:
        opened: list[Visit] = []

        def open_page(page: str = "", *, theme: str = "light") -> Visit:
            one = Visit(browser, app, theme=theme)
            visits.callback(one.close)
            opened.append(one)
            one.go(page)
            return one

        yield open_page
        complaints = [complaint for one in opened for complaint in one.complaints]
    assert complaints == []
