"""The app's server and the browser for all tests in this folder."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from app_server import PATIENCE_MS, ROOT, open_chromium, serve
from app_visit import Visit, new_person
from kept_window import HAS_FAILED, Kept
from playwright.sync_api import Browser, BrowserContext, Page
from viewer_window import ViewerWindow


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, Any]:
    """Fixtures ask whether the test went wrong."""
    report = yield
    item.stash[HAS_FAILED] = item.stash.get(HAS_FAILED, False) or report.failed
    return report


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


@pytest.fixture(scope="module")
def kept_visits() -> Iterator[dict[tuple[str, str], Kept[Visit]]]:
    visits: dict[tuple[str, str], Kept[Visit]] = {}
    yield visits
    for kept in visits.values():
        kept.close()


@pytest.fixture
def shared(
    request: pytest.FixtureRequest,
    person: Callable[[str], BrowserContext],
    app: str,
    kept_visits: dict[tuple[str, str], Kept[Visit]],
) -> Iterator[Callable[..., Visit]]:
    """A page of the app that was opened once for all tests of a module; they leave it as it is."""
    with ExitStack() as lent:

        def find(page: str = "", *, theme: str = "light") -> Visit:
            def open_page() -> Visit:
                visit = Visit(person(theme), app)
                visit.go(page)
                return visit

            kept = kept_visits.setdefault((page, theme), Kept(open_page))
            return lent.enter_context(kept.lend(request))

        yield find


@pytest.fixture(scope="session")
def viewer_address() -> Iterator[str]:
    """Address of the viewer's stand-alone page, started once."""
    with serve(Path(__file__).with_name("viewer_app.py")) as url:
        yield url


@pytest.fixture(scope="module")
def viewer_windows(browser: Browser) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    context.set_default_timeout(PATIENCE_MS)
    yield context
    context.close()


@pytest.fixture(scope="module")
def viewer_window(
    viewer_windows: BrowserContext, viewer_address: str
) -> Iterator[Kept[ViewerWindow]]:
    kept = Kept(lambda: ViewerWindow(viewer_windows, viewer_address))
    yield kept
    kept.close()


@pytest.fixture
def page(request: pytest.FixtureRequest, viewer_window: Kept[ViewerWindow]) -> Iterator[Page]:
    """The viewer on row 5 of its video, as if the page had just been opened."""
    with viewer_window.lend(request) as window:
        window.start_anew()
        yield window.page
