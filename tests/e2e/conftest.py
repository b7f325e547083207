"""The app's server and the browser for all tests in this folder."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from typing import Any

import pytest
from app_files import CLIP_FRAMES, write_session
from app_server import HELPERS, ROOT, open_chromium, serve
from app_visit import Visit
from kept_window import HAS_FAILED, Kept
from playwright.sync_api import BrowserContext, Page
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


# Of the folder's package, not of the session: while it is open an event loop runs, and no test
# elsewhere could start one.
@pytest.fixture(scope="package")
def chromium() -> Iterator[BrowserContext]:
    """The browser, one for all tests: it loads faster what it has loaded before."""
    with open_chromium() as opened:
        yield opened


@pytest.fixture(scope="module")
def person(chromium: BrowserContext) -> BrowserContext:
    """Somebody's browser, without the cookies of other modules."""
    chromium.clear_cookies()
    return chromium


@pytest.fixture
def visit(person: BrowserContext, app: str) -> Iterator[Callable[..., Visit]]:
    """Opens a page of the app in a new session; afterwards nothing may have gone wrong."""
    opened: list[Visit] = []

    def open_page(page: str = "", by: BrowserContext = person, **looks: Any) -> Visit:
        one = Visit(by, app, **looks)
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
    person: BrowserContext,
    app: str,
    kept_visits: dict[tuple[str, str], Kept[Visit]],
) -> Iterator[Callable[..., Visit]]:
    """A page of the app that was opened once for all tests of a module; they leave it as it is."""
    with ExitStack() as lent:

        def find(page: str = "", *, theme: str = "light") -> Visit:
            def open_page() -> Visit:
                visit = Visit(person, app, theme=theme)
                visit.go(page)
                return visit

            kept = kept_visits.setdefault((page, theme), Kept(open_page))
            return lent.enter_context(kept.lend(request))

        yield find


@pytest.fixture(scope="session")
def viewer_address() -> Iterator[str]:
    """Address of the viewer's stand-alone page, started once."""
    with serve(HELPERS / "viewer_app.py") as url:
        yield url


@pytest.fixture(scope="module")
def viewer_window(person: BrowserContext, viewer_address: str) -> Iterator[Kept[ViewerWindow]]:
    kept = Kept(lambda: ViewerWindow(person, viewer_address))
    yield kept
    kept.close()


@pytest.fixture
def page(request: pytest.FixtureRequest, viewer_window: Kept[ViewerWindow]) -> Iterator[Page]:
    """The viewer on row 5 of its video, as if the page had just been opened."""
    with viewer_window.lend(request) as window:
        window.start_anew()
        yield window.page


@pytest.fixture(scope="module")
def short_app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A server with a short sample, which keeps its ratings in a folder of the test."""
    folder = tmp_path_factory.mktemp("short")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NVCORE_RATINGS", str(folder / "ratings.sqlite"))
        patch.setenv("NVCORE_TEST_SESSION", str(write_session(folder, CLIP_FRAMES)))
        with serve(HELPERS / "short_app.py") as address:
            yield address
