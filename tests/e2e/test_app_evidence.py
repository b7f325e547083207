"""Detection and Stability in a real browser: a click on a curve or a map sets the parameters."""

from __future__ import annotations

import re

from app_visit import SHARE
from playwright.sync_api import expect

# Place in the plot's area of a point of a trace: [x, y, its customdata].
POINT = """(plot, [name, share]) => {
  const { _fullData, _fullLayout: { xaxis, yaxis } } = plot;
  const trace = _fullData.find(one => one.name === name);
  const i = Math.floor(share * (trace.x.length - 1));
  return [xaxis.d2p(trace.x[i]), yaxis.d2p(trace.y[i]), [...[].concat(trace.customdata[i])]];
}"""


def test_a_click_on_a_map_takes_its_settings(shared):
    one = shared("stability")
    one.click_plot("stability_alpha-midpoint_similarity", SHARE, [0.25, 0.3])
    expect(one.page).to_have_url(re.compile("alpha="))
    expect(one.slider("alpha")).to_have_value(re.compile(r"^0\.(2|25|3)$"))
    # before the click it is 0.0189
    nearly_even = re.compile(r"As analysed, [XY] has the higher mean similarity, by 0\.00\d\d")
    expect(one.page.get_by_text(nearly_even)).to_be_visible()


def test_a_click_on_a_curve_sets_the_threshold_of_its_system(shared):
    one = shared("stability")
    one.switch_to("Detection")
    one.page.get_by_role("radio", name="Precision and recall").click()
    *_, (letter, score) = one.click_plot("curves_precision_recall", POINT, ["Y, points", 0.6])
    assert letter == "y"
    expect(one.page).to_have_url(re.compile("threshold_y="))
    expect(one.slider("Score threshold of X")).to_have_value("0.5")
    found = float(re.search(r"threshold_y=([\d.]+)", one.page.url)[1])
    assert abs(found - score) < 0.02  # the nearest point to the click
