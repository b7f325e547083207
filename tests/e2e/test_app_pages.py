"""Every page of the sample in a real browser: what it leads to, its look, its accessibility."""

from __future__ import annotations

import re

import pandas as pd
import pytest
from app_visit import GROUND, SECTION_OF, SHARE, Visit
from PIL import Image
from playwright.sync_api import Locator, Route, expect

from nvcore.figures.style import LOOK

NAMELESS = (
    ".js-plotly-plot:is(:not([role][aria-label]), [aria-label=Figure], [aria-label^='Figure.'])"
)
# Names of figures with labels that reach beyond them, or with nothing for 30 px above the plot.
WASTEFUL = """() => [...document.querySelectorAll(".js-plotly-plot")].filter(plot => {
  const box = plot.getBoundingClientRect();
  const isOut = text => {
    const { left, right, top, bottom, width } = text.getBoundingClientRect();
    return width && (left < box.left - 1 || right > box.right + 1 || top < box.top - 1
      || bottom > box.bottom + 1);
  };
  const texts = [...plot.querySelectorAll(
    ":is(.infolayer, .xaxislayer-above, .yaxislayer-above) text")];
  const above = texts.filter(text => text.getBoundingClientRect().width)
    .map(text => text.getBoundingClientRect().top - box.top);
  return texts.some(isOut) || Math.min(plot._fullLayout._size.t, ...above) > 30;
}).map(plot => plot.getAttribute("aria-label"))"""
# Whether a run has drawn the page in a theme: its plots have letters of this colour.
HAS_LETTERS = """colour => [...document.querySelectorAll(".js-plotly-plot")]
  .every(plot => plot._fullLayout?.font.color === colour)"""
ADDRESSED_FRAME = "new URL(location).searchParams.get('frame')"
# Place in the plot's area of the marker of the Venn diagram that lies deepest in a region.
FIND_REGION = """(plot, category) => {
  const trace = plot._fullData[0], layout = plot._fullLayout;
  const { w, h } = layout._size;
  const all = [...trace.customdata.keys()].map(i => ({
    x: layout.xaxis.l2p(trace.x[i]), y: layout.yaxis.l2p(trace.y[i]),
    isOwn: String(trace.customdata[i]) === category }));
  const others = all.filter(one => !one.isOwn);
  const depth = one => Math.min(one.x, w - one.x, one.y, h - one.y,
    ...others.map(other => Math.hypot(one.x - other.x, one.y - other.y)));
  const deepest = all.filter(one => one.isOwn).reduce((a, b) => depth(a) < depth(b) ? b : a);
  return [deepest.x, deepest.y];
}"""


# Place in the plot's area of the largest mark of a region of the Venn diagram.
FIND_MARK = """(plot, name) => {
  const trace = plot._fullData.find(one => one.name === name), layout = plot._fullLayout;
  const size = trace.marker.size, largest = size.indexOf(Math.max(...size));
  return [layout.xaxis.l2p(trace.x[largest]), layout.yaxis.l2p(trace.y[largest]),
    trace.customdata[largest]];
}"""


# Where the tiles of the verdict and the scorecard were, from frame to frame, once both were there.
NOTE_PLACES = """window.places = new Set();
(function look() {
  const parts = [...document.querySelectorAll(".nv-tiles, .nv-scorecard")];
  if (parts.length === 2) {
    places.add(parts.map(part => part.getBoundingClientRect())
      .map(({ left, top }) => [Math.round(left), Math.round(top)]).join());
  }
  requestAnimationFrame(look);
})();"""


def test_nothing_moves_while_the_verdict_is_drawn(person, app):
    visit = Visit(person, app)
    visit.page.add_init_script(NOTE_PLACES)
    late: list[Route] = []
    is_held = True

    def hold(route: Route) -> None:
        if is_held:
            late.append(route)
        else:
            route.continue_()

    visit.page.route(re.compile(r"/(PageLink|rehype-raw)\.[^/]*\.js"), hold)
    visit.page.goto(app)
    expect(visit.keyed("verdict")).to_contain_text("do not tell X and Y apart")
    expect(visit.page.locator(".nv-scorecard")).to_be_visible()
    is_held = False  # what is asked for from now on goes through
    assert late != []
    for route in late:
        route.continue_()
    expect(visit.keyed("navigation").get_by_role("link").first).to_be_visible()
    visit.wait_until_drawn()
    places = visit.page.evaluate("[...places]")
    visit.close()
    assert len(places) == 1


