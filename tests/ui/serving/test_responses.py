"""Answers of studies that are over, deleted by the server itself."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from nvcore.subjects.ratings.clip_task import RatingStore
from ui.serving import life

BEGUN = datetime.now(UTC) - timedelta(days=10)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where answers are kept."""
    monkeypatch.setenv("NVCORE_RATINGS", str(tmp_path / "ratings.sqlite"))
    monkeypatch.setenv("NVCORE_STUDIES", str(tmp_path / "studies.sqlite"))
    return tmp_path


def begin(folder: Path, keep_days: int) -> str:
    """A session of ten days ago, which ends after so many; its token."""
    store = RatingStore(folder / "ratings.sqlite", now=BEGUN)
    clips = [("drive", str(number)) for number in range(4)]
    return store.begin("fingerprint", clips, keep_days=keep_days, now=BEGUN).token


def tokens(folder: Path) -> list[str]:
    store = RatingStore(folder / "ratings.sqlite", now=BEGUN)
    with store.connect() as base:
        return [token for (token,) in base.execute("SELECT token FROM study")]


def test_what_is_over_is_deleted_and_nothing_else(folder: Path):
    begin(folder, 9)
    later = begin(folder, 11)
    assert len(tokens(folder)) == 2
    life.delete_ended()
    assert tokens(folder) == [later]


def test_where_there_is_no_file_none_is_made(folder: Path):
    life.delete_ended()
    assert not [*folder.iterdir()]


def test_a_file_that_cannot_be_used_is_logged(folder: Path, caplog: pytest.LogCaptureFixture):
    (folder / "studies.sqlite").write_bytes(b"no database")
    begin(folder, 9)
    life.delete_ended()
    assert tokens(folder) == []
    assert "the file of the study cannot" in caplog.text


def test_the_server_looks_again_and_again(folder: Path, monkeypatch: pytest.MonkeyPatch):
    left: list[int] = []

    async def nap(seconds: float) -> None:
        assert seconds == life.EVERY_S
        left.append(len(tokens(folder)))
        if len(left) == 2:
            raise asyncio.CancelledError
        begin(folder, 9)

    begin(folder, 9)
    monkeypatch.setattr(life.asyncio, "sleep", nap)
    with pytest.raises(asyncio.CancelledError):
        asyncio.run(life.keep_deleting_ended())
    assert left == [0, 0]
