"""The Timeline page of the sample in a real browser: links, keys, clicks, parameters."""

from __future__ import annotations

import re

import pytest
from app_server import ROOT
from app_visit import IS_STILL, SHARE, SIZE, Visit
from playwright.sync_api import Locator, expect

from nvcore.comparison.compare import compare
from nvcore.inputs.load import load
from nvcore.inputs.session.toml import read_session
from nvcore.tables.moments import next_misses

LINK = "timeline?alpha=0.4&recording=rural_child&frame=57"
RECORDING = 4  # rural_child is the fifth of the sample
ANY_TRACE = ".js-line"
ANY_OTHER_LINE = """([key, line, before]) =>
  [...document.querySelectorAll(`.st-key-${key} ${line}`)]
    .some(one => !before.includes(one.getAttribute("d")))"""

# The mouse comes from one place to another and clicks there, all at once.
MOVE_AND_CLICK = """(figure, places) => {
  const area = figure.querySelector(".nsewdrag");
  const { left, top, width, height } = area.getBoundingClientRect();
  const send = (kind, [across, down]) => {
    const [clientX, clientY] = [left + across * width, top + down * height];
    const to = kind === "mouseup" ? document.elementFromPoint(clientX, clientY) : area;
    to.dispatchEvent(new MouseEvent(kind, { bubbles: true, clientX, clientY }));
  };
  places.forEach((place) => send("mousemove", place));
  send("mousedown", places.at(-1));
  send("mouseup", places.at(-1));
}"""

# The line of the frame is so far along the time that the recording takes: near its start or end.
IS_MARKED = """([figure, share]) => {
  const plot = figure.querySelector(".js-plotly-plot");
  const line = plot.querySelector(".nv-cursor")?.getBoundingClientRect();
  const { l, w } = plot._fullLayout._size;
  return line && Math.abs((line.left - plot.getBoundingClientRect().left - l) / w - share) < 0.02;
}"""

# The middle of a slider's handle: its field lies in it.
THUMB = """field => {
  const { left, top, width, height } = field.parentElement.getBoundingClientRect();
  return [left + width / 2, top + height / 2];
}"""

# Between the upper edges of the viewer and of its picture, px.
HEIGHT_ABOVE = """stage => stage.getBoundingClientRect().top
  - stage.closest(".viewer").getBoundingClientRect().top"""

# Mean red, green and blue of a small part of the picture, at these shares of its size.
MEAN_COLOUR = """(canvas, [across, down]) => {
  const [w, h] = [canvas.width, canvas.height];
  const part = canvas.getContext("2d").getImageData(across * w - 8, down * h - 8, 16, 16).data;
  return [0, 1, 2].map(i => part.filter((_, at) => at % 4 === i).reduce((a, b) => a + b) / 256);
}"""
IS_PURPLE = f"""([canvas, place, isSo]) => {{
  const [red, green, blue] = ({MEAN_COLOUR})(canvas, place);
  return (blue - green > 30 && red - green > 15) === isSo;
}}"""


def painted_lines(plot: Locator) -> list[str]:
    """The lines of a plot as they are painted."""
    paths: list[str] = plot.locator(ANY_TRACE).evaluate_all(
        "all => all.map(one => one.getAttribute('d'))"
    )
    return paths


@pytest.fixture(scope="module")
def misses() -> list[int]:
    """Rows of the recording where a miss starts, from the library."""
    result = compare(load(read_session(ROOT / "sample_data" / "session.toml")))
    return [int(row) for row in next_misses(result, RECORDING)]


@pytest.fixture
def timeline(shared) -> Visit:
    """The page, wherever the last test left it."""
    visit: Visit = shared(LINK)
    visit.shows(re.compile("^[0-9]+$"))
    return visit


def frame_of(timeline: Visit) -> int:
    return int(timeline.viewer.get_attribute("data-frame") or "")


