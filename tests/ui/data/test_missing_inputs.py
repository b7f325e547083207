"""Inputs that a person gives: the size proposed, and what they add to a session."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from places import ROOT
from streamlit.testing.v1 import AppTest

from nvcore.errors import SessionError
from nvcore.inputs.session import Session, Source
from pages import TIMEOUT_S
from ui.data import missing_inputs
from ui.data.missing_inputs import MissingInputs, check_pictures, picture_rate, picture_size

VIDEO = ROOT / "sample_data" / "odd_pose.mp4"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Path]:
    """What was opened, in turn."""
    found: list[Path] = []
    real = missing_inputs.open_pictures

    def counted(path: Path):
        found.append(path)
        return real(path)

    monkeypatch.setattr(missing_inputs, "open_pictures", counted)
    return found


def test_a_video_is_opened_once_for_its_size(tmp_path: Path, opened: list[Path]):
    video = Path(shutil.copy(VIDEO, tmp_path / "drive.mp4"))
    assert [picture_size([video]) for _ in range(3)] == [(640, 480)] * 3
    assert opened == [video]


def test_a_video_that_was_replaced_is_opened_again(tmp_path: Path, opened: list[Path]):
    video = Path(shutil.copy(VIDEO, tmp_path / "drive.mp4"))
    picture_size([video])
    os.utime(video, ns=(1, 1))
    picture_size([video])
    assert opened == [video, video]


def test_the_size_is_that_of_the_first_that_can_be_opened(tmp_path: Path):
    (tmp_path / "no.mp4").write_bytes(b"no video")
    assert picture_size([tmp_path / "gone.mp4", tmp_path / "no.mp4", VIDEO]) == (640, 480)


def test_pictures_that_cannot_be_opened_say_why(tmp_path: Path):
    (tmp_path / "no.mp4").write_bytes(b"no video")
    assert "is text, not pictures" in check_pictures(tmp_path / "no.mp4").trouble
    assert "No such file" in check_pictures(tmp_path / "gone.mp4").trouble


def test_the_rate_is_that_of_the_first_video(tmp_path: Path):
    assert picture_rate([tmp_path / "gone.mp4", VIDEO]) == 20
    assert picture_rate([tmp_path / "gone.mp4"]) is None


def test_facts_fill_what_a_session_leaves_open():
    session = Session(Path("/drives"), Source(("t.csv",)), (), fps=10, frames="0:9")
    filled = MissingInputs(size=(640, 480), frames="0:99").added_to(session)
    assert (filled.size, filled.fps, filled.frames) == ((640, 480), 10, "0:99")


def test_frames_added_to_a_session_are_a_range_and_no_file():
    session = Session(Path("/drives"), Source(("t.csv",)), ())
    with pytest.raises(SessionError, match="expected FIRST:LAST"):
        MissingInputs(frames="/etc/passwd").added_to(session)


def test_a_folder_of_pictures_that_was_mended_in_place_is_opened_again(tmp_path: Path):
    picture = tmp_path / "pictures" / "0.png"
    picture.parent.mkdir()
    picture.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    assert check_pictures(picture.parent).trouble
    cv2.imwrite(str(picture), np.zeros((48, 64), np.uint8))
    assert check_pictures(picture.parent).size == (64, 48)


def size_in_a_session(path: str) -> None:
    from pathlib import Path

    import streamlit as st

    from ui.data.missing_inputs import picture_size

    st.text(str(picture_size([Path(path)])))


def test_what_pictures_are_is_kept_for_one_session(tmp_path: Path, opened: list[Path]):
    video = shutil.copy(VIDEO, tmp_path / "drive.mp4")
    mine, other = (
        AppTest.from_function(size_in_a_session, args=(str(video),), default_timeout=TIMEOUT_S)
        for _ in range(2)
    )
    mine.run().run()
    assert len(opened) == 1
    assert other.run().text[0].value == "(640, 480)"
    assert len(opened) == 2
