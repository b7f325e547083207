"""Servers of the app that are set up in another way: below a path, full, or with a log-in."""

from __future__ import annotations

import os
import re
import sys
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from app_files import write_files
from app_server import HELPERS, ROOT, held_port, serve, serving
from app_visit import SECTION_OF, Visit
from playwright.sync_api import BrowserContext, expect

BASE = "apps/night"


def test_below_a_path_pages_pictures_uploads_and_explanations_are_found(
    person: BrowserContext, tmp_path: Path
):
    with serve(ROOT / "app.py", base=BASE) as address:
        one = Visit(person, address)
        # a deep link shows pictures and boxes
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

        # a video is uploaded
        video = write_files(tmp_path).video
        one.switch_to("Data")
        one.open_way("Upload")
        one.keyed("upload_pictures").locator("input[type=file]").set_input_files(video)
        expect(one.page.get_by_text(f"Here: {video.name}")).to_be_visible()

        # a term leads to its explanation
        one.switch_to("Saliency")
        link = one.page.get_by_test_id("stMain").locator('a[href*="metrics#saliency"]').first
        one.page.goto(link.evaluate("link => link.href"))
        expect(one.page.locator("#saliency")).to_be_in_viewport()
        assert f"/{BASE}/metrics#saliency" in one.page.url

        # the Overview opens by its name and by the path alone
        one.go("overview?alpha=0.4")
        expect(one.heading("Overview", level=1)).to_be_visible()
        expect(one.slider("alpha")).to_have_value("0.4")
        one.page.goto(one.address)
        one.wait_until_drawn()
        expect(one.heading("Overview", level=1)).to_be_visible()
        one.close()
    assert one.complaints == []