def go_home(timeline: Visit) -> None:
    timeline.viewer.press("Home")
    timeline.panel_shows(0)


def test_the_traces_follow_alpha_by_key_and_while_it_is_dragged(timeline):
    key = f"time_plot_{RECORDING}"
    plot, slider = timeline.keyed(key), timeline.slider("alpha")
    frame, alpha = frame_of(timeline), float(slider.input_value())
    expect(plot.locator(ANY_TRACE).first).to_be_attached()
    lines = painted_lines(plot)
    slider.press("ArrowRight")
    expect(slider).to_have_value(f"{alpha + 0.05:g}")
    timeline.page.wait_for_function(ANY_OTHER_LINE, arg=[key, ANY_TRACE, lines])
    timeline.query("alpha", f"{alpha + 0.05:g}")
    timeline.shows(frame)

    timeline.wait_until_drawn()
    before, lines = slider.input_value(), painted_lines(plot)
    track = timeline.keyed("alpha").get_by_test_id("stSlider").bounding_box()
    thumb = slider.evaluate(THUMB)
    timeline.page.mouse.move(*thumb)
    timeline.page.mouse.down()
    for share in (0.5, 0.4, 0.3):
        timeline.page.mouse.move(track["x"] + share * track["width"], thumb[1], steps=3)
    # the button is still down
    timeline.page.wait_for_function(ANY_OTHER_LINE, arg=[key, ANY_TRACE, lines])
    moved = slider.input_value()
    assert moved != before
    timeline.query("alpha", moved)
    timeline.page.mouse.up()
    timeline.wait_until_drawn()
    expect(slider).to_have_value(moved)
    timeline.query("alpha", moved)


def test_a_click_or_a_touch_in_a_plot_moves_the_frame_each_time(timeline):
    lanes, time_plot = f"lanes_{RECORDING}", f"time_plot_{RECORDING}"
    timeline.click_plot(time_plot, SHARE, [0.5, 0.5])
    timeline.shows(re.compile("^1[45][0-9]$"))
    timeline.panel_shows(frame_of(timeline))
    timeline.query("frame", str(frame_of(timeline)))
    timeline.click_plot(lanes, SHARE, [0.75, 0.3])
    timeline.shows(re.compile("^2[0-9][0-9]$"))
    timeline.panel_shows(frame_of(timeline))
    timeline.query("frame", str(frame_of(timeline)))

    # a second and a third click on a point act like the first
    frames = []
    for _ in range(3):
        go_home(timeline)
        timeline.click_plot(lanes, SHARE, [0.55, 0.3])
        timeline.shows(re.compile("^1[0-9][0-9]$"))
        frames.append(frame_of(timeline))
        timeline.panel_shows(frames[0])
    assert frames == [frames[0]] * 3

    # a click counts where it is made, however fast the mouse came
    go_home(timeline)
    timeline.listening_plot(time_plot)
    timeline.keyed(time_plot).evaluate(MOVE_AND_CLICK, [[0.2, 0.5], [0.8, 0.5]])
    timeline.shows(re.compile("^2[34][0-9]$"))
    timeline.panel_shows(frame_of(timeline))

    # a touch acts like a click
    go_home(timeline)
    box = timeline.listening_plot(time_plot).bounding_box()
    finger = {"x": box["x"] + 0.8 * box["width"], "y": box["y"] + 0.5 * box["height"]}
    screen = timeline.page.context.new_cdp_session(timeline.page)
    for kind, fingers in (("touchStart", [finger]), ("touchEnd", [])):
        screen.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})
    timeline.shows(re.compile("^2[34][0-9]$"))
    timeline.panel_shows(frame_of(timeline))


