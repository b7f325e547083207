"""A slider that is dragged or moved by keys: what is painted meanwhile, and where it ends."""

from __future__ import annotations

import re

import numpy as np
import pytest
from app_visit import Visit
from playwright.sync_api import expect

# After each painted frame: alpha at its slider, mean similarity of X and of Y, alpha beside these,
# what the page says is being computed, and whether "As set" or the other comparison is chosen.
SAMPLE = """() => {
  window.painted = [];
  const after = new MessageChannel();
  after.port1.onmessage = () => {
    const first = document.querySelector(".nv-scorecard tbody tr");
    const cells = first ? [...first.querySelectorAll("td")].slice(0, 2) : [];
    const of = document.querySelector(".nv-wide:has(.nv-scorecard) .nv-of");
    const basis = document.querySelector("[class*=st-key-operating_point] [aria-checked=true]");
    const frame = JSON.stringify({
      slider: document.querySelector(".st-key-alpha input").value,
      numbers: cells.map(cell => cell.textContent).join(" "),
      beside: of?.textContent ?? "",
      computing: document.querySelector("[data-testid=stMain]").dataset.nvLate ?? "",
      basis: basis?.textContent ?? "",
    });
    if (painted.at(-1) !== frame) painted.push(frame);
  };
  (function look() { after.port2.postMessage(null); requestAnimationFrame(look); })();
}"""
STEPS = 8


def drag(one: Visit, share: float) -> None:
    """Move alpha by a share of its slider's length, step by step."""
    slider = one.keyed("alpha")
    slider.scroll_into_view_if_needed()
    length = slider.get_by_role("group").bounding_box()["width"]
    thumb = slider.locator("[style*='translate']").first.bounding_box()
    x, y = thumb["x"] + thumb["width"] / 2, thumb["y"] + thumb["height"] / 2
    one.page.mouse.move(x, y)
    one.page.mouse.down()
    for step in range(1, STEPS + 1):
        before = one.slider("alpha").input_value()
        one.page.mouse.move(x + share * length * step / STEPS, y)
        expect(one.slider("alpha")).not_to_have_value(before)
        if step == STEPS // 2:  # in the middle of it the page comes to rest
            expect(one.page.locator("[data-nv-late]")).to_have_count(0)


@pytest.mark.parametrize("thresholds", ["", "?threshold_x=0.3"])
def test_no_painted_number_is_of_another_setting_than_stands_beside_it(visit, thresholds):
    one = visit(thresholds)
    one.page.evaluate(SAMPLE)
    drag(one, -0.4)
    one.page.mouse.up()
    one.query("alpha", "0.5")
    expect(one.page.locator("[data-nv-late]")).to_have_count(0)
    one.wait_until_drawn()
    frames = one.page.evaluate("painted.map(JSON.parse)")
    expect(one.slider("alpha")).to_have_value("0.5")  # it was not thrown away

    settled = [frame for frame in frames if not frame["computing"]]
    of = {frame["slider"]: frame["numbers"] for frame in settled}
    assert {"0.9", "0.5"} < {*of}
    assert len({*of.values()}) == len(of)
    for frame in frames:
        beside = re.search(r"\(alpha\) ([\d.]+)", frame["beside"])
        alpha = beside[1] if beside else frame["slider"]
        if frame["numbers"] and alpha in of:
            assert frame["numbers"] == of[alpha], frame
        if alpha != frame["slider"]:
            assert f"(alpha) {frame['slider']}" in frame["computing"], frame
    assert len({frame["basis"] for frame in frames}) == 1  # the same comparison all the time


