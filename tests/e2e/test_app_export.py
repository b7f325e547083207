"""Downloads of the Export page in a real browser: the report's files, and a video."""

from __future__ import annotations

import subprocess
import sys
import zipfile

import pytest
from app_server import ROOT
from playwright.sync_api import expect

from nvcore.common.output.files import LOCK, MANIFEST

PLAY = """() => new Promise((resolve, reject) => {
  const video = document.querySelector("video");
  video.muted = true;
  video.onerror = () => reject(video.error.message);
  video.ontimeupdate = () => video.currentTime > 0.2 && resolve(video.duration);
  video.play().catch(reject);
})"""
"""Plays the browser's own page of a video; its length in seconds."""
LINK = "export?alpha=0.4&recording=rural_child&frame=100"


def test_the_zip_holds_the_files_of_the_command_line_byte_for_byte(shared, tmp_path):
    one = shared(LINK)
    with one.page.expect_download() as download:
        one.page.get_by_role("button", name="All files (ZIP)").click()
    download.value.save_as(tmp_path / "report.zip")
    command = [sys.executable, "-m", "nvcore", "compare", "sample_data/session.toml"]
    command += ["--alpha", "0.4", "--out", str(tmp_path / "report")]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    with zipfile.ZipFile(tmp_path / "report.zip") as report:
        sent = {name.rpartition("/")[2]: report.read(name) for name in report.namelist()}
    folder = tmp_path / "report"
    written = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != LOCK}
    assert sent.keys() == written.keys()
    # session.toml names its inputs beside itself, not where the command was started
    assert {name for name in sent if sent[name] != written[name]} == {"session.toml", MANIFEST}


def test_a_video_is_offered_after_a_reload_while_it_was_made(shared, tmp_path):
    one = shared(LINK)
    one.page.get_by_role("spinbutton", name="To (s)").fill("5")
    one.page.keyboard.press("Enter")
    expect(one.page.get_by_text("101 frames at")).to_be_visible()
    one.keyed("make_video").get_by_role("button").click()
    expect(one.page.get_by_role("button", name="Cancel")).to_be_visible()
    one.page.reload()
    with one.page.expect_download() as download:
        one.keyed("video_download").get_by_role("button").click()
    assert download.value.suggested_filename == "rural_child-0-100.mp4"
    download.value.save_as(tmp_path / "video.mp4")
    other = one.page.context.new_page()
    other.goto((tmp_path / "video.mp4").as_uri())
    seconds = other.evaluate(PLAY)
    other.close()
    assert seconds == pytest.approx(101 / 20)