def test_a_full_server_refuses_files_and_people_in_words_and_uploads_go_with_it(
    person: BrowserContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path))
    monkeypatch.setenv("NVCORE_MAX_UPLOADS_MB", "1")
    monkeypatch.setenv("NVCORE_MAX_VISITORS", "1")
    with serve(ROOT / "app.py") as address:
        one = Visit(person, address)
        one.go("data")
        (folder,) = tmp_path.glob("*/*/*")
        (folder / "sent.mp4").write_bytes(bytes(1000))
        page = urllib.request.Request(f"{address}/overview", headers={"Accept": "text/html"})
        with pytest.raises(urllib.error.HTTPError, match="503"):
            urllib.request.urlopen(page)
        assert one.complaints == []
        one.open_way("Upload")
        field = one.keyed("upload_truth").locator("input[type=file]")
        field.set_input_files({"name": "a.csv", "mimeType": "text/csv", "buffer": bytes(3 << 20)})
        said = one.page.get_by_test_id("stToast")
        expect(said).to_contain_text("The file has 3.0 MB, the server room for 1.0 MB.")
        one.wait_until_drawn()
        expect(said).to_have_count(1)
        one.close()
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_web_addresses_in_names_stay_text(
    person: BrowserContext, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    name = "http://evil.invalid/a.png www.evil.invalid (b@evil.invalid) mailto:c@evil.invalid"
    rows = "".join(f"{name},{frame},{100 + frame},200,40,120,1,0.9\n" for frame in range(30))
    for file in ("truth", "x", "y"):
        text = f"recording,frame,x,y,w,h,track,score\n{rows}"
        (tmp_path / f"{file}.csv").write_text(text)
    (tmp_path / "session.toml").write_text(
        '[defaults]\nsize = "640x480"\nfps = 10\nframes = "0:29"\n[truth]\npath = "truth.csv"\n'
        + "".join(f'[[system]]\nname = "{s} {name}"\npath = "{s}.csv"\n' for s in "xy")
    )
    monkeypatch.setenv("NVCORE_SESSION", str(tmp_path / "session.toml"))
    with serve(ROOT / "app.py") as address:
        visit = Visit(person, address)
        visit.go("")
        n_shown = 0
        for title in SECTION_OF:
            visit.switch_to(title)
            hosts = visit.page.eval_on_selector_all("a[href]", "all => all.map(one => one.origin)")
            assert set(hosts) <= {address}, title
            n_shown += visit.page.get_by_text("evil.invalid").count()
        visit.close()
    assert n_shown > 20


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of the app behind a log-in, below a path, beside a provider of its own."""
    file = tmp_path_factory.mktemp("login") / "auth.toml"
    with held_port() as port, pytest.MonkeyPatch.context() as patch:
        file.write_text(
            f"""[auth]
        redirect_uri = "http://127.0.0.1:{{port}}/{BASE}/oauth2callback"
        cookie_secret = "{"x" * 32}"
        client_id = "nvcore"
        client_secret = "of the tests"
        server_metadata_url = "http://127.0.0.1:{port}/.well-known/openid-configuration"
        allow = ["lab.example"]
        """
        )
        patch.setenv("NVCORE_LOGIN", str(file))
        patch.setenv("AUTHLIB_INSECURE_TRANSPORT", "1")  # the provider's: it has no TLS
        with serve(ROOT / "app.py", base=BASE) as address:
            command = [sys.executable, str(HELPERS / "provider.py"), f"{address}/oauth2callback"]
            environment = {**os.environ, "PYTHONPATH": str(HELPERS)}
            with serving(command, cwd=ROOT, environment=environment, port=port):
                yield address


@pytest.fixture
def log_in(person: BrowserContext, guarded: str) -> Iterator[Callable[..., Visit]]:
    """A window of this person, who has been asked who it is where a page was opened."""
    opened: list[Visit] = []

    def open_as(name: str, page: str = "") -> Visit:
        person.clear_cookies()
        visit = Visit(person, guarded)
        opened.append(visit)
        visit.page.goto(f"{guarded}/{page}")
        visit.page.get_by_role("link", name="Log in", exact=True).click()
        visit.page.get_by_role("link", name=name, exact=True).click()
        return visit

    yield open_as
    for visit in opened:
        visit.close()


def cookies_of(person: BrowserContext) -> str:
    return "; ".join(f"{cookie['name']}={cookie['value']}" for cookie in person.cookies())


def status(url: str, cookies: str = "", *, content: bytes | None = None) -> int:
    """What a server answers to a program that has an address, and cookies or none."""
    method = "GET" if content is None else "PUT"
    request = urllib.request.Request(url, content, {"Cookie": cookies}, method=method)
    try:
        with urllib.request.urlopen(request) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code


def test_nothing_is_shown_to_who_has_not_logged_in(person: BrowserContext, guarded: str):
    page = person.new_page()
    sockets: list[str] = []
    page.on("websocket", lambda socket: sockets.append(socket.url))
    answer = page.goto(f"{guarded}/timeline?recording=rural_child&frame=57")
    assert answer is not None
    assert answer.status == 401
    expect(page.get_by_role("heading", name="nvcore")).to_be_visible()
    expect(page.get_by_role("link")).to_have_text(["Log in"])
    assert (sockets, "rural" in page.locator("body").inner_text()) == ([], False)
    page.close()
    for path in ("nv/token/boxes/0/0", "media/a.png", "_stcore/upload_file/a/b", "static/js/a.js"):
        assert status(f"{guarded}/{path}") == 401
    assert status(f"{guarded}/_stcore/health") == 200


def test_frames_and_uploads_are_for_who_has_opened_them(
    person: BrowserContext, guarded: str, log_in: Callable[..., Visit], tmp_path: Path
):
    visit = log_in("bert")
    visit.wait_until_drawn()
    bert = cookies_of(person)
    visit.close()

    visit = log_in("anna", "timeline?recording=rural_child&frame=57")
    visit.shows(57)  # the address that was asked for before
    anna = cookies_of(person)
    fetched = visit.page.evaluate("performance.getEntriesByType('resource').map(one => one.name)")
    frame = next(url for url in fetched if "/frame/" in url)
    upload = f"{frame.partition('/frame/')[0]}/upload/pictures?name=a.png"
    picture = b"\x89PNG\r\n\x1a\n" + bytes(100)
    assert [status(frame, by) for by in (anna, bert, "")] == [200, 403, 401]
    sent = [status(upload, by, content=picture) for by in (bert, "", anna)]
    assert sent == [403, 401, 201]

    visit.page.get_by_role("button", name="Log out").click()
    expect(visit.page.get_by_role("link", name="Log in")).to_be_visible()
    assert visit.page.evaluate("url => fetch(url).then(answer => answer.status)", frame) == 401
    # a copy of the cookie is of no use either, neither for what was open nor for anything else
    assert [status(url, anna) for url in (frame, f"{guarded}/data")] == [401, 401]
    assert status(f"{guarded}/data", bert) == 200


def test_who_is_not_on_the_list_is_told_so(log_in: Callable[..., Visit]):
    for name, words in (
        ("carl", "carl@elsewhere.example is not on the list"),
        ("dora", "one that is verified"),
    ):
        page = log_in(name).page
        expect(page.get_by_text(words)).to_be_visible()
        page.get_by_role("link", name="Log in as somebody else").click()
        expect(page.get_by_role("link", name="Log in", exact=True)).to_be_visible()


def test_a_log_in_that_ends_elsewhere_ends_an_open_page(
    person: BrowserContext, guarded: str, log_in: Callable[..., Visit]
):
    visit = log_in("anna", "saliency")
    visit.wait_until_drawn()
    other = person.new_page()
    other.goto(f"{guarded}/auth/logout")
    expect(other.get_by_role("link", name="Log in", exact=True)).to_be_visible()
    other.close()
    visit.keyed("navigation").get_by_role("link", name="Data", exact=True).click()
    expect(visit.page.get_by_role("link", name="Log in", exact=True)).to_be_visible()