# At each change of the page, which parts are missing; at each painted frame, its height and scroll
# position. The browser's own scroll anchoring would hide a jump.
WATCH = """() => {
  const main = document.querySelector("[data-testid=stMain]");
  main.style.overflowAnchor = "none";
  window.seen = { missing: [], heights: [], tops: [] };
  const parts = [".nv-tiles", ".nv-scorecard"];
  const look = () => seen.missing.push(...parts.filter((part) => !main.querySelector(part)));
  new MutationObserver(look).observe(main, { childList: true, subtree: true });
  (function measure() {
    seen.heights.push(main.scrollHeight);
    seen.tops.push(main.scrollTop);
    requestAnimationFrame(measure);
  })();
  return main.querySelector(".nv-scorecard").getBoundingClientRect().height;
}"""


@pytest.mark.parametrize("part", ["", "all measures"])
def test_the_scorecard_stays_in_its_place_while_alpha_is_dragged(visit, part):
    one = visit("")
    if part:
        one.keyed("all_measures").locator("summary").click()
        one.wait_until_drawn()
    one.page.locator(".nv-scorecard").last.scroll_into_view_if_needed()
    height = one.page.evaluate(WATCH)
    for share in (-0.4, 0.4):
        drag(one, share)
        one.page.mouse.up()
        expect(one.page.locator("[data-nv-late]")).to_have_count(0)
        one.wait_until_drawn()
    seen = one.page.evaluate("seen")
    assert seen["missing"] == []
    for values in (seen["heights"], seen["tops"]):
        assert max(values) - min(values) < height / 4  # a sentence may take another line


def test_six_presses_are_six_steps(visit):
    one = visit("time_left")
    speed = one.slider("Assumed speed")
    speed.focus()
    for _ in range(6):
        one.page.keyboard.press("ArrowRight")
    one.query("speed_kmh", "80")
    one.wait_until_drawn()
    expect(speed).to_have_value("80")
    expect(one.heading(re.compile("urgent encounters at 80"))).to_be_visible()


# Points of a line of the time plot, and what the panel beside the viewer says of the frame.
TRACE = """() => {
  const plot = document.querySelector("[class*=st-key-time_plot_] .js-plotly-plot");
  const { uid } = plot._fullData.find(trace => trace.meta === "nv-raw-y");
  const line = plot.querySelector(`.trace${uid} path.js-line`);
  const numbers = line.getAttribute("d").match(/[\\d.]+/g).map(Number);
  const panel = document.querySelector(".nv-numbers [data-frame-value]").innerText;
  return { line: numbers, panel };
}"""


def apart(one: dict[str, list[float]], other: dict[str, list[float]]) -> float:
    """Farthest that a point of one line is from another line, px."""
    points, corners = (np.reshape(line["line"], (-1, 2)) for line in (one, other))
    start, way = corners[:-1], np.diff(corners, axis=0)
    to_point = points[:, None] - start
    along = np.clip((to_point * way).sum(2) / np.maximum((way**2).sum(1), 1e-9), 0, 1)
    from_line = np.linalg.norm(to_point - along[..., None] * way, axis=2)
    return float(from_line.min(1).max())


def test_trace_and_frame_follow_a_slider_and_are_then_those_of_the_server(visit):
    one = visit("timeline?recording=rural_road&frame=200")
    one.page.wait_for_function("() => window.nvcoreLive?.compare()")
    before = one.page.evaluate(TRACE)
    slider = one.keyed("midpoint")
    slider.scroll_into_view_if_needed()
    thumb = slider.locator("[style*='translate']").first.bounding_box()
    x, y = thumb["x"] + thumb["width"] / 2, thumb["y"] + thumb["height"] / 2
    one.page.mouse.move(x, y)
    one.page.mouse.down()
    one.page.mouse.move(x + 40, y)
    expect(one.page.locator("[data-nv-late]")).to_have_count(1)
    moving = one.page.evaluate(TRACE)
    assert moving["panel"] != before["panel"]
    one.page.mouse.up()
    expect(one.page.locator("[data-nv-late]")).to_have_count(0)
    one.wait_until_drawn()
    after = one.page.evaluate(TRACE)
    assert moving["panel"] == after["panel"]
    assert apart(moving, after) < 1
    assert apart(before, after) > 5