def test_figures_mark_the_frame_without_being_drawn_anew_and_are_walked_through_by_keys(timeline):
    go_home(timeline)
    timeline.wait_until_drawn()
    plots = [timeline.keyed(f"{name}_{RECORDING}") for name in ("time_plot", "lanes")]
    drawn = [plot.locator(".js-plotly-plot").element_handle() for plot in plots]
    for key, share in (("End", 1), ("Home", 0)):
        timeline.viewer.press(key)
        for plot in plots:
            timeline.page.wait_for_function(IS_MARKED, arg=[plot.element_handle(), share])
        timeline.panel_shows(frame_of(timeline))
        timeline.wait_until_drawn()
    assert all(plot.evaluate("plot => plot.isConnected") for plot in drawn)

    # arrow keys go from point to point, and Enter clicks
    plot = timeline.keyed(f"lanes_{RECORDING}").locator(".js-plotly-plot")
    expect(plot).to_have_attribute("tabindex", "0")
    plot.press("Home")
    expect(plot.locator(".nv-mark")).to_be_visible()
    said = timeline.page.locator(".nv-says")
    for key in ("ArrowRight", "End", "ArrowLeft"):
        timeline.wait_until_drawn()
        before = said.inner_text()
        plot.press(key)
        expect(said).not_to_have_text(before)
        frame = int(re.search(r"frame (\d+)", said.inner_text())[1])
        plot.press("Enter")
        timeline.panel_shows(frame)


def test_what_a_click_in_a_plot_moves_is_in_sight_and_can_be_closed(timeline):
    viewer, lanes = timeline.viewer, f"lanes_{RECORDING}"
    picture = viewer.locator("canvas.picture")

    def scroll_to_lanes() -> None:
        timeline.wait_until_drawn()  # until then there may be an old plot beside the new one
        timeline.keyed(lanes).evaluate("plot => plot.scrollIntoView({block: 'end'})")

    for width, share in ((1024, 0.7), (SIZE["width"], 0.8)):
        timeline.page.set_viewport_size({**SIZE, "width": width})
        go_home(timeline)
        scroll_to_lanes()
        expect(viewer).to_have_attribute("data-docked", "true")
        timeline.click_plot(lanes, SHARE, [share, 0.3])
        timeline.shows(re.compile("^2[0-9][0-9]$"))
        expect(picture).to_be_in_viewport(ratio=1)
        expect(viewer.locator(".readout .frame")).to_be_in_viewport(ratio=1)
        viewer.get_by_role("button", name="Close the small viewer").click()
        expect(picture).not_to_be_in_viewport()
        timeline.heading("Timeline", level=1).scroll_into_view_if_needed()
        expect(viewer).to_have_attribute("data-docked", "false")
        scroll_to_lanes()
        viewer.get_by_role("button", name="Back to the large picture").click()
        expect(viewer).to_have_attribute("data-docked", "false")
        expect(picture).to_be_in_viewport(ratio=0.9)


GROUND_OF = "of => getComputedStyle(of).backgroundColor"


def test_switches_and_sliders_can_be_seen_where_colours_are_forced(timeline):
    timeline.page.emulate_media(forced_colors="active")
    track = timeline.keyed("alpha").locator("[data-testid=stSlider] [role=group] > div > div")
    expect(track.first).to_have_css("outline-style", "solid")
    switch = timeline.keyed("lanes_missed").locator("label")
    grounds = []
    for is_on in (False, True):
        if is_on:
            switch.click()
        expect(switch.locator("input")).to_be_checked(checked=is_on)
        timeline.wait_until_drawn()
        track = switch.locator("div:has(> div:empty)")
        expect(track).to_have_css("outline-style", "solid")
        timeline.page.wait_for_function(IS_STILL)
        grounds.append((track.evaluate(GROUND_OF), track.locator("div").evaluate(GROUND_OF)))
    switch.click()
    timeline.page.emulate_media(forced_colors="none")
    assert all(ground != knob for ground, knob in grounds)
    assert grounds[0] != grounds[1]


