"""The Review page in a real browser: keys, a reload, and somebody who is no member."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from app_server import ROOT, held_port, serve
from app_visit import Visit
from playwright.sync_api import BrowserContext, Locator, expect
from streamlit.web.server.starlette.starlette_app_utils import create_signed_value

SECRET = "s" * 32
USER = "_streamlit_user"


@pytest.fixture(autouse=True)
def projects(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_PROJECTS", str(tmp_path / "projects.sqlite"))


@pytest.fixture
def server(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """An app at which people log in."""
    with held_port() as port:
        origin = f"http://127.0.0.1:{port}"
        settings = {
            "redirect_uri": f"{origin}/oauth2callback",
            "cookie_secret": SECRET,
            "client_id": "nvcore",
            "client_secret": "of the tests",
            "server_metadata_url": "https://id.example/.well-known/openid-configuration",
        }
        lines = [f"{key} = {json.dumps(value)}" for key, value in settings.items()]
        (tmp_path / "auth.toml").write_text("\n".join(["[auth]", *lines]), encoding="utf-8")
        monkeypatch.setenv("NVCORE_LOGIN", str(tmp_path / "auth.toml"))
        with serve(ROOT / "app.py", port=port) as address:
            yield address


def log_in(person: BrowserContext, address: str, name: str) -> None:
    """Give a browser the cookie of somebody who has logged in."""
    claims = {
        "iss": "https://id.example",
        "sub": name,
        "provider": "default",
        "origin": address,
        "email": f"{name}@lab.example",
        "email_verified": True,
        "is_logged_in": True,
    }
    value = create_signed_value(SECRET, USER, json.dumps(claims)).decode()
    person.clear_cookies()
    person.add_cookies([{"name": USER, "value": value, "url": address}])


def case(one: Visit, number: int) -> Locator:
    return one.page.get_by_role("option").nth(number)


def panel(one: Visit, name: str) -> Locator:
    return one.page.get_by_role("button", name=name, exact=True)


def is_selected(one: Visit, number: int) -> None:
    expect(case(one, number)).to_have_attribute("aria-selected", "true")
    expect(one.page.locator("[role=option][tabindex='0']")).to_have_count(1)


def test_keys_walk_decide_and_open_and_a_reload_keeps_it(visit) -> None:
    one = visit("review")
    expect(one.page.get_by_role("option")).to_have_count(41)
    case(one, 0).focus()
    for key in ("ArrowRight", "ArrowDown", "ArrowLeft"):
        one.page.keyboard.press(key)
    n_columns = one.page.get_by_role("listbox").evaluate(
        "grid => getComputedStyle(grid).gridTemplateColumns.split(' ').length"
    )
    is_selected(one, n_columns)
    expect(case(one, n_columns)).to_be_focused()

    # five decisions at once, of which the last is taken back
    for key in ("Home", "3", "ArrowRight", "1", "ArrowRight", "4", "ArrowRight", "5", "0"):
        one.page.keyboard.press(key)
    expect(one.page.get_by_role("status")).to_have_text("3 of 41 done")
    one.page.keyboard.press("u")
    expect(panel(one, "ask")).to_have_attribute("aria-pressed", "true")
    expect(one.page.get_by_text("Without the 2 cases marked")).to_be_visible()

    # a note is typed, not decided by
    case(one, 0).click()
    note = one.page.get_by_role("textbox", name="Note")
    note.fill("pole 4")
    note.press("Enter")
    one.wait_until_drawn()
    expect(case(one, 0)).to_be_focused()
    assert one.accessibility_faults() == []

    one.page.reload()
    one.wait_until_drawn()
    expect(one.page.get_by_role("status")).to_have_text("3 of 41 done")
    case(one, 0).click()
    expect(note).to_have_value("pole 4")
    expect(panel(one, "wrong truth")).to_have_attribute("aria-pressed", "true")

    one.page.keyboard.press("Enter")
    expect(one.heading("Timeline", level=1)).to_be_visible()
    one.shows(249)
    one.recording_field("oncoming_glare").wait_for()


def test_reviewers_see_each_other_and_nobody_else_gets_in(person, server, tmp_path) -> None:
    log_in(person, server, "anna")
    anna = Visit(person, server)
    anna.go("review")
    anna.page.get_by_role("button", name="Projects").click()
    anna.page.get_by_role("textbox", name="Keep this comparison").fill("Night drive")
    anna.page.keyboard.press("Enter")
    anna.page.get_by_role("button", name="Project: Night drive").click()
    address = anna.page.get_by_test_id("stCode").inner_text().strip()
    crop = anna.page.locator(".case img").first.get_attribute("src")
    assert crop is not None

    log_in(person, server, "bert")
    bert = Visit(person, server)
    bert.page.goto(address)
    expect(bert.page.get_by_text("you are not one of its members")).to_be_visible()
    assert person.request.get(f"{server}{crop}").status == 403
    bert.close()

    log_in(person, server, "anna")
    other = Visit(person, server)
    other.page.goto(address)
    expect(other.page.get_by_role("button", name="Project: Night drive")).to_be_visible()
    other.wait_until_drawn()
    case(other, 0).click()
    other.page.keyboard.press("3")
    expect(case(anna, 0)).to_have_attribute("aria-label", re.compile("wrong truth$"))
    for one in (anna, other):
        one.close()
        assert one.complaints == []
