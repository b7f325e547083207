"""The viewer's clock and pictures in the hands of a test, however busy the machine is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Page
from viewer_reading import READER

# The viewer is at rest after two paints, so that none of its requests waits for the real clock.
HOLD = """() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => {
  const { requestAnimationFrame: request, cancelAnimationFrame: cancel } = window;
  const waiting = new Map();
  let last = 0;
  let now = performance.now();
  window.requestAnimationFrame = (act) => {
    last += 1;
    waiting.set(last, act);
    return last;
  };
  window.cancelAnimationFrame = (handle) => waiting.delete(handle);
  window.testClock = {
    advance(seconds) {
      now += 1000 * seconds;
      const due = [...waiting.values()];
      waiting.clear();
      due.forEach((act) => act(now));
    },
    release() {
      window.requestAnimationFrame = request;
      window.cancelAnimationFrame = cancel;
      waiting.forEach((act) => window.requestAnimationFrame(act));
    },
  };
  done();
})))"""
ADVANCE = f"""(viewer, seconds) => {{
  window.testClock.advance(seconds);
  return ({READER})(viewer);
}}"""
IS_PAINTED = """([viewer, rows]) => {
  window.testClock.advance(0);
  return rows.includes(Number(viewer.dataset.shownRow));
}"""

HOLD_PICTURES = """(first) => {
  const { fetch } = window;
  const waiting = new Map();
  window.testPictures = {
    isAsked: (row) => waiting.has(row),
    let(row) {
      waiting.get(row)();
      waiting.delete(row);
    },
    release() {
      window.fetch = fetch;
      waiting.forEach((go) => go());
    },
  };
  window.fetch = async (address, options) => {
    const row = String(address).match(/[/]frame[/][0-9]+[/]([0-9]+)[.]jpg/)?.[1];
    if (Number(row) >= first) await new Promise((go) => waiting.set(Number(row), go));
    return fetch(address, options);
  };
}"""

SLOW_PICTURES = """(seconds) => {
  const { fetch } = window;
  const now = performance.now;
  let late = 0;
  performance.now = () => now.call(performance) + late;
  window.fetch = async (address, options) => {
    const answer = await fetch(address, options);
    late += 1000 * seconds;
    return answer;
  };
  window.testSlowness = {
    end() {
      window.fetch = fetch;
      delete performance.now;
    },
  };
}"""


class Clock:
    """Time of a page, which stands still between two calls."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._viewer = page.locator(".viewer")

    def advance(self, seconds: float) -> dict[str, float]:
        """Let so much time pass and paint once; what is on the canvas then."""
        return self._viewer.evaluate(ADVANCE, seconds)

    def wait_for(self, *rows: int) -> dict[str, float]:
        """Paint, while no time passes, until one of these rows is on the canvas."""
        arg = [self._viewer.element_handle(), rows]
        self._page.wait_for_function(IS_PAINTED, arg=arg, polling=10)
        return self.advance(0)


@contextmanager
def held_clock(page: Page) -> Iterator[Clock]:
    """Stop the clock by which the page paints."""
    page.evaluate(HOLD)
    try:
        yield Clock(page)
    finally:
        page.evaluate("window.testClock.release()")


class Pictures:
    """Pictures that are kept back until a test lets them through."""

    def __init__(self, page: Page) -> None:
        self._page = page

    def wait_for(self, row: int) -> None:
        """Wait until the viewer has asked for the picture of this row."""
        # not by requestAnimationFrame, which may be held
        self._page.wait_for_function("row => testPictures.isAsked(row)", arg=row, polling=10)

    def let(self, row: int) -> None:
        """Let the picture of this row through, once the viewer has asked for it."""
        self.wait_for(row)
        self._page.evaluate("row => testPictures.let(row)", row)


@contextmanager
def held_pictures(page: Page, first: int) -> Iterator[Pictures]:
    """Keep back every picture from this row on.

    Not those before it: the viewer has only a few requests at a time, and what it is still loading
    as the test begins would take their place for ever.
    """
    page.evaluate(HOLD_PICTURES, first)
    try:
        yield Pictures(page)
    finally:
        page.evaluate("window.testPictures.release()")


@contextmanager
def slow_pictures(page: Page, seconds: float) -> Iterator[None]:
    """Let every picture seem to take so long; nobody waits for it."""
    page.evaluate(SLOW_PICTURES, seconds)
    try:
        yield
    finally:
        page.evaluate("testSlowness.end()")
