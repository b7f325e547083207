"""The app's server and the browser for all tests in this folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from app_server import ROOT, open_chromium, serve
from app_visit import Visit, new_person
from playwright.sync_api import Browser, BrowserContext


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


@pytest.fixture(scope="module")
def person(browser: Browser) -> Iterator[Callable[[str], BrowserContext]]:
    """Somebody's browser with this theme: kept for the module, since a full cache loads faster."""
    people: dict[str, BrowserContext] = {}

    def find(theme: str) -> BrowserContext:
        if theme not in people:
            people[theme] = new_person(browser, theme)
        return people[theme]

    yield find
    for one in people.values():
        one.close()


@pytest.fixture
def visit(person: Callable[[str], BrowserContext], app: str) -> Iterator[Callable[..., Visit]]:
    """Opens a page of the app in a new session; afterwards nothing may have gone wrong."""
    opened: list[Visit] = []

    def open_page(page: str = "", *, theme: str = "light") -> Visit:
        one = Visit(person(theme), app)
        opened.append(one)
        one.go(page)
        return one

    yield open_page
    for one in opened:
        one.close()
    assert [complaint for one in opened for complaint in one.complaints] == []
