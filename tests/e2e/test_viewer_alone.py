"""The frame viewer in a real browser, with made-up pictures whose frame number is in the pixels."""

from __future__ import annotations

import re

import pytest
import viewer_scene as scene
from axe_playwright_python.sync_playwright import Axe
from playwright import sync_api
from viewer_reading import is_whole
from viewer_window import choose, n_runs, painted, press, read, repaint, settled, viewer_of

# Where the picture lies on the canvas, in CSS pixels: left, top and scale.
PLACE = f"""canvas => {{
  const [w, h] = [canvas.clientWidth, canvas.clientHeight];
  const scale = Math.min(w / {scene.WIDTH}, h / {scene.HEIGHT});
  return [(w - {scene.WIDTH} * scale) / 2, (h - {scene.HEIGHT} * scale) / 2, scale];
}}"""
# Mean grey of a part of the picture without boxes.
GREY = f"""canvas => {{
  const [x, y, scale] = ({PLACE})(canvas);
  const ratio = canvas.width / canvas.clientWidth;
  const part = canvas.getContext("2d").getImageData(
    (x + 400 * scale) * ratio, (y + 420 * scale) * ratio, 20, 20).data;
  return part.filter((_, at) => at % 4 === 1).reduce((a, b) => a + b) / 400;
}}"""
# Opacity of the canvas's uppermost left pixel: nothing is painted beside the picture.
CORNER = """canvas => canvas.getContext("2d").getImageData(1, 1, 1, 1).data[3]"""
# Pixels in the colour of X's boxes.
N_BLUE = """canvas => {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let n = 0;
  for (let at = 0; at < data.length; at += 4) {
    if (data[at + 2] > 200 && data[at] < 130 && data[at + 2] - data[at] > 90) n += 1;
  }
  return n;
}"""


def says_no_picture(page) -> None:
    sync_api.expect(page.locator(".viewer .message")).to_have_text("No picture for this frame")


def has_box(page, row: int) -> None:
    """X's box is where it belongs in this row."""
    assert read(page)["box"] == pytest.approx(scene.x_of(row), abs=2.5)


def test_keys_and_buttons_move_to_a_frame_and_python_hears_of_it(page):
    # it opens on the row that Python names; names from files are text
    reading = read(page)
    assert reading["frame"] == scene.FIRST_FRAME + 5
    assert is_whole(reading)
    sync_api.expect(viewer_of(page)).to_have_attribute("data-frame", str(scene.FIRST_FRAME + 5))
    name = page.locator(".viewer .layer.x .name")
    sync_api.expect(name).to_have_text("X <img src=x onerror=alert(1)>")
    assert page.locator(".viewer img").count() == 0

    # buttons to misses say so, and seconds have buttons
    forward = page.get_by_role("button", name="Next miss")
    sync_api.expect(forward).to_have_text("miss")
    sync_api.expect(forward).to_have_attribute("title", "Next miss (n)")
    page.get_by_role("button", name="One second forward").click()
    assert painted(page, 25) == 25
    page.get_by_role("button", name="One second back").click()
    assert painted(page, 5) == 5

    # quick steps count from the requested frame
    press(page, *["ArrowRight"] * 30)
    assert painted(page, 35) == 35
    assert is_whole(read(page))

    last = scene.N_ROWS - 1
    for keys, row in (
        (["ArrowRight", "ArrowRight", "ArrowLeft"], 36),
        (["Shift+ArrowRight"], 56),  # one second
        (["End"], last),
        (["Home"], 0),
        (["n", "n"], scene.MISSED_BY_Y.start),
        (["p"], scene.MISSED_BY_X.start),
        # the server lacks the picture of this row
        (["n", "n", "Shift+ArrowRight", *["ArrowRight"] * 10], scene.LOST_PICTURE),
    ):
        press(page, *keys)
        assert painted(page, row) == row
        assert settled(page, row) == str(row)
        if row == last:  # which has no picture
            says_no_picture(page)
            has_box(page, row)
    says_no_picture(page)


def test_who_is_missed_by_whom_is_told_once_the_picture_is_there(page):
    row = scene.MISSED_BY_X.start
    waiting: list[sync_api.Route] = []
    late = re.compile(rf"/frame/0/{row}\.jpg")
    page.route(late, lambda route: waiting.append(route))
    with page.expect_request(late):  # after pictures that it was still asking for
        press(page, "n")
    assert settled(page, row) == str(row)
    said = page.locator(".viewer .spoken")
    sync_api.expect(said).to_have_text(f"Frame {scene.FIRST_FRAME + row}, 55.00 s")
    waiting[0].continue_()
    sync_api.expect(said).to_contain_text("X misses 1, Y misses 0, false alarms X 1, Y 1")
    page.unroute(late)

    # who is not detected but too far to count stands beside who is missed
    counts = page.locator(".viewer .counts")
    for text in ("1 near missed, 1 far, 1 false", "0 near missed, 1 far, 1 false"):
        sync_api.expect(counts.filter(has_text=text)).to_have_count(1)


def test_a_click_in_the_strip_seeks_and_dragging_tells_python_only_the_last_row(page):
    strip = page.locator(".viewer .strip")
    box = strip.bounding_box()
    strip.click(position={"x": box["width"] / 2, "y": 20})
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", re.compile("^(19|20)[0-9]$"))
    row = viewer_of(page).get_attribute("data-row")
    assert settled(page, row) == row

    before = n_runs(page)
    middle = box["y"] + 20
    page.mouse.move(box["x"] + 100, middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 700, middle, steps=20)
    page.mouse.up()
    assert viewer_of(page).get_attribute("data-row") != row
    row = viewer_of(page).get_attribute("data-row")
    assert settled(page, row) == row
    assert n_runs(page) == before + 1


