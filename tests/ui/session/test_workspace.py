"""Workspaces: one per session, found by token, gone with everything when the session ends."""

from __future__ import annotations

import gc
import os
import stat
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from places import ROOT

from nvcore.pictures.recordings import RecordingPictures
from ui.session import lifetime
from ui.session.lifetime import base_folder, process_folder, remove_leftovers
from ui.session.workspace import Workspace, workspace_of


@pytest.fixture(autouse=True)
def base(surroundings: None) -> Path:
    return base_folder()


class _Source:
    name, n, width, height, numbers = "still", 1, 4, 3, None

    def __init__(self) -> None:
        self.times_closed = 0

    def close(self) -> None:
        self.times_closed += 1


def test_a_workspace_is_found_by_its_token_alone():
    space, other = Workspace(), Workspace()
    assert workspace_of(space.token) is space
    assert workspace_of("guess") is None
    assert space.token != other.token
    assert len(space.token) >= 128 / 6  # bits, six in each letter
    assert space.folder != other.folder
    assert space.token not in str(space.folder)
    assert stat.S_IMODE(space.folder.stat().st_mode) == 0o700


def test_the_folder_goes_when_the_session_lets_go_of_the_workspace():
    space = Workspace()
    token, folder = space.token, space.folder
    (folder / "upload.csv").write_text("1")
    del space
    gc.collect()
    assert not folder.exists()
    assert workspace_of(token) is None


def test_a_closed_workspace_is_empty_and_unknown():
    space, made = Workspace(), []
    for _ in range(2):
        space.cached("kind", 1, lambda: made.append(1))
        space.close()
    assert made == [1, 1]
    assert workspace_of(space.token) is None
    assert not space.folder.exists()


def test_pictures_that_several_recordings_share_are_closed_once():
    space, source = Workspace(), _Source()
    space.show(SimpleNamespace(rows=(0, 1)), RecordingPictures({0: source, 1: source}))
    before = space.pictures_version
    space.close_pictures()
    assert source.times_closed == 1
    assert space.pictures.sources == {}
    assert space.pictures_version != before


def test_what_is_kept_is_made_once_and_the_longest_unused_goes():
    space, made = Workspace(), []

    def get(key: int) -> int:
        return space.cached("squares", key, lambda: made.append(key) or key * key, most=2)

    assert [get(2), get(3), get(2), get(4), get(2), get(3)] == [4, 9, 4, 16, 4, 9]
    assert made == [2, 3, 4, 3]


def test_what_a_dead_process_left_is_removed(base: Path):
    code = (
        "import os; from ui.session.workspace import Workspace; space = Workspace(); "
        "(space.folder / 'video.mp4').write_bytes(b'1'); print(space.folder, flush=True); "
        "os._exit(1)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment
    )
    left = Path(done.stdout.strip())
    assert (left / "video.mp4").exists()
    remove_leftovers(base)
    assert list(base.iterdir()) == []
    space = Workspace()
    remove_leftovers(base)
    assert space.folder.exists()  # of a living process


def test_a_leftover_is_removed_by_the_next_process_that_starts(base: Path):
    (base / "0123456789abcdef" / "session").mkdir(parents=True)
    (base / "0123456789abcdef.lock").touch()
    process_folder.cache_clear()
    Workspace()
    assert not (base / "0123456789abcdef").exists()


@pytest.mark.parametrize(
    ("name", "lock"),
    [
        ("holiday", "holiday.lock"),
        ("0123456789abcdef", ""),
        ("0123456789abcdef.photos", "0123456789abcdef.lock"),
    ],
)
def test_a_folder_that_was_not_made_here_stays(base: Path, name: str, lock: str):
    (base / name).mkdir()
    (base / name / "photo.jpg").write_text("1")
    if lock:
        (base / lock).touch()
    remove_leftovers(base)
    assert (base / name / "photo.jpg").exists()


def test_the_folder_for_uploads_may_hold_other_things(base: Path):
    mine = base.parent / "0123456789abcdef"
    mine.mkdir()
    mine.with_suffix(".lock").touch()
    process_folder.cache_clear()
    space = Workspace()
    assert mine.exists()
    assert space.folder.is_relative_to(base)
    assert base.parent == Path(os.environ["NVCORE_UPLOAD_DIR"]).resolve()


def test_a_shared_folder_that_others_may_read_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.delenv("NVCORE_UPLOAD_DIR")
    monkeypatch.setattr(lifetime.tempfile, "tempdir", str(tmp_path))
    trap = tmp_path / f"nvcore-uploads-{os.getuid()}"
    trap.mkdir()
    trap.chmod(0o777)
    assert base_folder() != trap
