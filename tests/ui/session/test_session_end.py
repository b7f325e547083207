"""A workspace is closed once its browser has been away for longer than it may."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from ui.session import lifetime
from ui.session.lifetime import GRACE_S, end_with_session, sweep, watch
from ui.settings.limits import Limits
from ui.streamlit_inside import sessions


class Thing:
    is_closed = False

    def close(self) -> None:
        self.is_closed = True


class Stuck:
    def __init__(self, error: Exception) -> None:
        self.error = error

    def close(self) -> None:
        raise self.error


class Browser:
    is_here = True

    def __call__(self) -> bool:
        return self.is_here


@pytest.fixture(autouse=True)
def watched(monkeypatch: pytest.MonkeyPatch) -> list:
    found: list = []
    monkeypatch.setattr(lifetime, "_watched", found)
    return found


@pytest.fixture
def now_s() -> float:
    return time.monotonic()


def test_it_is_closed_when_the_browser_stays_away_and_not_before(now_s: float, watched: list):
    thing, browser = Thing(), Browser()
    watch(thing, browser)
    sweep(now_s + 10 * GRACE_S)
    now_s += 10 * GRACE_S
    browser.is_here = False
    sweep(now_s + 0.8 * GRACE_S)
    browser.is_here = True
    sweep(now_s + 0.9 * GRACE_S)  # it came back in time
    browser.is_here = False
    sweep(now_s + 1.5 * GRACE_S)
    assert not thing.is_closed
    sweep(now_s + 2.0 * GRACE_S)
    assert thing.is_closed
    assert watched == []


def test_of_too_many_that_are_away_the_first_ones_end_at_once(
    now_s: float, watched: list, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(lifetime, "limits_of_environment", lambda: Limits(max_visitors=2))
    things, browsers = [Thing() for _ in range(4)], [Browser() for _ in range(4)]
    for thing, browser in zip(things, browsers, strict=True):
        watch(thing, browser)
    for number in (2, 0, 1):
        now_s += 1
        sweep(now_s)
        browsers[number].is_here = False
    sweep(now_s + 1)
    assert [thing.is_closed for thing in things] == [False, False, True, False]
    assert len(watched) == 3


@pytest.mark.parametrize("error", [OSError("disk gone"), RecursionError("disk gone")])
def test_what_cannot_be_closed_is_told_once_and_keeps_nothing_else_open(
    now_s: float, watched: list, caplog: pytest.LogCaptureFixture, error: Exception
):
    stuck, thing, browser = Stuck(error), Thing(), Browser()
    watch(stuck, browser)
    watch(thing, browser)
    browser.is_here = False
    sweep(now_s + 1.1 * GRACE_S)
    sweep(now_s + 1.2 * GRACE_S)
    assert thing.is_closed
    assert watched == []
    assert [record.getMessage() for record in caplog.records] == [
        "what a session left could not be removed: disk gone"
    ]


def test_what_is_gone_already_is_forgotten(now_s: float, watched: list):
    watch(Thing(), Browser())
    sweep(now_s)
    assert watched == []


def test_outside_a_session_nothing_is_watched(watched: list):
    end_with_session(Thing())
    assert watched == []


def test_what_another_session_has_taken_over_stays(now_s: float):
    thing, browser = Thing(), Browser()
    watch(thing, lambda: False)
    watch(thing, browser)
    sweep(now_s + 2 * GRACE_S)
    assert not thing.is_closed
    browser.is_here = False
    sweep(now_s + 4 * GRACE_S)
    assert thing.is_closed


def test_streamlit_forgets_the_session_with_the_files_that_it_sent(
    now_s: float, monkeypatch: pytest.MonkeyPatch
):
    """By itself it would keep them in memory until the next visitor comes."""

    forgotten: list[str] = []

    class Server:
        def close_session(self, session_id: str) -> None:
            forgotten.append(session_id)

    class Loop:
        def is_closed(self) -> bool:
            return False

        def call_soon_threadsafe(self, act: Callable[[str], None], session_id: str) -> None:
            act(session_id)

    monkeypatch.setattr(sessions.runtime, "exists", lambda: True)
    monkeypatch.setattr(sessions.runtime, "get_instance", Server)
    monkeypatch.setattr(lifetime, "_loops", [Loop()])
    thing = Thing()
    watch(thing, lambda: False, session_id="one")
    sweep(now_s + 0.9 * GRACE_S)
    assert forgotten == []
    sweep(now_s + 1.1 * GRACE_S)
    assert (thing.is_closed, forgotten) == (True, ["one"])
