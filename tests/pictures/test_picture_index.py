"""Which picture shows which frame, and how that is told."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from picture_files import numbered, write_numbered_video, write_picture

from nvcore.pictures import Pictures, open_pictures, picture_index, size_note


def folder_of(folder: Path, names: list[str]) -> Pictures:
    for name in names:
        write_picture(folder / f"{name}.png", numbered(1))
    return open_pictures(folder)


def index_of(frames: list[int], pictures: Pictures, first: int | None = None) -> tuple[list, str]:
    index, note = picture_index(np.array(frames, dtype=np.int64), pictures, first)
    assert index.dtype == np.int64
    return index.tolist(), note


IN_A_NAME = "The number in a picture's name"


@pytest.mark.parametrize(
    ("frames", "first", "expected", "note"),
    [
        ([0, 2, 4], None, [0, 2, 4], r"Picture i shows frame i, both counted from 0\.$"),
        (
            [-1, 3, 4, 5, 9],
            None,
            [-1, 3, 4, -1, -1],
            r"3 of 5 listed frames have no picture \(5 pictures in a\.mp4\)\.$",
        ),
        ([1, 2, 5], None, [0, 1, 4], r"the frames count from 1\.$"),
        (
            [2330, 2332, 2340],
            2330,
            [0, 2, -1],
            r"^The first picture shows frame 2330, as given\. 1 of 3 listed",
        ),
    ],
)
def test_pictures_of_a_video_are_counted(
    tmp_path: Path, frames: list[int], first: int | None, expected: list[int], note: str
):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=5))
    index, text = index_of(frames, video, first)
    assert index == expected
    assert re.search(note, text)


@pytest.mark.parametrize(
    ("names", "frames", "first", "expected", "note"),
    [
        (["I00019", "I00039", "I00059"], [19, 59], None, [0, 2], f"{IN_A_NAME} is the frame."),
        (
            ["000001", "000002", "000003"],
            [0, 1, 2],
            None,
            [0, 1, 2],
            f"{IN_A_NAME}, less one, is the frame (names that count from 1).",
        ),
        (["1", "2", "3", "4"], [1, 2, 3], None, [0, 1, 2], "less one would do as well"),
        (
            ["10", "12", "13"],
            [10, 11, 12, 13],
            None,
            [0, -1, 1, 2],
            "1 of 4 listed frames have no picture (3 pictures",
        ),
        (["000001", "000002"], [0, 1], 1, [-1, 0], "as given"),
        (["1"], [], None, [], ""),
    ],
    ids=[
        "the frame",
        "counted from 1",
        "both would fit",
        "files are missing",
        "the first as given",
        "no frames",
    ],
)
def test_numbers_in_names_are_frames_where_all_frames_are_among_them(
    tmp_path: Path,
    names: list[str],
    frames: list[int],
    first: int | None,
    expected: list[int],
    note: str,
):
    index, text = index_of(frames, folder_of(tmp_path, names), first)
    assert index == expected
    assert note in text


@pytest.mark.parametrize("names", [["501", "502", "503"], ["a", "b", "c"]])
def test_names_that_do_not_fit_give_way_to_the_order(tmp_path: Path, names: list[str]):
    pictures = folder_of(tmp_path, names)
    note = "The pictures in their order show the listed frames."
    assert index_of([0, 20, 40], pictures) == ([0, 1, 2], note)
    index, note = index_of([0, 2], pictures)
    assert (index, note) == ([0, 2], "The pictures in their order show frame 0, 1, 2 and so on.")


def test_what_is_wrong_with_a_video_is_in_the_note(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.avi", "mjpeg", pixels="yuvj420p")
    path.write_bytes(path.read_bytes()[:40_000])
    video = open_pictures(path)
    note = index_of(list(range(100)), video)[1]
    assert f"{100 - video.n} of 100 listed frames have no picture ({video.n} pictures in" in note
    assert f"a.avi: the video is cut off or damaged; {video.n} of 100 pictures can be" in note


def test_pictures_of_another_size_are_told(tmp_path: Path):
    pictures = folder_of(tmp_path, ["1"])
    assert size_note(pictures, 64, 48) == ""
    assert size_note(pictures, 640, 480) == (
        "The pictures are 64 x 48 px, the recording is 640 x 480 px: boxes are drawn scaled."
    )
    assert "by 0.1 across and 0.2 down; check that they belong together" in size_note(
        pictures, 640, 240
    )
