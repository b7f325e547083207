"""One person's browser window at the app, which notes everything that goes wrong in it."""

from __future__ import annotations

import re
from typing import Literal
from urllib.parse import urlsplit

from playwright.sync_api import Browser, ConsoleMessage, Locator, Page, Request, expect

SIZE = {"width": 1280, "height": 800}
WAIT_MS = 30_000
# Streamlit looks for its server below the page's own path first
HARMLESS = re.compile(r"/(_stcore/health|_stcore/host-config)$")
IS_DRAWN = """() => document.querySelector('[data-testid="stApp"]')
      ?.dataset.testScriptState === "notRunning"
  && document.querySelector("h1")
  && !document.querySelector('[data-testid="stSkeleton"], [data-stale="true"]')"""

expect.set_options(timeout=WAIT_MS)


class Visit:
    """A window with cookies of its own.

    Attributes
    ----------
    complaints
        Errors in the console, scripts that failed, and requests to other hosts.
    """

    def __init__(self, browser: Browser, address: str, *, theme: str = "light") -> None:
        scheme: Literal["light", "dark"] = "dark" if theme == "dark" else "light"
        self.address = address
        self.complaints: list[str] = []
        self._context = browser.new_context(viewport=SIZE, color_scheme=scheme)
        self._context.set_default_timeout(WAIT_MS)
        self._context.on("request", self._look_at_request)
        self._context.on("console", self._look_at_message)
        self._context.on("weberror", lambda error: self.complaints.append(str(error.error)))
        self.page: Page = self._context.new_page()
        self.page.on("websocket", lambda socket: self._look_at_host(socket.url))

    def close(self) -> None:
        self._context.close()

    def go(self, page: str) -> None:
        """Open a page by its address, in a new session."""
        self.page.goto(f"{self.address}/{page}")
        self.wait_until_drawn()

    def switch_to(self, title: str) -> None:
        """Open another page by the navigation, in the same session."""
        self.page.get_by_test_id("stTopNavLink").filter(has_text=title).click()
        expect(self.heading(title, level=1)).to_be_visible()
        self.wait_until_drawn()

    def wait_until_drawn(self) -> None:
        self.page.wait_for_function(IS_DRAWN)

    def heading(self, text: str | re.Pattern[str], *, level: int | None = None) -> Locator:
        if level is None:
            return self.page.get_by_role("heading", name=text)
        return self.page.get_by_role("heading", name=text, level=level)

    def keyed(self, key: str) -> Locator:
        """The widget or container with this key in the script."""
        return self.page.locator(f".st-key-{key}")

    def slider(self, name: str) -> Locator:
        return self.page.get_by_role("slider", name=name)

    @property
    def viewer(self) -> Locator:
        return self.page.locator(".viewer")

    def shows(self, frame: int | re.Pattern[str]) -> None:
        """Wait until the viewer has painted this frame."""
        number = str(frame) if isinstance(frame, int) else frame
        expect(self.viewer).to_have_attribute("data-frame", number)
        expect(self.viewer).to_have_attribute("data-shown-row", re.compile("^[0-9]+$"))

    def panel_shows(self, frame: int) -> None:
        """Wait until Python's figures beside the viewer are those of this frame."""
        expect(self.page.get_by_text(re.compile(rf"^Frame {frame},"))).to_be_visible()

    def query(self, name: str, value: str) -> None:
        """Wait until the page's address has this."""
        self.page.wait_for_function(
            "([name, value]) => new URL(location).searchParams.get(name) === value",
            arg=[name, value],
        )

    def _look_at_request(self, request: Request) -> None:
        self._look_at_host(request.url)

    def _look_at_host(self, url: str) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("data", "blob") and parts.netloc != urlsplit(self.address).netloc:
            self.complaints.append(f"request to another host: {url}")

    def _look_at_message(self, message: ConsoleMessage) -> None:
        if message.type == "error" and not HARMLESS.search(message.location.get("url", "")):
            self.complaints.append(f"{message.text} ({message.location.get('url', '')})")
