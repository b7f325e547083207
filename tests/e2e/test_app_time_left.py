"""Time left in a real browser: the speed moves the figures, a late moment opens in the Timeline."""

from __future__ import annotations

import re

from app_visit import FIRST_POINT
from playwright.sync_api import expect


def test_the_speed_is_moved_and_a_late_moment_opens(visit):
    one = visit("time_left")
    speed = one.slider("Assumed speed")
    expect(speed).to_have_value("50")
    headline = one.heading(re.compile("^Of 20 urgent encounters at 50"))
    expect(headline).to_be_visible()
    speed.press("ArrowRight")
    expect(one.heading(re.compile("^Of 21 urgent encounters at 55"))).to_be_visible()
    one.query("speed_kmh", "55")
    one.wait_until_drawn()
    *_, (row, _) = one.click_plot("time_left_approaches", FIRST_POINT, "Y: NIR confirms")
    expect(one.heading("Timeline", level=1)).to_be_visible()
    expect(one.recording_field("rural_road")).to_have_count(1)
    one.shows(225)  # Y is sure of pedestrian 4 with 0.6 s left
    assert row > 225  # of all recordings' frames
    one.panel_shows(225)
    expect(one.page.get_by_text("Pedestrian 4")).to_be_visible()
