"""Detection and Stability in a real browser: a click on a curve or a map sets the parameters."""

from __future__ import annotations

import re

from playwright.sync_api import expect

# Place in the window of a point of a plot's trace: [x, y, its customdata].
POINT = """([key, name, share]) => {
  const plot = document.querySelector(`${key} .js-plotly-plot`);
  const { _fullData, _fullLayout: layout } = plot;
  const trace = _fullData.find(one => one.name === name);
  const i = Math.floor(share * (trace.x.length - 1)), area = plot.getBoundingClientRect();
  const { l, t } = layout._size;
  return [area.x + l + layout.xaxis.d2p(trace.x[i]), area.y + t + layout.yaxis.d2p(trace.y[i]),
    [...[].concat(trace.customdata[i])]];
}"""


def test_a_click_on_a_curve_sets_the_threshold_of_its_system(visit):
    one = visit("detection")
    one.page.get_by_role("radio", name="Precision and recall").click()
    plot = one.keyed("curves_precision_recall")
    expect(plot.locator(".nsewdrag")).to_be_attached()
    one.wait_until_drawn()
    plot.scroll_into_view_if_needed()
    at = [".st-key-curves_precision_recall", "Y, points", 0.6]
    x, y, (letter, score) = one.page.evaluate(POINT, at)
    assert letter == "y"
    one.page.mouse.click(x, y)
    expect(one.page).to_have_url(re.compile("threshold_y="))
    expect(one.slider("Score threshold of X")).to_have_value("0.5")
    found = float(re.search(r"threshold_y=([\d.]+)", one.page.url)[1])
    assert abs(found - score) < 0.02  # the nearest point to the click


def test_a_click_on_a_map_takes_its_settings(visit):
    one = visit("stability")
    plot = one.keyed("stability_alpha-midpoint_similarity")
    expect(plot.locator(".nsewdrag")).to_be_attached()
    plot.scroll_into_view_if_needed()
    box = plot.locator(".nsewdrag").bounding_box()
    one.page.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 0.3 * box["height"])
    expect(one.page).to_have_url(re.compile("alpha="))
    one.wait_until_drawn()
    alpha = float(one.slider("alpha").input_value())
    assert 0.15 < alpha < 0.35
    expect(one.page.get_by_text("As analysed, Y has the higher mean similarity")).to_be_visible()
