"""A rating session in a real browser: a participant, a reload, and the conductor."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest
import viewer_scene as scene
from app_files import CLIP_FRAMES, RECORDING, send, write_files
from app_visit import Visit
from playwright.sync_api import BrowserContext, expect
from viewer_reading import READER

from nvcore.common.palette import X_COLOUR, Y_COLOUR

MOST_READINGS = 2_000
# how many pixels of the canvas have each of these colours
COUNT_COLOURS = """(canvas, colours) => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return colours.map(([r, g, b]) => {
    let n = 0;
    for (let i = 0; i < data.length; i += 4) {
      const off = Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b);
      if (off < 24) n += 1;
    }
    return n;
  });
}"""
# Asked at once: the clip is short.
PLAY_AGAIN = """viewer => {
  viewer.querySelector("button.starter").click();
  return viewer.dataset.playing;
}"""
COLOURS = [
    [int(colour[i : i + 2], 16) for i in (1, 3, 5)]
    for colour in ("#F2E205", X_COLOUR["dark"], Y_COLOUR["dark"])
]


@pytest.fixture(scope="module")
def app(short_app: str) -> str:
    """What is visited."""
    return short_app


@pytest.fixture(scope="module")
def links(person: BrowserContext, app: str) -> tuple[str, str]:
    """Pages of the participants and of the conductor of a session with two clips."""
    one = Visit(person, app)
    one.go("ratings")
    one.page.get_by_role("radio", name="Rating session").first.click()
    expect(one.heading("Start a rating session")).to_be_visible()
    expect(one.page.get_by_text("2 clips.")).to_be_visible()
    one.wait_until_drawn()  # a button that is drawn anew while it is clicked hears nothing
    one.keyed("rating_start").get_by_role("button").click()
    expect(one.heading("The rating session")).to_be_visible()
    codes = one.page.get_by_test_id("stCode").locator("code")
    expect(codes).to_have_count(2)
    study, conduct = (code.inner_text().strip().rpartition("/")[2] for code in codes.all())
    assert study.startswith("ratings?study=")
    assert conduct.startswith("ratings?conduct=")
    assert one.complaints == []
    one.close()
    return study, conduct


def begin(one: Visit, name: str) -> None:
    one.page.get_by_label("Your name").fill(name)
    one.page.get_by_text("I have read this and agree to take part").click()
    one.page.get_by_role("button", name="Begin").click()
    expect(one.heading("Clip 1 of 2")).to_be_visible()


def watch_and_rate(one: Visit, rating: int) -> None:
    scale = one.keyed("rating_scale")
    expect(one.page.get_by_role("button", name="Play the clip")).to_be_visible()
    expect(scale).to_have_count(0)
    one.page.get_by_role("button", name="Play the clip").click()
    expect(one.page.get_by_role("button", name="Play again")).to_be_visible()
    scale.get_by_role("button", name=str(rating), exact=True).click()


def test_a_reload_between_two_clips_loses_no_rating(visit, links, tmp_path: Path):
    study, conduct = links
    one = visit(study)
    expect(one.keyed("navigation")).to_have_count(0)
    expect(one.slider("alpha")).to_have_count(0)
    begin(one, "Ann")
    watch_and_rate(one, 6)
    expect(one.heading("Clip 2 of 2")).to_be_visible()
    one.page.reload()
    one.wait_until_drawn()
    expect(one.heading("Clip 2 of 2")).to_be_visible()
    watch_and_rate(one, 2)
    expect(one.heading("Thank you")).to_be_visible()

    conductor = visit(conduct)
    metrics = conductor.page.get_by_test_id("stMetric")
    expect(metrics.filter(has_text="ratings so far")).to_contain_text("2")
    with conductor.page.expect_download() as download:
        conductor.page.get_by_role("button", name="Ratings (CSV)").click()
    download.value.save_as(tmp_path / "ratings.csv")
    with (tmp_path / "ratings.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["participant"], row["clip"]) for row in rows] == [("Ann", RECORDING)] * 2
    assert sorted(row["system"] for row in rows) == ["camera_a", "camera_b"]
    assert sorted(row["rating"] for row in rows) == ["2", "6"]
    assert [row["n_plays"] for row in rows] == ["1", "1"]


def test_a_clip_shows_one_systems_boxes_tells_nothing_and_cannot_be_steered(visit, links):
    one = visit(links[0])
    begin(one, "Bob")
    canvas = one.viewer.locator("canvas.picture")
    expect(one.viewer).to_have_attribute("data-shown-row", "0")
    for key in ("ArrowRight", "End", "n", " "):
        one.page.keyboard.press(key)
    canvas.dblclick(position={"x": 20, "y": 20})
    expect(one.viewer).to_have_attribute("data-row", "0")
    one.page.get_by_role("button", name="Play the clip").click()
    again = one.page.get_by_role("button", name="Play again")
    readings = [canvas.evaluate(COUNT_COLOURS, COLOURS)]
    while again.count() == 0 and len(readings) < MOST_READINGS:
        readings.append(canvas.evaluate(COUNT_COLOURS, COLOURS))
    assert max(neutral for neutral, _, _ in readings) > 100
    assert max(max(x, y) for _, x, y in readings) < 10
    expect(again).to_be_visible()
    told = one.viewer.evaluate("viewer => viewer.outerHTML")
    assert [name for name in ("camera_a", "camera_b", "miss", "Ground truth") if name in told] == []
    assert one.viewer.evaluate(PLAY_AGAIN) == "true"
    expect(one.keyed("rating_scale")).to_be_visible()  # it was seen once


def test_own_files_are_rated_on_the_conductors_screen_also_after_a_reload(visit, tmp_path: Path):
    one = visit("data")
    send(one, write_files(tmp_path, CLIP_FRAMES))
    one.switch_to("Ratings")
    one.page.get_by_role("radio", name="Rating session").first.click()
    one.keyed("rating_start").get_by_role("button").click()
    one.keyed("rating_here").get_by_role("button").click()
    begin(one, "Eve")
    one.page.reload()  # at once: the address is there with the clip
    expect(one.heading("Clip 1 of 2")).to_be_visible()
    watch_and_rate(one, 3)
    expect(one.heading("Clip 2 of 2")).to_be_visible()
    one.page.reload()
    expect(one.heading("Clip 2 of 2")).to_be_visible()
    expect(one.viewer).to_have_attribute("data-shown-row", "0")
    assert one.viewer.evaluate(READER)["frame"] == scene.FIRST_FRAME  # their own pictures


def test_the_pages_have_no_accessibility_fault(visit, links):
    study, conduct = links
    faults = []
    for theme in ("light", "dark"):
        one = visit(study, theme=theme)
        faults += one.accessibility_faults()
        begin(one, f"Dan {theme}")
        expect(one.page.get_by_role("button", name="Play the clip")).to_be_visible()
        faults += one.accessibility_faults()
        one.go(conduct)
        faults += one.accessibility_faults()
    assert faults == []
