"""Playback of the frame viewer in a real browser.

What it paints at which time is asked with the page's clock in the test's hands; that it plays by
the browser's own, only up to a row.
"""

from __future__ import annotations

import viewer_scene as scene
from playwright import sync_api
from viewer_clock import held_clock, held_pictures, slow_pictures
from viewer_reading import is_whole
from viewer_window import choose, n_runs, painted, press, record, repaint, settled, viewer_of

FIRST = 5  # where the viewer opens
FRAME_S = 1 / scene.FPS


def have_pictures(page: sync_api.Page, last: int) -> None:
    """Let the viewer load all pictures from `FIRST` up to this row, and go back."""
    press(page, "Home", *["ArrowRight"] * FIRST)
    for row in range(FIRST + 1, last + 1):
        press(page, "ArrowRight")
        assert painted(page, row) == row
    press(page, *["ArrowLeft"] * (last - FIRST))
    assert painted(page, FIRST) == FIRST


def test_every_row_is_painted_at_its_time(page):
    n_rows = 16
    for recording, speed, step_s, rows_per_step in (
        ("video", "1", FRAME_S, 1),
        ("video", "4", FRAME_S, 4),
        ("sampled", "1", 0.125, 0.5),  # two frames a second play at four
    ):
        case = f"{recording} at {speed}"
        if recording == "sampled":
            choose(page, recording)
            # frame 1005 at two frames a second
            sync_api.expect(page.locator(".viewer .time")).to_have_text("8:22.50 min")
            assert painted(page, FIRST) == FIRST
        have_pictures(page, FIRST + n_rows)
        page.get_by_label("Speed").select_option(speed)
        with held_clock(page) as clock:
            press(page, " ")
            readings = [clock.advance(0)]
            clock.advance(1e-4)  # off the rows' own times
            readings += [clock.advance(step_s) for _ in range(round(n_rows / rows_per_step))]
            press(page, " ")
        due = [FIRST + int(step * rows_per_step) for step in range(len(readings))]
        assert [reading["shown"] for reading in readings] == due, case
        assert [reading for reading in readings if not is_whole(reading)] == [], case


def test_rows_whose_pictures_are_late_are_dropped_and_never_mixed(page):
    first = scene.MISSED_BY_X.start
    with held_pictures(page, first) as pictures, held_clock(page) as clock:
        press(page, "n")
        pictures.let(first)
        assert is_whole(clock.wait_for(first))
        pictures.wait_for(first + 3)  # a viewer that plays may leave out rows as it asks
        press(page, " ")
        clock.advance(0)
        assert clock.advance(6.5 * FRAME_S)["shown"] == first
        pictures.let(first + 3)
        assert is_whole(clock.wait_for(first + 3))
        assert clock.advance(60)["shown"] == first + 3


def test_by_the_browsers_clock_python_hears_of_the_row_when_playback_stops(page):
    before = n_runs(page)
    press(page, " ")
    seen = record(page, FIRST + 40)
    assert n_runs(page) == before
    press(page, " ")
    assert [reading for reading in seen if not is_whole(reading)] == []
    assert seen[-1]["shown"] >= FIRST + 40
    row = viewer_of(page).get_attribute("data-row")
    assert settled(page, row) == row

    # a slider move does not stop it
    page.get_by_label("Speed").select_option("0.25")  # far from the end, however slow Python is
    press(page, " ")
    page.get_by_role("slider", name="alpha").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    sync_api.expect(page.get_by_text("alpha 0.85")).to_be_visible()
    row = int(viewer_of(page).get_attribute("data-shown-row"))
    seen = record(page, row + 10)
    assert seen[-1]["shown"] >= row + 10
    assert [reading for reading in seen if not is_whole(reading)] == []

    # a seek does
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "true")
    page.get_by_role("button", name="seek 123").click()
    assert painted(page, 123) == 123
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")
    assert settled(page, 123) == "123"


# A page may move its parts, and the browser paints while the viewer is on its way.
PAINT_WHILE_AWAY = """viewer => {
  const parent = viewer.parentNode;
  viewer.remove();
  window.testClock.advance(1);
  parent.append(viewer);
}"""


def test_playback_goes_on_after_a_jump_and_while_the_viewer_is_moved_about_in_the_page(page):
    choose(page, "boxes only")  # nothing to wait for
    assert painted(page, FIRST) == FIRST
    first = scene.MISSED_BY_Y.start
    with held_clock(page) as clock:
        press(page, " ")
        clock.advance(0)
        assert clock.advance(2.5 * FRAME_S)["shown"] == FIRST + 2
        viewer_of(page).evaluate(PAINT_WHILE_AWAY)
        clock.advance(0)
        assert clock.advance(2 * FRAME_S)["shown"] == FIRST + 4
        press(page, "n", "n")
        assert clock.advance(FRAME_S)["shown"] == first
        assert clock.advance(6.5 * FRAME_S)["shown"] == first + 6
        press(page, "Home")
        assert clock.advance(FRAME_S)["shown"] == 0
        assert clock.advance(2.5 * FRAME_S)["shown"] == 2
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "true")


def test_playback_stops_at_the_last_frame_however_slow_the_pictures_are(page):
    last = scene.N_ROWS - 1
    press(page, "End", "ArrowLeft", "ArrowLeft", "ArrowLeft", " ")
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")
    assert painted(page, last) == last
    assert settled(page, last) == str(last)

    choose(page, "slow")
    press(page, "End")
    assert painted(page, last) == last
    press(page, "Shift+ArrowLeft")  # one second: the pictures between are not here yet
    assert painted(page, last - 20) == last - 20
    page.get_by_label("Speed").select_option("4")  # so that not every picture is asked for
    press(page, " ")
    assert painted(page, last) == last
    sync_api.expect(viewer_of(page)).to_have_attribute("data-playing", "false")


def test_playback_goes_on_when_every_picture_takes_seconds(page):
    first = scene.MISSED_BY_X.start
    with slow_pictures(page, 100):
        with held_pictures(page, first) as pictures:
            press(page, "n")
            pictures.let(first)
            assert painted(page, first) == first
            press(page, " ")  # before the next ones are here
            repaint(page)
        seen = record(page, first + 40)
        press(page, " ")
    assert seen[-1]["shown"] >= first + 40
