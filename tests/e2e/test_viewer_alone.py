"""The frame viewer in a real browser, with made-up pictures whose frame number is in the pixels."""

from __future__ import annotations

import re

import pytest
import viewer_scene as scene
from playwright import sync_api
from viewer_reading import RECORDER, is_whole
from viewer_window import choose, painted, press, read, settled, viewer_of


def test_the_viewer_opens_on_the_row_that_python_names(page):
    reading = read(page)
    assert reading["frame"] == scene.FIRST_FRAME + 5
    assert is_whole(reading)


def test_the_frame_number_is_on_the_root_for_tests(page):
    sync_api.expect(viewer_of(page)).to_have_attribute("data-frame", str(scene.FIRST_FRAME + 5))


def test_quick_steps_count_from_the_requested_frame(page):
    press(page, *["ArrowRight"] * 30)
    assert painted(page, 35) == 35
    assert is_whole(read(page))


@pytest.mark.parametrize(
    ("keys", "row"),
    [
        (["ArrowRight", "ArrowRight", "ArrowLeft"], 6),
        (["Shift+ArrowRight"], 25),
        (["Home"], 0),
        (["End"], scene.N_ROWS - 1),
        (["n", "n"], scene.MISSED_BY_Y.start),
        (["n", "n", "p"], scene.MISSED_BY_X.start),
    ],
    ids=["one frame", "one second", "start", "end", "misses", "a miss back"],
)
def test_keys_move_to_a_frame_and_python_hears_of_it(page, keys, row):
    press(page, *keys)
    assert painted(page, row) == row
    assert settled(page, row) == str(row)


def test_who_is_missed_by_whom_is_told_in_words(page):
    press(page, "n")
    assert settled(page, scene.MISSED_BY_X.start) == str(scene.MISSED_BY_X.start)
    said = page.locator(".viewer .spoken")
    sync_api.expect(said).to_contain_text("X misses 1, Y misses 0, false alarms X 1, Y 1")


def test_python_seeks_with_a_new_number(page):
    press(page, "ArrowRight")
    assert settled(page, 6) == str(6)
    page.get_by_role("button", name="seek 123").click()
    assert painted(page, 123) == 123
    assert settled(page, 123) == str(123)


def test_a_seek_during_playback_stops_it(page):
    press(page, " ")
    page.get_by_role("button", name="seek 123").click()
    assert painted(page, 123) == 123
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")


def test_a_click_in_the_strip_seeks(page):
    strip = page.locator(".viewer .strip")
    box = strip.bounding_box()
    strip.click(position={"x": box["width"] / 2, "y": 20})
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", re.compile("^(19|20)[0-9]$"))


def test_dragging_in_the_strip_tells_python_only_the_last_row(page):
    box = page.locator(".viewer .strip").bounding_box()
    middle = box["y"] + 20
    page.mouse.move(box["x"] + 100, middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 700, middle, steps=20)
    page.mouse.up()
    row = int(viewer_of(page).get_attribute("data-row"))
    assert settled(page, row) == str(row)
    # one run at the start, one for the last row
    sync_api.expect(page.get_by_text(re.compile("^settled .* run 2$"))).to_be_visible()


def test_playing_shows_picture_and_boxes_of_the_same_frame_at_full_rate(page):
    press(page, " ")
    seen = viewer_of(page).evaluate(RECORDER, 3)
    press(page, " ")
    assert [reading for reading in seen if not is_whole(reading)] == []
    shown = len(seen) - 1
    assert shown >= 0.8 * 3 * scene.FPS, f"{shown} frames in 3 s"
    assert seen[-1]["shown"] - seen[0]["shown"] == pytest.approx(3 * scene.FPS, abs=6)


def test_python_hears_of_the_row_when_playback_stops_not_before(page):
    press(page, " ")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-row", re.compile("^[3-9][0-9]$"))
    sync_api.expect(page.get_by_text(re.compile("^settled 5 .* run 1$"))).to_be_visible()
    press(page, " ")
    row = int(viewer_of(page).get_attribute("data-row"))
    assert settled(page, row) == str(row)


