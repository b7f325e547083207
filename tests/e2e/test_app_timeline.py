"""The Timeline page of the sample in a real browser: links, keys, clicks, parameters."""

from __future__ import annotations

import re

import pytest
from app_server import ROOT
from app_visit import IS_STILL, SHARE, SIZE, Visit
from playwright.sync_api import Locator, expect

from nvcore.comparison import compare
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
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


def test_an_alpha_moved_by_key_changes_the_painted_traces(timeline):
    key = f"time_plot_{RECORDING}"
    plot = timeline.keyed(key)
    frame, alpha = frame_of(timeline), float(timeline.slider("alpha").input_value())
    expect(plot.locator(ANY_TRACE).first).to_be_attached()
    before = painted_lines(plot)
    timeline.slider("alpha").press("ArrowRight")
    expect(timeline.slider("alpha")).to_have_value(f"{alpha + 0.05:g}")
    timeline.page.wait_for_function(ANY_OTHER_LINE, arg=[key, ANY_TRACE, before])
    timeline.query("alpha", f"{alpha + 0.05:g}")
    timeline.shows(frame)


@pytest.mark.parametrize(
    ("plot", "place", "frames"),
    [("time_plot", [0.5, 0.5], range(140, 160)), ("lanes", [0.75, 0.3], range(200, 300))],
    ids=["time plot", "lanes"],
)
def test_a_click_in_a_plot_moves_the_frame(timeline, plot, place, frames):
    timeline.click_plot(f"{plot}_{RECORDING}", SHARE, place)
    timeline.shows(re.compile(f"^({'|'.join(map(str, frames))})$"))
    timeline.panel_shows(frame_of(timeline))
    timeline.query("frame", str(frame_of(timeline)))


def test_a_second_click_on_a_point_acts_like_the_first(timeline):
    key, place = f"lanes_{RECORDING}", [0.55, 0.3]
    timeline.viewer.press("Home")
    timeline.panel_shows(0)
    timeline.click_plot(key, SHARE, place)
    timeline.shows(re.compile("^1[0-9][0-9]$"))
    frame = frame_of(timeline)
    timeline.panel_shows(frame)
    for _ in range(2):
        timeline.viewer.press("Home")
        timeline.panel_shows(0)
        timeline.click_plot(key, SHARE, place)
        timeline.panel_shows(frame)


def test_a_click_counts_where_it_is_made_however_fast_the_mouse_came(timeline):
    timeline.viewer.press("Home")
    timeline.panel_shows(0)
    key = f"time_plot_{RECORDING}"
    timeline.listening_plot(key)
    timeline.keyed(key).evaluate(MOVE_AND_CLICK, [[0.2, 0.5], [0.8, 0.5]])
    timeline.shows(re.compile("^2[34][0-9]$"))
    timeline.panel_shows(frame_of(timeline))


def test_a_touch_acts_like_a_click(timeline):
    timeline.viewer.press("Home")
    timeline.panel_shows(0)
    box = timeline.listening_plot(f"time_plot_{RECORDING}").bounding_box()
    finger = {"x": box["x"] + 0.8 * box["width"], "y": box["y"] + 0.5 * box["height"]}
    screen = timeline.page.context.new_cdp_session(timeline.page)
    for kind, fingers in (("touchStart", [finger]), ("touchEnd", [])):
        screen.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": fingers})
    timeline.shows(re.compile("^2[34][0-9]$"))
    timeline.panel_shows(frame_of(timeline))


def test_the_figures_over_time_mark_the_frame_without_being_drawn_anew(timeline):
    timeline.viewer.press("Home")
    timeline.panel_shows(0)
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


def test_arrow_keys_go_from_point_to_point_of_a_figure_and_enter_clicks(timeline):
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


@pytest.mark.parametrize(("width", "share"), [(1024, 0.7), (1280, 0.8)])
def test_what_a_click_in_a_plot_moves_is_in_sight_and_can_be_closed(timeline, width, share):
    page = timeline.page
    page.set_viewport_size({"width": width, "height": 800})
    timeline.viewer.press("Home")
    timeline.panel_shows(0)
    timeline.wait_until_drawn()  # until then there may be an old plot beside the new one
    timeline.keyed(f"lanes_{RECORDING}").evaluate("plot => plot.scrollIntoView({block: 'end'})")
    expect(timeline.viewer).to_have_attribute("data-docked", "true")
    timeline.click_plot(f"lanes_{RECORDING}", SHARE, [share, 0.3])
    timeline.shows(re.compile("^2[0-9][0-9]$"))
    expect(timeline.viewer.locator("canvas.picture")).to_be_in_viewport(ratio=1)
    expect(timeline.viewer.locator(".readout .frame")).to_be_in_viewport(ratio=1)
    timeline.viewer.get_by_role("button", name="Close the small viewer").click()
    expect(timeline.viewer.locator("canvas.picture")).not_to_be_in_viewport()
    timeline.heading("Timeline", level=1).scroll_into_view_if_needed()
    expect(timeline.viewer).to_have_attribute("data-docked", "false")
    timeline.wait_until_drawn()
    timeline.keyed(f"lanes_{RECORDING}").evaluate("plot => plot.scrollIntoView({block: 'end'})")
    timeline.viewer.get_by_role("button", name="Back to the large picture").click()
    expect(timeline.viewer).to_have_attribute("data-docked", "false")
    expect(timeline.viewer.locator("canvas.picture")).to_be_in_viewport(ratio=0.9)
    page.set_viewport_size(SIZE)


GROUND_OF = "of => getComputedStyle(of).backgroundColor"


def test_a_switch_shows_its_state_where_colours_are_forced(timeline):
    timeline.page.emulate_media(forced_colors="active")
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


def test_a_slider_acts_while_it_is_dragged(timeline):
    timeline.wait_until_drawn()
    key = f"time_plot_{RECORDING}"
    slider = timeline.slider("alpha")
    before = slider.input_value()
    lines = painted_lines(timeline.keyed(key))
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


def test_keys_work_after_a_click_on_the_page(timeline, misses):
    timeline.viewer.press("Home")
    timeline.panel_shows(0)
    timeline.heading("Timeline", level=1).click()
    timeline.page.keyboard.press("n")
    timeline.shows(misses[0])
    timeline.panel_shows(misses[0])
    expect(timeline.page.get_by_text("Pedestrians by term")).to_be_visible()
    alpha = timeline.slider("alpha").input_value()
    timeline.slider("alpha").press("n")
    timeline.shows(misses[1])
    timeline.panel_shows(misses[1])
    expect(timeline.slider("alpha")).to_have_value(alpha)


def test_arrows_in_a_table_leave_the_frame_alone(timeline):
    frame = frame_of(timeline)
    timeline.panel_shows(frame)
    timeline.wait_until_drawn()
    cell = timeline.table("pedestrians").get_by_role("gridcell").first
    cell.click()
    expect(cell).to_be_focused()
    timeline.page.keyboard.press("ArrowRight")
    timeline.page.keyboard.press("n")
    expect(timeline.viewer).to_have_attribute("data-frame", str(frame))


def test_the_frame_is_kept_on_the_way_through_other_pages(timeline):
    timeline.viewer.press("Home")
    timeline.viewer.press("ArrowRight")
    timeline.panel_shows(1)
    alpha = timeline.slider("alpha").input_value()
    timeline.switch_to("Saliency")
    timeline.switch_to("Timeline")
    timeline.shows(1)
    expect(timeline.slider("alpha")).to_have_value(alpha)


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
