"""Inputs that a person gives: the size proposed, and what they add to a session."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from places import ROOT

from nvcore.common.errors import SessionError
from nvcore.inputs.session import Session, Source
from pages import scripted
from ui.confined.pictures import PictureProcess
from ui.views.data.missing_inputs import MissingInputs, PictureCheck, check_pictures

VIDEO = ROOT / "sample_data" / "odd_pose.mp4"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """What was opened, in turn."""
    paths: list[Path] = []
    real = PictureProcess.open

    def counted(process: PictureProcess, path: Path):
        paths.append(path)
        return real(process, path)

    monkeypatch.setattr(PictureProcess, "open", counted)
    return paths


def test_a_video_is_opened_once_for_its_size_and_again_when_it_was_replaced(
    tmp_path: Path, opened: list[Path]
):
    video = Path(shutil.copy(VIDEO, tmp_path / "drive.mp4"))
    assert [check_pictures(video).size for _ in range(3)] == [(640, 480)] * 3
    assert opened == [video]
    os.utime(video, ns=(1, 1))
    check_pictures(video)
    assert opened == [video, video]


def test_pictures_have_a_size_and_a_rate_or_say_why_they_cannot_be_opened(tmp_path: Path):
    gone, text = tmp_path / "gone.mp4", tmp_path / "no.mp4"
    text.write_bytes(b"no video")
    assert check_pictures(VIDEO) == PictureCheck((640, 480), 20)
    assert "is text, not pictures" in check_pictures(text).trouble
    assert "No such file" in check_pictures(gone).trouble


def test_facts_fill_what_a_session_leaves_open():
    session = Session(Path("/drives"), Source(("t.csv",)), (), fps=10, frames="0:9")
    filled = MissingInputs(size=(640, 480), frames="0:99").added_to(session)
    assert (filled.size, filled.fps, filled.frames) == ((640, 480), 10, "0:99")


def test_frames_added_to_a_session_are_a_range_and_no_file():
    session = Session(Path("/drives"), Source(("t.csv",)), ())
    with pytest.raises(SessionError, match="expected first:last"):
        MissingInputs(frames="/etc/passwd").added_to(session)


def test_a_folder_of_pictures_that_was_mended_in_place_is_opened_again(tmp_path: Path):
    picture = tmp_path / "pictures" / "0.png"
    picture.parent.mkdir()
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    assert check_pictures(picture.parent).trouble
    cv2.imwrite(str(picture), np.zeros((48, 64), np.uint8))
    assert check_pictures(picture.parent).size == (64, 48)


def test_what_pictures_are_is_kept_for_one_session(tmp_path: Path, opened: list[Path]):
    video = Path(shutil.copy(VIDEO, tmp_path / "drive.mp4"))
    script = "from pathlib import Path\nfrom ui.views.data.missing_inputs import check_pictures\n"
    script += f"assert check_pictures(Path({str(video)!r})).size == (640, 480)\n"
    scripted(script).run().run()
    assert len(opened) == 1
    assert not scripted(script).run().exception
    assert len(opened) == 2
