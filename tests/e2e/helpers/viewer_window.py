"""What a test does to the viewer in its window, and what it reads from it."""

from __future__ import annotations

import re
from contextlib import suppress

from app_server import PATIENCE_MS
from playwright import sync_api
from viewer_reading import READER, RECORDER

SIZE = {"width": 1280, "height": 900}
# At once: it may come to its end by itself, and would then begin again.
PAUSE = """viewer => {
  if (viewer.dataset.playing === "true") viewer.querySelector("button.play").click();
}"""
IS_AT_REST = """() => document.querySelector('[data-testid="stApp"]')
  ?.dataset.testScriptState === "notRunning" && window.nvAsked === window.nvBegun"""


class ViewerWindow:
    """A window with the viewer alone, kept from test to test: each finds it as newly opened.

    Attributes
    ----------
    complaints
        Errors of the page's scripts.
    """

    def __init__(self, context: sync_api.BrowserContext, address: str) -> None:
        self.complaints: list[str] = []
        self.page = context.new_page()
        self.page.set_viewport_size(SIZE)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.goto(address)
        self._visit = 1

    def start_anew(self) -> None:
        """Put slider, recording and all else back, with a new viewer and nothing focused."""
        self.page.keyboard.press("Escape")  # an open list hides all else
        self._rest()
        self.page.mouse.move(0, 0)
        self.page.get_by_role("button", name="start anew").click()
        self._visit += 1
        self.wait()
        self.page.evaluate("document.activeElement.blur()")

    def _rest(self) -> None:
        """Wait until Python knows the viewer's row and rests: Streamlit can lose a click before."""
        viewer = viewer_of(self.page)
        is_empty = self.page.get_by_text(re.compile("^settled .* kind empty ")).count() > 0
        if viewer.count() == 0 or is_empty:  # without frames there is no row to settle on
            return
        viewer.evaluate(PAUSE)
        if row := viewer.get_attribute("data-row"):
            assert settled(self.page, row) == row
        self.page.wait_for_function(IS_AT_REST)

    def wait(self) -> None:
        """Wait for the viewer of this visit."""
        self.page.get_by_text(re.compile(f" visit {self._visit}$")).wait_for()
        sync_api.expect(viewer_of(self.page)).to_have_count(1)
        assert painted(self.page, 5) == 5


def viewer_of(page: sync_api.Page) -> sync_api.Locator:
    return page.locator(".viewer")


def painted(page: sync_api.Page, row: int) -> int:
    """The row on the canvas, once it is this one or has had the time to be."""
    with suppress(sync_api.TimeoutError):
        page.wait_for_selector(f'.viewer[data-shown-row="{row}"]')
        return row
    return int(viewer_of(page).get_attribute("data-shown-row") or -1)


def settled(page: sync_api.Page, row: int | str) -> str:
    """The row that Python has heard of, once it is this one or has had the time to be."""
    text = page.get_by_text(re.compile("^settled "))
    with suppress(sync_api.TimeoutError):
        text.filter(has_text=re.compile(f"^settled {row} ")).wait_for()
    return text.inner_text().split()[1]


def n_runs(page: sync_api.Page) -> int:
    """How often Python has run since the test began."""
    return int(page.get_by_text(re.compile("^settled ")).inner_text().split()[-3])


def press(page: sync_api.Page, *keys: str) -> None:
    viewer_of(page).focus()
    for key in keys:
        page.keyboard.press(key)


def repaint(page: sync_api.Page) -> None:
    """Wait until the viewer has painted what it was told to before."""
    viewer_of(page).evaluate("() => new Promise(requestAnimationFrame)")


def record(page: sync_api.Page, low: int, high: int | None = None) -> list[dict[str, float]]:
    """What is painted while the viewer plays, up to the first row from `low` and below `high`."""
    arg = [low, 1 << 30 if high is None else high, PATIENCE_MS]
    return viewer_of(page).evaluate(RECORDER, arg)


def choose(page: sync_api.Page, recording: str) -> None:
    """Choose a recording, and wait until its viewer has taken the place of the one before."""
    page.get_by_role("combobox", name="recording").click()
    page.get_by_role("option", name=recording, exact=True).click()
    sync_api.expect(page.get_by_text(f" kind {recording} run ")).to_be_visible()
    page.wait_for_function(IS_AT_REST)


def read(page: sync_api.Page) -> dict[str, float]:
    return viewer_of(page).evaluate(READER)
