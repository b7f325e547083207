"""One person's window at the app, which notes everything that goes wrong in it."""

from __future__ import annotations

import re
from typing import Any, Literal
from urllib.parse import urlsplit

from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import BrowserContext, ConsoleMessage, Locator, Page, expect

from ui.shell.pages import GROUPS, PAGE_OF

SECTION_OF = {page.title: page.section for page in PAGE_OF.values()}
SIZE = {"width": 1280, "height": 800}
GROUND = {"light": "rgb(255, 255, 255)", "dark": "rgb(17, 22, 27)"}
# Streamlit looks for its server below the page's own path first
HARMLESS = re.compile(r"/(_stcore/health|_stcore/host-config)$")
# While an expander unfolds, what is in it moves away from a click.
IS_DRAWN = """() => document.querySelector('[data-testid="stApp"]')
      ?.dataset.testScriptState === "notRunning"
  && window.nvAsked === window.nvBegun
  && document.querySelector("h1")
  && !document.querySelector('[data-testid="stSkeleton"], [data-stale="true"]')
  && [...document.querySelectorAll('[data-testid="stExpander"] details')]
    .every((part) => !part.getAnimations().length)"""


# A click is heard once the plot is reachable by keys, too; and a plot is drawn a second time when
# the page gives it another width.
LISTENS = """key => {
  const plot = document.querySelector(`.st-key-${key} .js-plotly-plot`);
  const layout = plot?._fullLayout;
  return plot?.nvClick && plot.tabIndex === 0 && layout?._size
    && Math.abs(layout.width - plot.getBoundingClientRect().width) < 1;
}"""

# Place in the plot's area of a trace's first point, and its customdata: [x, y, [row, encounter]].
FIRST_POINT = """(plot, name) => {
  const { _fullData, _fullLayout: { xaxis, yaxis } } = plot;
  const trace = _fullData.find(one => one.name === name);
  return [xaxis.d2p(trace.x[0]), yaxis.d2p(trace.y[0]), Object.values(trace.customdata[0])];
}"""

# A share of the width and of the height of a plot's area.
SHARE = """(plot, [across, down]) => {
  const { w, h } = plot._fullLayout._size;
  return [across * w, down * h];
}"""

# Faded text has too little contrast. What waits for Python fades, at any time where a page asks for
# news by itself: that is switched off. What is new fades in: that is waited for.
# An expander's label fades without saying that it is stale.
NO_FADING = """[data-stale], [data-testid="stExpander"] summary,
  [data-testid="stExpander"] summary * { opacity: 1 !important; transition: none !important; }"""
IS_STILL = """() => document.getAnimations()
  .every((motion) => !(motion instanceof CSSTransition) || motion.playState !== "running")"""


