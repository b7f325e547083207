"""Detectors in a real browser: a model is sent, tried, looked into, run, and compared."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import small_icf
from playwright.sync_api import expect

# Place of a box that counts, by its rank, and its row and score.
BOX = """(plot, rank) => {
  const { _fullData, _fullLayout: { xaxis, yaxis } } = plot;
  const { x, y, text } = _fullData.find(one => one.name === "counting");
  return [xaxis.d2p(x[rank]), yaxis.d2p(y[rank]), text[rank]];
}"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return small_icf.write(tmp_path_factory.mktemp("model") / "bars.npz")


def test_a_model_is_tried_run_and_compared(visit, model):
    one = visit("detectors?recording=urban_crossing&frame=120")
    one.page.get_by_text("A model of your own").click()
    one.page.locator("input[type=file]").set_input_files(model)
    expect(one.page.get_by_text("16 trees over windows of 16 × 32 px")).to_be_visible()
    one.wait_until_drawn()

    # tried: the threshold moves the numbers, a click chooses a box
    metric = one.page.get_by_test_id("stMetric").filter(has_text="After")
    after = metric.get_by_test_id("stMetricValue")
    expect(after).not_to_have_text("0")
    one.slider("Threshold").press("End")
    expect(after).to_have_text("0")
    one.slider("Threshold").press("Home")
    expect(after).not_to_have_text("0")
    one.page.get_by_text("One window", exact=True).click()
    expect(one.page.get_by_text("a click in the picture above")).to_be_visible()
    *_, text = one.click_plot("detector_boxes", BOX, 0)
    score = re.match(r"score (\S+),", text)[1]
    expect(one.page.get_by_text(f"The box with the score {score}")).to_be_visible()

    # run over all recordings that it has not seen, and cancelled
    one.wait_until_drawn()
    one.page.get_by_role("button", name="How long will it take?").click()
    expect(
        one.page.get_by_text(re.compile("2,700 pictures of 9 recordings on .*: about"))
    ).to_be_visible()
    one.page.get_by_role("button", name="Run the detector").click()
    expect(
        one.page.get_by_text(re.compile(r"Running bars: .* of 2,700 pictures, .* left"))
    ).to_be_visible()
    one.page.get_by_role("button", name="Cancel").click()
    expect(one.page.get_by_text("Cancelled. No run was made.")).to_be_visible()

    # run over one of them, and compared
    tags = one.page.get_by_role("combobox", name="Only recordings tagged")
    tags.fill("village")
    tags.press("Enter")
    tags.press("Escape")
    expect(one.page.get_by_text("1 of 10 recordings")).to_be_visible()
    one.wait_until_drawn()
    one.page.get_by_role("button", name="How long will it take?").click()
    one.page.get_by_role("button", name="Run the detector").click()
    expect(one.page.get_by_text("in 300 pictures of 1 recording")).to_be_visible()
    one.page.get_by_role("button", name="Compare with FIR").click()
    expect(one.heading("Overview", level=1)).to_be_visible()
    expect(one.keyed("verdict")).to_contain_text("1 recording, 300 frames")
    expect(one.keyed("systems")).to_contain_text("bars")
    one.switch_to("Timeline")
    one.shows(re.compile("[0-9]+"))
