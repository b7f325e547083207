"""The server of the app: what it refuses, and what is left when it ends."""

from __future__ import annotations

import urllib.error
import urllib.request
from pathlib import Path

import pytest
from app_server import ROOT, serve
from app_visit import Visit
from playwright.sync_api import BrowserContext


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