def test_clicks_on_the_overview_open_what_was_clicked(visit):
    one = visit("")

    def opens_its_frame(recording: str | None = None) -> int:
        expect(one.heading("Timeline", level=1)).to_be_visible()
        if recording:
            one.query("recording", recording)
        one.wait_until_drawn()
        frame = int(one.page.evaluate(ADDRESSED_FRAME))
        one.shows(frame)
        return frame

    # a region of the Venn diagram lists its encounters
    for category, count in (("x_only", 8), ("neither", 3)):
        one.click_plot("venn", FIND_REGION, category)
        expect(one.heading("Encounters", level=1)).to_be_visible()
        expect(one.page.get_by_text(f"{count} of 46 encounters")).to_be_visible()
        one.query("category", category)
        one.wait_until_drawn()  # of those whom neither detects nothing says who is first
        expect(one.page.locator(NAMELESS)).to_have_count(0)
        one.switch_to("Overview")

    # a mark in it opens the frame that costs most: there X misses a child until it is near
    one.click_plot("venn", FIND_MARK, "only Y, by severity")
    opens_its_frame("winter_frost")

    # a place in the strip of all recordings: in the worst one, after 9 s
    one.switch_to("Overview")
    one.click_plot("loss_strip", SHARE, [0.6, 0.05])
    assert 170 <= opens_its_frame("winter_frost") <= 190

    # a worst moment; their buttons are in a line, however long the texts above them
    one.switch_to("Overview")
    one.look_closer("Moments to look at")
    buttons = one.page.get_by_role("button", name="Open frame")
    expect(buttons).to_have_count(4)
    # at once: what is drawn above them moves them all
    tops = buttons.evaluate_all("all => all.map(one => one.getBoundingClientRect().top)")
    assert tops == [tops[0]] * 4
    buttons.first.click()
    opens_its_frame()
    expect(one.page.get_by_text("Pedestrians by term")).to_be_visible()


def test_no_page_has_an_accessibility_fault_in_either_theme(visit):
    one = visit("")
    themes = ["light", "dark"]
    faults: list[str] = []
    for title in SECTION_OF:
        one.switch_to(title)
        if title == "Timeline":
            one.shows(re.compile("^[0-9]+$"))
        for theme in themes:
            one.prefer(theme)
            one.page.wait_for_function(HAS_LETTERS, arg=LOOK[theme].ink)
            one.wait_until_drawn()
            expect(one.page.locator(NAMELESS), title).to_have_count(0)
            faults += [f"{title}, {theme}: {name}" for name in one.page.evaluate(WASTEFUL)]
            faults += [f"{theme}: {fault}" for fault in one.accessibility_faults()]
        themes.reverse()  # the next page is opened in the theme of this one
    assert faults == []


def test_a_theme_and_a_change_of_it_reach_page_plots_and_viewer(visit):
    one = visit("timeline", theme="dark")  # from the first page on
    one.shows(re.compile("^[0-9]+$"))
    expect(one.page.get_by_test_id("stApp")).to_have_css("background-color", GROUND["dark"])
    expect(one.viewer).to_have_attribute("data-theme", "dark")
    axis = one.page.locator("[class*=st-key-time_plot_] .xtick text").first
    expect(axis).to_have_css("fill", "rgb(163, 174, 187)")
    one.prefer("light")
    expect(one.viewer).to_have_attribute("data-theme", "light")
    expect(axis).not_to_have_css("fill", "rgb(163, 174, 187)")


# How far the right edges of the navigation's bar and of the page below it are apart, px.
BAR_ENDS_SHORT = """() => {
  const right = of => of.getBoundingClientRect().right;
  const bar = document.querySelector(".st-key-navigation_place").parentElement;
  return right(document.querySelector("[data-testid=stMainBlockContainer]")) - right(bar); }"""


def test_a_figure_is_explained_fills_the_screen_and_is_taken_away(visit, tmp_path):
    one = visit("")
    # the navigation covers what scrolls below it, up to the right edge
    assert abs(one.page.evaluate(BAR_ENDS_SHORT)) < 1

    # how to read it stands behind its question mark
    mark = one.page.get_by_label("About this figure: Encounters detected")
    link = one.page.locator(".nv-help").get_by_role("link", name="severity")
    expect(link).to_be_hidden()
    mark.press("Enter")
    expect(link).to_be_visible()
    link.press("Escape")
    expect(link).to_be_hidden()
    expect(mark).to_be_focused()
    mark.click()
    expect(link).to_be_visible()
    one.heading("Overview", level=1).click()
    expect(link).to_be_hidden()

    def menu_of(name: str) -> Locator:
        button = one.page.get_by_label(f"Take this figure away: {name}")
        return one.page.locator(".nv-take").filter(has=button)

    # it fills the screen and comes back
    plot = one.keyed("venn").locator(".js-plotly-plot")
    fills = (
        "plot => plot._fullLayout.height === innerHeight && plot._fullLayout.width === innerWidth"
    )
    before = plot.evaluate("plot => plot._fullLayout.height")
    menu_of("Encounters detected").locator("summary").click()
    menu_of("Encounters detected").get_by_role("button", name="Full screen").click()
    one.page.wait_for_function(fills, arg=plot.element_handle())
    one.page.evaluate("document.exitFullscreen()")
    one.page.wait_for_function(
        f"plot => plot._fullLayout.height === {before}", arg=plot.element_handle()
    )

    # it is taken away as picture, drawing and data
    one.look_closer("Recording by recording")
    menu = menu_of("Similarity by recording")
    files = {}
    for label, suffix in (("Picture", ".png"), ("Drawing", ".svg"), ("Data", ".csv")):
        menu.locator("summary").click()
        with one.page.expect_download() as download:
            menu.get_by_role("button", name=label).click()
        assert download.value.suggested_filename == f"similarity-by-recording{suffix}"
        files[suffix] = tmp_path / f"figure{suffix}"
        download.value.save_as(files[suffix])
    width = one.page.locator(".st-key-by_recording svg.main-svg").first.bounding_box()
    with Image.open(files[".png"]) as picture:
        assert picture.width == pytest.approx(2 * width["width"], abs=2)
    drawing = files[".svg"].read_text(encoding="utf-8")
    assert "Similarity by recording" in drawing
    assert "winter_frost" in drawing
    assert "@font-face" in drawing
    table = pd.read_csv(files[".csv"])
    similarity = "mean similarity (1 = perfect), from 0.48"
    assert list(table.columns)[:3] == ["series", similarity, "y"]
    fir = table[table.series == "X: FIR"].set_index("y")[similarity]
    assert len(fir) == 10
    assert fir["rural_road"] == pytest.approx(0.943, abs=1e-3)