def test_the_picture_is_zoomed_moved_and_brightened_and_comes_back(page):
    # by keys
    press(page, "+", "+")
    repaint(page)
    assert read(page)["frame"] != scene.FIRST_FRAME + 5
    press(page, "f")
    repaint(page)
    assert is_whole(read(page))

    # by buttons; it cannot be lost: its corner with the first squares stops at the canvas's
    scale = page.get_by_role("button", name=re.compile("^Scale"))
    sync_api.expect(scale).to_have_text("100 %")
    page.get_by_role("button", name="Zoom in").click(click_count=2, delay=20)
    sync_api.expect(scale).to_have_text("200 %")
    canvas = page.locator(".viewer canvas.picture")
    box = canvas.bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 3 * box["width"], middle[1] + 3 * box["height"], steps=4)
    page.mouse.up()
    repaint(page)
    assert canvas.evaluate(CORNER) > 0
    scale.click()
    sync_api.expect(scale).to_have_text("100 %")
    repaint(page)
    assert is_whole(read(page))

    # brightness is in the bar and leaves the boxes alone
    before = canvas.evaluate(GREY)
    press(page, "b")
    slider = page.get_by_role("slider", name="Brightness")
    sync_api.expect(slider).to_be_focused()
    slider.press("End")
    repaint(page)
    assert canvas.evaluate(GREY) > 1.5 * before
    has_box(page, 5)
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", "5")
    page.get_by_role("button", name="Reset").click()
    repaint(page)
    assert canvas.evaluate(GREY) == pytest.approx(before, abs=2)
    page.keyboard.press("b")
    sync_api.expect(slider).to_have_count(0)


def test_a_box_says_what_it_counts_and_its_pedestrian_is_chosen_and_followed(page):
    follow = page.get_by_role("button", name="Follow the chosen pedestrian")
    press(page, "t")
    sync_api.expect(follow).to_have_attribute("aria-pressed", "false")
    message = page.locator(".viewer .message")
    sync_api.expect(message).to_contain_text("Choose a pedestrian first")

    canvas = page.locator(".viewer canvas.picture")
    x, y, scale = canvas.evaluate(PLACE)
    at = {"x": x + scale * 580, "y": y + scale * 290}
    canvas.hover(position=at)
    card = page.locator(".viewer .card")
    sync_api.expect(card).to_contain_text("Pedestrian 4")
    sync_api.expect(card).to_contain_text("100 px tall")
    canvas.click(position=at)
    page.get_by_text("chosen 4").wait_for()
    canvas.hover(position={"x": x + scale * 500, "y": y + scale * 40})
    sync_api.expect(card).to_be_hidden()
    press(page, "k")  # from left to right: 5, 3, 4, and 5 again
    page.get_by_text("chosen 5").wait_for()
    sync_api.expect(page.locator(".viewer .spoken")).to_contain_text("Pedestrian 5. 36 px tall")

    press(page, "k")
    page.get_by_text("chosen 3").wait_for()
    press(page, "t", "+", "+", "+", "+")
    sync_api.expect(follow).to_have_attribute("aria-pressed", "true")
    press(page, *["ArrowRight"] * 85)  # far from the picture's middle
    assert painted(page, 90) == 90
    repaint(page)
    # X's box of the walking pedestrian is in the canvas, and there a second time, larger
    assert canvas.evaluate(N_BLUE) > 400


def test_another_recording_starts_where_python_says_and_tells_what_it_lacks(page):
    press(page, "n")
    assert settled(page, scene.MISSED_BY_X.start) == str(scene.MISSED_BY_X.start)
    message = page.locator(".viewer .message")

    choose(page, "boxes only")
    sync_api.expect(message).to_have_text("No pictures: boxes only")
    assert painted(page, 5) == 5
    assert settled(page, 5) == "5"
    has_box(page, 5)

    choose(page, "long")  # boxes beyond the first chunk are fetched
    sync_api.expect(page.locator(".viewer .row")).to_have_text(f"6 of {scene.N_LONG}")
    press(page, "End")
    assert painted(page, scene.N_LONG - 1) == scene.N_LONG - 1
    has_box(page, scene.N_LONG - 1)

    choose(page, "ended")
    sync_api.expect(message).to_contain_text("The session has ended; load the page again")
    assert settled(page, 5) == "5"
    choose(page, "empty")
    sync_api.expect(message).to_contain_text("This recording has no frames")
    assert settled(page, "None") == "None"


def test_a_new_stretch_fetches_the_picture_anew_and_who_was_away_starts_where_python_says(page):
    with page.expect_request(re.compile(r"/frame/0/5\.jpg\?lo=0&hi=99&")):
        field = page.get_by_role("spinbutton", name="hi")
        field.fill("99")
        field.press("Enter")
    assert painted(page, 5) == 5

    press(page, " ")
    page.get_by_text("show", exact=True).click()
    sync_api.expect(viewer_of(page)).to_have_count(0)
    page.get_by_text("show", exact=True).click()
    assert painted(page, 5) == 5
    press(page, "ArrowRight")
    assert settled(page, 6) == "6"


def test_the_viewer_has_no_serious_accessibility_fault(page):
    faults = []
    for case, keys in (("plain", ""), ("layers off", "xg"), ("help", "xg?")):
        press(page, *keys)
        # elements of a component are named by a path through its shadow root
        targets = {
            outcome: [
                (case, rule["id"], node["target"])
                for rule in rules
                for node in rule["nodes"]
                if isinstance(node["target"][0], list)
            ]
            for outcome, rules in Axe().run(page).response.items()
            if outcome in ("passes", "violations")
        }
        assert targets["passes"] != [], case
        faults += targets["violations"]
    assert faults == []
