"""Surroundings of the pages' tests: a folder for uploads of their own, and no local folder."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NVCORE_UPLOAD_DIR", str(tmp_path / "uploads"))
    monkeypatch.delenv("NVCORE_LOCAL_ROOT", raising=False)