def test_keys_are_the_viewer_s_but_in_tables_and_the_frame_outlives_other_pages(timeline, misses):
    slider = timeline.slider("alpha")
    alpha = slider.input_value()
    go_home(timeline)
    timeline.heading("Timeline", level=1).click()
    timeline.page.keyboard.press("n")
    timeline.shows(misses[0])
    timeline.panel_shows(misses[0])
    expect(timeline.page.get_by_text("Pedestrians by term")).to_be_visible()
    slider.press("n")
    timeline.shows(misses[1])
    timeline.panel_shows(misses[1])
    expect(slider).to_have_value(alpha)

    timeline.wait_until_drawn()
    cell = timeline.table("pedestrians").get_by_role("gridcell").first
    cell.click()
    expect(cell).to_be_focused()
    timeline.page.keyboard.press("ArrowRight")
    timeline.page.keyboard.press("n")
    expect(timeline.viewer).to_have_attribute("data-frame", str(misses[1]))

    timeline.switch_to("Saliency")
    timeline.switch_to("Timeline")
    timeline.shows(misses[1])
    expect(slider).to_have_value(alpha)


def test_what_a_miss_would_cost_is_laid_over_the_picture_by_key_and_follows_the_sliders(timeline):
    canvas = timeline.viewer.locator("canvas.picture")
    near, far = [0.5, 0.8], [0.5, 0.2]
    red, green, blue = canvas.evaluate(MEAN_COLOUR, near)
    assert max(red, green, blue) - min(red, green, blue) < 5  # a grey picture
    timeline.viewer.press("c")
    button = timeline.viewer.get_by_role("button", name="Cost of a miss, by place")
    expect(button).to_have_attribute("aria-pressed", "true")
    shown = canvas.element_handle()
    timeline.page.wait_for_function(IS_PURPLE, arg=[shown, near, True])
    sky = canvas.evaluate(MEAN_COLOUR, far)
    assert max(sky) - min(sky) < 5  # nobody stands there
    timeline.slider("Counts half at").press("End")  # now the near ones count little
    timeline.page.wait_for_function(IS_PURPLE, arg=[shown, near, False])
    timeline.viewer.press("c")
    expect(button).to_have_attribute("aria-pressed", "false")


@pytest.mark.parametrize("is_review", [False, True])
def test_the_controls_are_in_sight_without_scrolling(visit, is_review: bool):
    # X at 0.1 has more false alarms than Y: the switch of operating points stands above, too
    place = "data?threshold_x=0.1" if is_review else f"{LINK}&threshold_x=0.1"
    one = visit(place)
    if is_review:
        one.page.get_by_role("button", name=re.compile("^Show (all|the)")).first.click()
        one.table("entries_table_").get_by_role("rowheader").first.click()
        expect(one.heading("Timeline", level=1)).to_be_visible()
        expect(one.keyed("listed")).to_be_visible()
    one.wait_until_drawn()
    expect(one.keyed("operating_points")).to_be_visible()
    controls = one.viewer.get_by_role("toolbar", name="Transport")
    expect(controls).to_be_in_viewport(ratio=1)
    scrolled = one.page.get_by_test_id("stMain").evaluate("main => main.scrollTop")
    assert scrolled == 0
    one.viewer.press("n")  # the legend has other counts then
    one.wait_until_drawn()
    expect(controls).to_be_in_viewport(ratio=1)


def test_the_time_since_the_light_has_changed_moves_no_picture(visit):
    one = visit(f"{LINK}&picture=visible")
    expect(one.viewer).to_have_attribute("data-picture", "visible")

    def height_above() -> float:
        return one.viewer.locator(".stage").evaluate(HEIGHT_ABOVE)

    before = height_above()
    one.viewer.press("d")
    since = one.viewer.get_by_text(re.compile("after the change|not known|eyes adapted"))
    expect(since).to_be_visible()
    expect(one.page.get_by_role("button", name="A tunnel ends here")).to_be_visible()
    assert height_above() == before