# The page is as wide as the window, once the plots and letters are those that stay.
FITS = """width => {
  const { clientWidth, scrollWidth } = document.querySelector("[data-testid=stMain]");
  return clientWidth === width && scrollWidth === width && document.fonts.status === "loaded";
}"""
# Texts of the page that are wider than their place and cut there.
CUT = """() => [...document.querySelectorAll(
    "[data-testid=stMain] :is(h1, h2, p, button, td, th, summary)")]
  .filter((text) => text.offsetParent && text.scrollWidth > text.clientWidth + 1
    && getComputedStyle(text).overflow !== "visible")
  .map((text) => text.textContent)"""


def test_nothing_is_cut_in_a_narrow_window_nor_hidden_in_a_wide_one_after_it(visit):
    one = visit("", width=400)
    for width in (400, 640, 1024):
        if width > 400:
            one.page.set_viewport_size({"width": width, "height": 800})
            one.go("")
        one.page.wait_for_function(FITS, arg=width)
        assert one.page.evaluate(CUT) == [], width
    wide = visit("")  # of the same browser
    expect(wide.keyed("alpha")).to_be_in_viewport()


def test_each_page_is_one_step_of_the_history_wherever_it_began(visit):
    for start, titles in (
        ("", ["Timeline", "Encounters", "Saliency", "Stability"]),
        ("overview", ["Encounters", "Saliency"]),
    ):
        one = visit(start)
        length = one.page.evaluate("history.length")
        assert one.page.evaluate("navigation.currentEntry.index") == 1  # after the empty window
        for title in titles:
            one.switch_to(title)
        assert one.page.evaluate("history.length") == length + len(titles)
        for title in [*titles[-2::-1], "Overview"]:
            one.page.go_back()
            expect(one.heading(title, level=1)).to_be_visible()
            one.wait_until_drawn()
        one.page.go_forward()
        expect(one.heading(titles[0], level=1)).to_be_visible()


def test_whoever_follows_the_link_after_a_swap_sees_the_same_comparison(visit):
    one = visit("data")
    one.keyed("sidebar_swap").get_by_role("button").click()
    expect(one.page).to_have_url(re.compile("x=NIR&y=FIR"))
    one.wait_until_drawn()
    other = visit(f"overview{one.page.url[one.page.url.index('?') :]}")
    expect(other.page.get_by_text("X: NIR").first).to_be_visible()


ADDRESSED_ENCOUNTER = "new URL(location).searchParams.get('encounter')"


def test_keys_step_through_the_encounters_and_back_returns_to_each(visit):
    one = visit("encounters?category=x_only")

    def is_at(number: int) -> None:
        place = one.keyed("encounters_review").get_by_text(f"{number} of 8", exact=True)
        expect(place).to_be_visible()
        one.wait_until_drawn()

    is_at(1)
    seen = []
    for number in (2, 3):
        one.page.keyboard.press("n")
        is_at(number)
        seen.append(one.page.evaluate(ADDRESSED_ENCOUNTER))
    one.page.get_by_role("button", name="Show in timeline").click()
    expect(one.heading("Timeline", level=1)).to_be_visible()
    expect(one.page).to_have_title(re.compile(r" s · FIR/NIR · nvcore$"))
    one.wait_until_drawn()
    one.page.go_back()
    expect(one.page).to_have_title("Encounters · FIR/NIR · nvcore")
    is_at(3)
    one.page.go_back()
    is_at(2)
    assert one.page.evaluate(ADDRESSED_ENCOUNTER) == seen[0]
    one.query("category", "x_only")


def test_the_menu_is_three_keys_away_and_its_focus_has_a_ring(visit):
    one = visit("timeline")
    one.page.keyboard.press("Tab")
    expect(one.page.get_by_role("link", name="Skip to main content")).to_be_focused()
    one.page.keyboard.press("Enter")
    one.page.keyboard.press("Tab")
    first = one.keyed("navigation").get_by_role("link").first
    expect(first).to_be_focused()
    expect(first).to_have_css("outline-style", "solid")
    current = one.keyed("navigation").get_by_role("link", name="Timeline")
    expect(current).to_have_css("outline-style", "none")