def test_a_slider_move_does_not_stop_playback(page):
    press(page, " ")
    page.get_by_role("slider", name="alpha").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    sync_api.expect(page.get_by_text("alpha 0.85")).to_be_visible()
    at = int(viewer_of(page).get_attribute("data-shown-row"))
    seen = viewer_of(page).evaluate(RECORDER, 1)
    assert seen[-1]["shown"] > at + 10
    assert [reading for reading in seen if not is_whole(reading)] == []


def test_a_jump_during_playback_goes_on_from_there(page):
    press(page, " ", "n", "n")
    seen = viewer_of(page).evaluate(RECORDER, 1)
    press(page, " ")
    first = scene.MISSED_BY_Y.start
    assert [reading for reading in seen if not is_whole(reading)] == []
    assert first + 5 < seen[-1]["shown"] < first + 40
    press(page, " ", "Home")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-shown-row", re.compile("^[1-9]$"))


# what it says of itself, and whether the browser still paints
STATE = """viewer => new Promise((tell) => {
  const said = (isPainting) => tell({ ...viewer.dataset, isPainting });
  requestAnimationFrame(() => said(true));
  setTimeout(() => said(false), 1000);
})"""


def test_playback_stops_at_the_last_frame(page):
    press(page, "End", "ArrowLeft", "ArrowLeft", "ArrowLeft", " ")
    shown = painted(page, scene.N_ROWS - 1)
    state = viewer_of(page).evaluate(STATE)
    assert shown == scene.N_ROWS - 1, state
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")
    assert settled(page, scene.N_ROWS - 1) == str(scene.N_ROWS - 1)


def test_four_times_the_speed_plays_four_times_as_far(page):
    page.get_by_label("Speed").select_option("4")
    press(page, " ")
    seen = viewer_of(page).evaluate(RECORDER, 2)
    press(page, " ")
    assert seen[-1]["shown"] - seen[0]["shown"] == pytest.approx(8 * scene.FPS, abs=24)
    assert [reading for reading in seen if not is_whole(reading)] == []


def test_slow_pictures_drop_frames_but_never_show_other_boxes(page):
    choose(page, "slow")
    sync_api.expect(page.get_by_text("kind slow")).to_be_visible()
    assert painted(page, 5) == 5
    press(page, " ")
    seen = viewer_of(page).evaluate(RECORDER, 5)
    press(page, " ")
    assert [reading for reading in seen if not is_whole(reading)] == []
    assert len(seen) > 8
    # the clock keeps near to real time: 100 frames are due
    assert seen[-1]["shown"] - seen[0]["shown"] > 50


def test_slow_pictures_do_not_keep_playback_from_its_end(page):
    choose(page, "slow")
    sync_api.expect(page.get_by_text("kind slow")).to_be_visible()
    last = scene.N_ROWS - 1
    press(page, "End")
    assert painted(page, last) == last
    press(page, "Shift+ArrowLeft")  # one second: the pictures between are not here yet
    assert painted(page, last - 20) == last - 20
    page.get_by_label("Speed").select_option("4")  # so that not every picture is asked for
    press(page, " ")
    assert painted(page, last) == last
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")


def test_a_sampled_recording_plays_four_frames_a_second(page):
    choose(page, "sampled")
    # frame 1005 at two frames a second
    sync_api.expect(page.locator(".viewer .time")).to_have_text("8:22.50 min")
    assert painted(page, 5) == 5
    press(page, " ")
    seen = viewer_of(page).evaluate(RECORDER, 2)
    press(page, " ")
    assert seen[-1]["shown"] - seen[0]["shown"] in (7, 8, 9)


