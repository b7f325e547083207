"""Alerts in a real browser: the policy's slider makes a nuisance, which opens in the Timeline."""

from __future__ import annotations

import re

from app_visit import FIRST_POINT
from playwright.sync_api import expect


def test_a_policy_moved_by_its_slider_gives_a_nuisance_that_opens_in_the_timeline(visit):
    one = visit("alerts?recording=urban_crossing")
    one.page.get_by_role("button", name="Cautious").click()
    kinds = one.keyed("alerts_kind")
    expect(kinds).to_be_visible()
    expect(kinds.get_by_text(re.compile("^nuisance"))).to_have_count(0)
    one.page.get_by_role("button", name="Eager").click()
    expect(kinds.get_by_text(re.compile("^nuisance"))).to_be_visible()
    few = kinds.get_by_text(re.compile("^nuisance")).inner_text()
    nearness = one.slider("Alert from (proximity weight)")
    expect(nearness).to_have_value("0.25")
    one.wait_until_drawn()
    nearness.press("Home")
    one.query("alert_k", "0")
    expect(kinds.get_by_text(few, exact=True)).to_have_count(0)
    kinds.get_by_text(re.compile("^nuisance")).click()
    alerts = one.table("alerts_list")
    others = alerts.locator("tbody.rows tr").filter(has_not_text="nuisance")
    expect(others).to_have_count(0)  # a click on rows that are replaced is not taken
    one.wait_until_drawn()
    alerts.get_by_role("rowheader").first.click()
    place = one.page.get_by_role("paragraph").filter(has_text=re.compile(r"^1 of \d+$"))
    expect(place).to_be_visible()  # among the alerts; the table says which of its rows, too
    one.switch_to("Timeline")
    plots = one.page.locator("[class*='st-key-alerts_over_time_']")
    (key,) = re.findall(r"st-key-(alerts_over_time_\d+)", plots.get_attribute("class") or "")
    *_, (_, encounter) = one.click_plot(key, FIRST_POINT, "X nuisance")
    assert encounter >= 0
    expect(one.page.get_by_text(re.compile(r"^Pedestrian \d+"))).to_be_visible()
