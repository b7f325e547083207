"""The Timeline page of the sample in a real browser: links, keys, clicks, parameters."""

from __future__ import annotations

import re

import pytest
from app_server import ROOT
from app_visit import SHARE
from playwright.sync_api import Locator, expect

from nvcore.comparison import compare
from nvcore.inputs.load import load
from nvcore.inputs.session_toml import read_session
from nvcore.tables.moments import next_misses

LINK = "timeline?alpha=0.4&recording=rural_child&frame=57"
RECORDING = 4  # rural_child is the fifth of the sample
LAST_FRAME = 299
ANY_TRACE = ".js-line"
ANY_OTHER_LINE = """([key, line, before]) =>
  [...document.querySelectorAll(`.st-key-${key} ${line}`)]
    .some(one => !before.includes(one.getAttribute("d")))"""


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


def test_a_link_opens_cold_at_its_frame_and_parameters(visit):
    one = visit(LINK)
    one.shows(57)
    one.panel_shows(57)
    expect(one.slider("alpha")).to_have_value("0.4")
    expect(one.page.get_by_role("combobox", name="Recording")).to_have_value("rural_child")
    for name, value in (("alpha", "0.4"), ("recording", "rural_child"), ("frame", "57")):
        one.query(name, value)


def test_a_link_that_cannot_be_followed_says_so_and_the_app_lives_on(visit):
    one = visit("timeline?recording=nowhere&frame=abc&alpha=7")
    alert = one.page.get_by_role("alert")
    expect(alert).to_contain_text("there is no such recording in what is open")
    expect(alert).to_contain_text("its frame is no number")
    expect(alert).to_contain_text("its value of alpha is not possible")
    one.shows(0)
    expect(one.slider("alpha")).to_have_value("0.9")


def test_an_alpha_moved_by_key_changes_the_painted_traces(visit):
    one = visit(LINK)
    plot = one.keyed(f"time_plot_{RECORDING}")
    expect(plot.locator(ANY_TRACE).first).to_be_attached()
    before = painted_lines(plot)
    one.slider("alpha").press("ArrowRight")
    expect(one.slider("alpha")).to_have_value("0.45")
    one.page.wait_for_function(ANY_OTHER_LINE, arg=[f"time_plot_{RECORDING}", ANY_TRACE, before])
    one.query("alpha", "0.45")
    one.shows(57)


def test_a_click_in_the_time_plot_moves_the_frame(visit):
    one = visit(LINK)
    one.shows(57)
    one.click_plot(f"time_plot_{RECORDING}", SHARE, [0.5, 0.5])
    one.shows(re.compile("^1[45][0-9]$"))
    frame = int(one.viewer.get_attribute("data-frame") or "")
    assert 140 <= frame < 160
    one.panel_shows(frame)
    one.query("frame", str(frame))


def test_a_click_in_a_lane_moves_the_frame(visit):
    one = visit(LINK)
    one.shows(57)
    one.click_plot(f"lanes_{RECORDING}", SHARE, [0.75, 0.3])
    one.shows(re.compile("^2[0-9][0-9]$"))
    frame = int(one.viewer.get_attribute("data-frame") or "")
    assert 200 <= frame < 300
    one.panel_shows(frame)


def test_n_lands_on_the_next_miss(visit, misses):
    first = next(row for row in misses if row > 57)
    one = visit(LINK)
    one.shows(57)
    one.page.keyboard.press("n")  # the viewer needs no click before
    one.shows(first)
    one.panel_shows(first)
    expect(one.page.get_by_text("Missed, the tallest first")).to_be_visible()


def test_arrows_in_a_table_leave_the_frame_alone(visit):
    one = visit(LINK)
    one.panel_shows(57)
    one.page.get_by_test_id("stDataFrame").first.click()
    one.page.keyboard.press("ArrowRight")
    one.page.keyboard.press("n")
    expect(one.viewer).to_have_attribute("data-row", "57")


def test_keys_work_after_a_click_on_the_page(visit, misses):
    one = visit(LINK)
    one.shows(57)
    one.heading("Timeline", level=1).click()
    one.page.keyboard.press("ArrowRight")
    expect(one.viewer).to_have_attribute("data-row", "58")
    one.slider("alpha").press("n")
    first = next(row for row in misses if row > 58)
    expect(one.viewer).to_have_attribute("data-row", str(first))
    expect(one.slider("alpha")).to_have_value("0.4")


def test_the_frame_is_kept_on_the_way_through_other_pages(visit):
    one = visit(LINK)
    one.shows(57)
    one.viewer.press("ArrowRight")
    one.panel_shows(58)
    one.switch_to("Saliency")
    one.switch_to("Timeline")
    one.shows(58)
    expect(one.slider("alpha")).to_have_value("0.4")


def test_a_frame_is_given_to_the_token_of_a_living_session_only(visit):
    one = visit(LINK)
    one.shows(57)
    token, version = one.page.evaluate(
        """() => performance.getEntriesByType("resource")
             .map(one => one.name.match(new RegExp("/nv/([^/]+)/frame/4/57[.]jpg[?](.*)$")))
             .filter(Boolean)[0].slice(1)"""
    )
    request = one.page.request
    own = request.get(f"{one.address}/nv/{token}/frame/4/57.jpg?{version}")
    assert own.status == 200
    assert own.headers["content-type"] == "image/jpeg"
    for other in (token[:-1], token[::-1], "x" * len(token)):
        foreign = request.get(f"{one.address}/nv/{other}/frame/4/57.jpg?{version}")
        assert foreign.status == 404
        assert foreign.headers["content-type"].startswith("text/plain")
        assert request.get(f"{one.address}/nv/{other}/boxes/4/0").status == 404


def test_the_paper_s_upright_plot_is_a_switch_away(visit):
    one = visit(LINK)
    plot = one.keyed(f"time_plot_{RECORDING}")
    expect(plot.locator(".xtitle")).to_have_text("time (s)")
    one.page.get_by_text("Time upwards, X left and Y right").click()
    expect(plot.locator(".ytitle").first).to_have_text("time (s)")