def test_zoom_and_fit_keep_the_frame(page):
    press(page, "+", "+")
    assert read(page)["frame"] != scene.FIRST_FRAME + 5
    press(page, "f")
    viewer_of(page).evaluate("() => new Promise(requestAnimationFrame)")
    assert is_whole(read(page))


def test_a_row_without_a_picture_shows_its_boxes_and_says_so(page):
    press(page, "End")
    assert painted(page, scene.N_ROWS - 1) == scene.N_ROWS - 1
    message = page.locator(".viewer .message")
    sync_api.expect(message).to_have_text("No picture for this frame")
    assert read(page)["box"] == pytest.approx(scene.x_of(scene.N_ROWS - 1), abs=2.5)


def test_a_picture_that_the_server_lacks_is_told(page):
    press(page, "n", "n", "n", "Shift+ArrowRight", *["ArrowRight"] * 10)
    assert painted(page, scene.LOST_PICTURE) == scene.LOST_PICTURE
    message = page.locator(".viewer .message")
    sync_api.expect(message).to_have_text("No picture for this frame")


def test_boxes_beyond_the_first_chunk_are_fetched(page):
    choose(page, "long")
    sync_api.expect(page.locator(".viewer .row")).to_have_text(f"6 of {scene.N_LONG}")
    press(page, "End")
    assert painted(page, scene.N_LONG - 1) == scene.N_LONG - 1
    assert read(page)["box"] == pytest.approx(scene.x_of(scene.N_LONG - 1), abs=2.5)


def test_a_recording_without_pictures_shows_its_boxes(page):
    choose(page, "boxes only")
    message = page.locator(".viewer .message")
    sync_api.expect(message).to_have_text("No pictures: boxes only")
    assert painted(page, 5) == 5
    assert read(page)["box"] == pytest.approx(scene.x_of(5), abs=2.5)


@pytest.mark.parametrize(
    ("recording", "words", "row"),
    [
        ("ended", "The session has ended; load the page again", "5"),
        ("empty", "This recording has no frames", "None"),
    ],
)
def test_why_nothing_is_shown_is_told(page, recording, words, row):
    choose(page, recording)
    sync_api.expect(page.locator(".viewer .message")).to_contain_text(words)
    assert settled(page, row) == row


def test_another_recording_does_not_inherit_the_row(page):
    press(page, "n")
    assert settled(page, scene.MISSED_BY_X.start) == str(scene.MISSED_BY_X.start)
    choose(page, "boxes only")
    assert settled(page, 5) == str(5)


def test_a_new_stretch_fetches_the_picture_anew(page):
    with page.expect_request(re.compile(r"/frame/0/5\.jpg\?lo=0&hi=99&")):
        field = page.get_by_role("spinbutton", name="hi")
        field.fill("99")
        field.press("Enter")
    assert painted(page, 5) == 5


def test_a_viewer_that_was_away_starts_where_python_says(page):
    press(page, " ")
    page.get_by_text("show", exact=True).click()
    sync_api.expect(viewer_of(page)).to_have_count(0)
    page.get_by_text("show", exact=True).click()
    assert painted(page, 5) == 5
    press(page, "ArrowRight")
    assert settled(page, 6) == str(6)


def test_names_from_files_are_text(page):
    name = page.locator(".viewer .layer.x .name")
    sync_api.expect(name).to_have_text("X <img src=x onerror=alert(1)>")
    assert page.locator(".viewer img").count() == 0


@pytest.mark.parametrize("keys", [[], ["x", "g"], ["?"]], ids=["plain", "layers off", "help"])
def test_the_viewer_has_no_serious_accessibility_fault(page, keys):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright").Axe()
    press(page, *keys)
    found = axe.run(page).response
    # elements of a component are named by a path through its shadow root
    targets = {
        outcome: [
            (rule["id"], node["target"])
            for rule in found[outcome]
            for node in rule["nodes"]
            if isinstance(node["target"][0], list)
        ]
        for outcome in ("passes", "violations")
    }
    assert targets["passes"] != []
    assert targets["violations"] == []
