"""Own files in a real browser: from disk to a verdict, played, and seen by nobody else."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from app_files import N_FRAMES, RECORDING, Sent, send, write_files
from app_server import PATIENCE_MS
from app_visit import Visit
from kept_window import Kept
from playwright.sync_api import BrowserContext, expect
from viewer_reading import READER, is_whole
from viewer_window import record

PLAYED_ROWS = 40


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> Sent:
    return write_files(tmp_path_factory.mktemp("sent"))


@pytest.fixture(scope="module")
def kept(person, app, files) -> Iterator[Kept[Visit]]:
    def open_and_send() -> Visit:
        visit = Visit(person, app)
        visit.go("data")
        send(visit, files)
        return visit

    kept = Kept(open_and_send)
    yield kept
    kept.close()


@pytest.fixture
def sent(request, kept) -> Iterator[Visit]:
    """A session with uploaded files, on whatever page the last test left it."""
    with kept.lend(request) as visit:
        yield visit


def test_uploaded_files_reach_a_verdict_are_played_and_outlive_a_reload(sent):
    sent.switch_to("Overview")
    expect(sent.keyed("verdict")).to_contain_text(re.compile("encounter|pedestrian"))
    expect(sent.keyed("verdict")).to_contain_text(f"1 recording, {N_FRAMES} frames, 7.5 s")

    # a video plays with picture and boxes of the same frame
    sent.switch_to("Timeline")
    sent.viewer.press("Home")
    sent.shows(0)
    assert is_whole(sent.viewer.evaluate(READER))
    sent.viewer.press(" ")
    seen = record(sent.page, PLAYED_ROWS)
    sent.viewer.press(" ")
    assert seen[-1]["shown"] >= PLAYED_ROWS
    assert [reading for reading in seen if not is_whole(reading)] == []

    # a reload keeps the files with place and parameters
    alpha = f"{float(sent.slider('alpha').input_value()) - 0.05:g}"
    sent.slider("alpha").press("ArrowLeft")
    sent.query("alpha", alpha)
    sent.wait_until_drawn()
    sent.page.reload()
    expect(sent.recording_field(RECORDING)).to_have_count(1)
    expect(sent.slider("alpha")).to_have_value(alpha)
    expect(sent.page.get_by_text("could not be followed")).to_have_count(0)


def test_a_page_gets_the_files_that_another_has_once_that_one_has_gone(visit, tmp_path: Path):
    old, new = visit("data"), visit("timeline")
    send(old, write_files(tmp_path, 40))
    token = old.page.evaluate("sessionStorage.getItem('nvcore-workspace')")
    new.page.evaluate("token => sessionStorage.setItem('nvcore-workspace', token)", token)
    with new.page.expect_websocket() as socket:
        new.page.reload()
    for _ in range(2):  # it asks again, so it was refused
        socket.value.wait_for_event("framesent", lambda frame: token.encode() in frame)
    old.close()
    expect(new.recording_field(RECORDING)).to_have_count(1)


def test_refused_pictures_are_told_at_once_and_thresholds_typed_before_are_no_threshold_of_files(
    visit, tmp_path: Path
):
    wrong = tmp_path / "walk.mp4"
    wrong.write_text("no video\n")
    one: Visit = visit("data")
    one.open_way("Upload")
    with one.page.expect_console_message(lambda message: "415" in message.text):
        one.keyed("upload_pictures").locator("input[type=file]").set_input_files(wrong)
    told = one.page.get_by_role("alert").filter(has_text="walk.mp4")
    expect(told).to_contain_text("neither a video")
    assert ["415" in complaint for complaint in one.complaints] == [True]
    one.complaints.clear()  # the browser's own word for the refusal

    one.go("data")
    one.page.get_by_role("button", name="Type exact thresholds").click()
    field = one.page.get_by_role("spinbutton", name="Score threshold of X")
    field.fill("0.805")
    field.press("Enter")
    one.query("threshold_x", "0.805")
    one.wait_until_drawn()
    send(one, write_files(tmp_path, 40))
    form = one.keyed("open_upload")
    expect(form).to_be_hidden()
    one.keyed("recordings").get_by_text(re.compile("^Recordings: ")).click()
    one.keyed("apply_recordings").get_by_role("button").click()
    expect(one.page.get_by_text("Nothing was changed")).to_be_visible()  # what was sent has arrived
    one.wait_until_drawn()
    for letter in "XY":
        expect(one.page.get_by_text(f"Every detection of {letter} counts.")).to_be_visible()
    expect(form).to_be_hidden()


def test_a_further_system_joins_what_is_open(visit, tmp_path: Path):
    one: Visit = visit("data")
    files = write_files(tmp_path, 40)
    send(one, files)
    third = shutil.copy(files.x, tmp_path / "camera_c.csv")
    one.page.get_by_role("button", name="Add or replace files").click()
    field = one.page.locator('[class*="st-key-upload_change_"][class*="_system_2"]').first
    with one.page.expect_response(re.compile("/_stcore/upload_file/")):
        field.locator("input[type=file]").first.set_input_files(third)
    expect(field.get_by_text("camera_c.csv")).to_be_visible()
    one.wait_until_drawn()
    one.page.get_by_role("button", name="Change the comparison").click()
    expect(one.page.get_by_text("Opened: Uploaded files")).to_be_visible()
    one.wait_until_drawn()
    expect(one.page.get_by_role("cell", name="camera_c", exact=True)).to_be_visible()
    one.switch_to("Timeline")
    expect(one.recording_field(RECORDING)).to_have_count(1)


@pytest.fixture
def stranger(chromium: BrowserContext) -> Iterator[BrowserContext]:
    """Windows without the cookies and the cache of the others."""
    stranger = chromium.browser.new_context()
    stranger.set_default_timeout(PATIENCE_MS)
    yield stranger
    stranger.close()


def test_two_sessions_see_nothing_of_each_other(sent, stranger, visit):
    link = "timeline?alpha=0.4&recording=rural_child&frame=57"
    other: Visit = visit(link, stranger, motion="no-preference")
    other.shows(57)
    sent.switch_to("Timeline")
    expect(sent.recording_field(RECORDING)).to_have_count(1)
    alpha = float(sent.slider("alpha").input_value())
    assert alpha > 0.6
    sent.slider("alpha").press("ArrowLeft")
    sent.query("alpha", f"{alpha - 0.05:g}")
    other.slider("alpha").press("ArrowRight")
    other.query("alpha", "0.45")
    other.switch_to("Data")
    expect(other.heading("Open now: Sample recordings")).to_be_visible()
    expect(other.page.get_by_text(RECORDING, exact=True)).to_have_count(0)
    expect(sent.slider("alpha")).to_have_value(f"{alpha - 0.05:g}")
    assert token_of(sent) != token_of(other)


def token_of(one: Visit) -> str:
    token: str = one.page.evaluate(
        """() => performance.getEntriesByType("resource")
             .map(one => one.name.match("/nv/([^/]+)/boxes/")).filter(Boolean)[0][1]"""
    )
    return token
