"""Work in the background outlives a reload of its page in a real browser."""

from __future__ import annotations

from playwright.sync_api import expect


def test_a_video_is_offered_after_a_reload_while_it_was_made(visit, tmp_path):
    one = visit("export?recording=rural_child&frame=100")
    one.keyed("make_video").get_by_role("button").click()
    expect(one.page.get_by_role("button", name="Cancel")).to_be_visible()
    one.page.reload()
    with one.page.expect_download() as download:
        one.keyed("video_download").get_by_role("button").click()
    assert download.value.suggested_filename == "rural_child-0-200.mp4"
    download.value.save_as(tmp_path / "video.mp4")
    assert (tmp_path / "video.mp4").read_bytes()[4:8] == b"ftyp"