class Visit:
    """A page of the app in one window, with a session of its own.

    Attributes
    ----------
    complaints
        Errors in the console, scripts that failed, and requests to other hosts.
    """

    def __init__(
        self,
        context: BrowserContext,
        address: str,
        *,
        theme: Literal["light", "dark"] = "light",
        motion: Literal["reduce", "no-preference"] = "reduce",
        width: int = SIZE["width"],
    ) -> None:
        """Open an empty window.

        Parameters
        ----------
        motion
            Without a preference the wait for each page is animated, which costs more than the page.
        """
        self.address = address
        self.complaints: list[str] = []
        self.page: Page = context.new_page()
        self.page.set_viewport_size({**SIZE, "width": width})
        self.page.emulate_media(color_scheme=theme, reduced_motion=motion)
        self.page.on("request", lambda request: self._look_at_host(request.url))
        self.page.on("websocket", lambda socket: self._look_at_host(socket.url))
        self.page.on("console", self._look_at_message)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))

    def close(self) -> None:
        self.page.close()

    def go(self, page: str) -> None:
        """Open a page by its address, in a new session."""
        self.page.goto(f"{self.address}/{page}")
        self.wait_until_drawn()

    def switch_to(self, title: str) -> None:
        """Open another page by the navigation, in the same session."""
        self.find_entry(title).click()
        expect(self.heading(title, level=1)).to_be_visible()
        self.wait_until_drawn()

    def find_entry(self, title: str) -> Locator:
        """A page's link in the navigation, in its group unfolded or among the tabs of a page."""
        bar, section = self.keyed("navigation"), SECTION_OF[title]
        if title == "Saliency":
            if not self.keyed("tabs").count():
                self.switch_to("Encounters")
            return self.keyed("tabs").get_by_role("link", name=title)
        entry = bar.get_by_role("link", name=title, exact=True)
        if section not in GROUPS and entry.count():
            return entry
        # of a group, or last in the first one, as the comparison has no data for it
        group = section if section in GROUPS else GROUPS[0]
        bar.get_by_role("button", name=group).click()
        return self.page.get_by_test_id("stPopoverBody").get_by_role("link", name=title)

    def look_closer(self, part: str) -> None:
        """Unfold a section of a page, if it is folded."""
        sections = self.page.get_by_role("radiogroup", name="Look closer")
        sections.get_by_role("radio", name=part, exact=True).check()
        self.wait_until_drawn()

    def open_way(self, way: str) -> None:
        """Unfold the ways to open something on Data, and choose one."""
        self.keyed("data_ways").get_by_text("Open your own files").click()
        self.page.get_by_role("tab", name=way).click()
        self.wait_until_drawn()

    def prefer(self, theme: Literal["light", "dark"]) -> None:
        """Change the person's theme; plots and viewer have it a run later."""
        self.page.emulate_media(color_scheme=theme)
        app = self.page.get_by_test_id("stApp")
        expect(app).to_have_css("background-color", GROUND[theme])

    def wait_until_drawn(self) -> None:
        self.page.wait_for_function(IS_DRAWN)
        assert self.page.get_by_text("This page could not be drawn").count() == 0

    def accessibility_faults(self) -> list[str]:
        """What axe finds fault with; in the dark theme contrast only: all else is the same."""
        self.wait_until_drawn()
        self.page.add_style_tag(content=NO_FADING)
        self.page.wait_for_function(IS_STILL)
        options: dict[str, Any] = {"resultTypes": ["violations"]}
        if self.is_dark:
            options["runOnly"] = ["color-contrast"]
        report = Axe().run(self.page, options=options).response
        while not self.page.evaluate(IS_DRAWN):  # a run began meanwhile, and greys what it replaces
            self.wait_until_drawn()
            self.page.wait_for_function(IS_STILL)
            report = Axe().run(self.page, options=options).response
        assert len(report["passes"]) > (0 if self.is_dark else 10)
        return [
            f"{self.page.url} {rule['impact']} {rule['id']}: {node['html'][:200]} "
            f"{node['failureSummary']}"
            for rule in report["violations"]
            for node in rule["nodes"]
        ]

    @property
    def is_dark(self) -> bool:
        return self.page.evaluate("matchMedia('(prefers-color-scheme: dark)').matches")

    def recording_field(self, name: str) -> Locator:
        """The field for the recording while it holds this one.

        While a page is drawn anew the old field is there beside the new one for a moment: wait
        for one.
        """
        return self.page.locator(f'input[aria-label="Recording"][value="{name}"]')

    def heading(self, text: str | re.Pattern[str], *, level: int | None = None) -> Locator:
        if level is None:
            return self.page.get_by_role("heading", name=text)
        return self.page.get_by_role("heading", name=text, level=level)

    def keyed(self, key: str) -> Locator:
        """The widget or container with this key in the script."""
        return self.page.locator(f".st-key-{key}")

    def table(self, key: str) -> Locator:
        """The table whose key begins so."""
        return self.page.locator(f"[class*='st-key-{key}']").get_by_role("grid")

    def click_plot(self, key: str, find_place: str, arg: Any = None) -> Any:
        """Click into a plot.

        Parameters
        ----------
        find_place
            Function of the page, of the plot and `arg`: the place in the plot's area, [x, y] in
            pixels, and whatever else it knows of it.

        Returns
        -------
        What the function returned.
        """
        area = self.listening_plot(key)
        place = self.keyed(key).locator(".js-plotly-plot").evaluate(find_place, arg)
        area.click(position={"x": place[0], "y": place[1]})
        return place

    def listening_plot(self, key: str) -> Locator:
        """The area of a plot, once a click there is heard and it is in sight."""
        area = self.keyed(key).locator(".nsewdrag").first
        self.page.wait_for_function(LISTENS, arg=key)
        self.wait_until_drawn()
        plot = self.keyed(key).locator(".js-plotly-plot")
        expect(plot).to_have_count(1)  # one that is being replaced is gone
        area.click(trial=True)  # in sight, and no longer moved by what is drawn above it
        return area

    def slider(self, name: str) -> Locator:
        return self.page.get_by_role("slider", name=name)

    @property
    def viewer(self) -> Locator:
        return self.page.locator(".viewer")

    def shows(self, frame: int | re.Pattern[str]) -> None:
        """Wait until the viewer has painted this frame."""
        number = str(frame) if isinstance(frame, int) else frame
        expect(self.viewer).to_have_attribute("data-frame", number)
        expect(self.viewer).to_have_attribute("data-shown-frame", number)

    def panel_shows(self, frame: int) -> None:
        """Wait until Python's figures beside the viewer are those of this frame."""
        panel = self.page.get_by_test_id("stMarkdownContainer")
        expect(panel.filter(has_text=re.compile(rf"^Frame {frame},"))).to_be_visible()

    def query(self, name: str, value: str) -> None:
        """Wait until the page's address has this."""
        self.page.wait_for_function(
            "([name, value]) => new URL(location).searchParams.get(name) === value",
            arg=[name, value],
        )

    def _look_at_host(self, url: str) -> None:
        parts = urlsplit(url)
        if parts.scheme not in ("data", "blob") and parts.netloc != urlsplit(self.address).netloc:
            self.complaints.append(f"request to another host: {url}")

    def _look_at_message(self, message: ConsoleMessage) -> None:
        if message.type == "error" and not HARMLESS.search(message.location.get("url", "")):
            self.complaints.append(f"{message.text} ({message.location.get('url', '')})")
