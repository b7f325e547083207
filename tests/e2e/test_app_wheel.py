"""The dashboard as it is installed: from the wheel alone, on the session that it was given."""

from __future__ import annotations

from pathlib import Path

from app_server import serving
from app_visit import Visit
from inputs import drive, write
from installed import install
from playwright.sync_api import BrowserContext, expect


def test_the_installed_dashboard_opens_on_its_session(person: BrowserContext, tmp_path: Path):
    wheel = install(tmp_path)
    drive(tmp_path / "drive")
    session = write(
        tmp_path / "drive" / "night.toml",
        '[defaults]\nsize = "640x480"\nfps = 20',
        '[truth]\npath = "truth.csv"',
        '[[system]]\nname = "FIR"\npath = "fir.csv"',
        '[[system]]\nname = "NIR"\npath = "nir.csv"',
    )
    command = wheel.command("app", session, "--no-browser", "--port")
    environment = wheel.environment("app")
    with serving(command, cwd=tmp_path, environment=environment) as (address, _):
        one = Visit(person, address)
        one.go("data")
        expect(one.page.get_by_text("Open now: night.toml (")).to_be_visible()
        one.switch_to("Timeline")
        expect(one.page.locator(".viewer canvas").first).to_be_visible()
        one.switch_to("Documentation")
        expect(one.page.get_by_role("heading", name="Similarity").first).to_be_visible()
        one.close()
    assert one.complaints == []
