"""Servers of the app that are set up in another way: below a path, with room for one visitor."""

from __future__ import annotations

import re
import urllib.error
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import pytest
from app_files import write_files
from app_server import ROOT, serve
from app_visit import Visit
from kept_window import Kept
from playwright.sync_api import BrowserContext, expect

BASE = "apps/night"


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with serve(ROOT / "app.py", base=BASE) as below:
        yield below


@pytest.fixture(scope="module")
def kept(person: BrowserContext, address: str) -> Iterator[Kept[Visit]]:
    kept = Kept(lambda: Visit(person, address))
    yield kept
    kept.close()


@pytest.fixture
def one(request: pytest.FixtureRequest, kept: Kept[Visit]) -> Iterator[Visit]:
    """A window, on whatever page the last test left it, or empty."""
    with kept.lend(request) as visit:
        yield visit


def show(one: Visit, title: str) -> None:
    """Go to this page by the navigation, in a window that is empty after the app is open."""
    if one.page.url == "about:blank":
        one.go("")
    one.switch_to(title)


def test_a_deep_link_shows_pictures_and_boxes(one):
    below = f"/{BASE}/nv/[^/]+/"
    with (
        one.page.expect_response(re.compile(f"{below}boxes/4/0")) as boxes,
        one.page.expect_response(re.compile(f"{below}frame/4/57.jpg")) as picture,
    ):
        one.go("timeline?alpha=0.4&recording=rural_child&frame=57")
    assert picture.value.headers["content-type"] == "image/jpeg"
    assert boxes.value.headers["content-type"] == "application/octet-stream"
    one.shows(57)
    one.panel_shows(57)
    expect(one.slider("alpha")).to_have_value("0.4")
    expect(one.page.locator(".viewer .message")).to_be_hidden()


def test_a_video_is_uploaded(one, tmp_path):
    video = write_files(tmp_path).video
    show(one, "Data")
    one.page.get_by_role("tab", name="Upload").click()
    one.keyed("upload_pictures").locator("input[type=file]").set_input_files(video)
    expect(one.page.get_by_text(f"Here: {video.name}")).to_be_visible()


def test_a_term_leads_to_its_explanation(one):
    show(one, "Saliency")
    link = one.page.get_by_test_id("stMain").locator('a[href*="metrics#saliency"]').first
    one.page.goto(link.evaluate("link => link.href"))
    expect(one.page.locator("#saliency")).to_be_in_viewport()
    assert f"/{BASE}/metrics#saliency" in one.page.url


def test_the_overview_opens_by_its_name_and_by_the_path_alone(one):
    one.go("overview?alpha=0.4")
    expect(one.heading("Overview", level=1)).to_be_visible()
    expect(one.slider("alpha")).to_have_value("0.4")
    one.page.goto(one.address)
    one.wait_until_drawn()
    expect(one.heading("Overview", level=1)).to_be_visible()


def test_a_full_server_says_so_and_uploads_go_with_it(
    person: BrowserContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path))
    monkeypatch.setenv("NVCORE_MAX_VISITORS", "1")
    with serve(ROOT / "app.py") as address:
        visit = Visit(person, address)
        visit.go("data")
        (folder,) = tmp_path.glob("*/*/*")
        (folder / "sent.mp4").write_bytes(bytes(1000))
        page = urllib.request.Request(f"{address}/overview", headers={"Accept": "text/html"})
        with pytest.raises(urllib.error.HTTPError, match="503"):
            urllib.request.urlopen(page)
        complaints = list(visit.complaints)
        visit.close()
    assert complaints == []
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
