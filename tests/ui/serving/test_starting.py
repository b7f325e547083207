"""A server that cannot serve does not start; one that starts removes what a killed one left."""

from __future__ import annotations

from pathlib import Path

import pytest
from filelock import FileLock
from inputs import write
from places import SAMPLE

from nvcore.common.errors import InputError
from ui.serving.life import check_start
from ui.session.lifetime import base_folder, process_folder
from ui.settings.limits import limits_of_environment


@pytest.fixture(autouse=True)
def fresh(surroundings: None) -> None:
    process_folder.cache_clear()
    limits_of_environment.cache_clear()


@pytest.mark.parametrize(
    ("variable", "value", "words"),
    [
        ("NVCORE_MAX_VISITORS", "many", "expected a whole number"),
        ("NVCORE_LOCAL_ROOT", "{}/gone", "there is no such folder"),
        ("NVCORE_SESSION", "{}/gone.toml", "gone.toml"),
        ("NVCORE_SESSION", "{}/half.toml", "gone.csv"),
        ("NVCORE_UPLOAD_DIR", "{}/file/below", "NVCORE_UPLOAD_DIR"),
        ("NVCORE_RATINGS", "{}/file/ratings.sqlite", "folder of the ratings"),
        ("NVCORE_STUDIES", "{}/file/studies.sqlite", "folder of the study"),
    ],
)
def test_what_cannot_work_ends_the_start(
    variable: str, value: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    (tmp_path / "file").touch()
    write(tmp_path / "half.toml", '[truth]\npath = "gone.csv"', '[[system]]\npath = "a.csv"')
    monkeypatch.setenv(variable, value.format(tmp_path))
    with pytest.raises(InputError, match=words):
        check_start()


def test_what_can_work_is_fine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("NVCORE_LOCAL_ROOT", str(tmp_path))
    monkeypatch.setenv("NVCORE_SESSION", str(SAMPLE))
    monkeypatch.setenv("NVCORE_RATINGS", str(tmp_path / "ratings" / "ratings.sqlite"))
    monkeypatch.setenv("NVCORE_STUDIES", str(tmp_path / "studies" / "studies.sqlite"))
    check_start()


def test_uploads_that_a_killed_server_left_go_before_anybody_comes():
    left = base_folder() / "0123456789abcdef"
    left.mkdir()
    with FileLock(left.with_suffix(".lock")):
        (left / "night.mp4").touch()
    left.with_suffix(".lock").touch()
    check_start()
    assert not left.exists()
