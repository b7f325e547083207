"""Which picture shows which frame, and how that is told."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pandas as pd
import pytest
from builders import Place, make_dataset
from picture_files import number_in, numbered, write_numbered_video, write_picture

import nvcore as nv
from nvcore.pictures import Pictures, map_frames, open_pictures, size_note
from nvcore.pictures.index import NumberingRule
from nvcore.pictures.recordings import RecordingPictures, picture_names


def folder_of(folder: Path, names: list[str]) -> Pictures:
    for name in names:
        write_picture(folder / f"{name}.png", numbered(1))
    return open_pictures(folder)


def index_of(frames: list[int], pictures: Pictures, first: int | None = None) -> tuple[list, str]:
    mapped = map_frames(np.array(frames, dtype=np.int64), pictures, first)
    assert mapped.index.dtype == np.int64
    return mapped.index.tolist(), mapped.note


@pytest.mark.parametrize(
    ("frames", "right", "words"),
    [
        ([0, 2, 4], [0, 2, 4], "Picture i shows frame i, both counted from 0."),
        (
            [-1, 3, 4, 5, 9],
            [-1, 3, 4, -1, -1],
            "3 of 5 listed frames have no picture (5 pictures in a.mp4).",
        ),
        ([1, 2, 5], [0, 1, 4], "the frames count from 1."),
        ([0, 2, 4, 6, 8], [*range(5)], "in their order show the listed frames."),
        ([*range(100, 105)], [*range(5)], "in their order show the listed frames."),
    ],
)
def test_pictures_of_a_video_are_counted(
    tmp_path: Path, frames: list[int], right: list[int], words: str
):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=5))
    index, note = index_of(frames, video)
    assert index == right
    assert note.endswith(words)


RECORDED = [*range(20), *range(30, 60)]


@pytest.fixture
def video_with_a_gap(tmp_path: Path) -> Pictures:
    return open_pictures(write_numbered_video(tmp_path / "a.mp4", n=50, times=RECORDED))


@pytest.mark.parametrize("fps", [20, 20.02, None])
@pytest.mark.parametrize("start", [0, 1])
def test_where_pictures_were_not_recorded_times_tell_the_frame(video_with_a_gap, start, fps):
    frames = np.arange(start, 60 + start)
    mapped = map_frames(frames, video_with_a_gap, fps=fps)
    index, note = mapped.index, mapped.note
    numbers = [number_in(video_with_a_gap.read(at)) for at in index[index >= 0]]
    assert numbers == [*range(50)]
    assert (frames[index >= 0] - start).tolist() == RECORDED
    assert note.startswith("The time of each picture tells its frame, as pictures are missing")
    assert "10 of 60 listed frames have no picture" in note


@pytest.mark.parametrize(
    ("frames", "fps", "first", "right"),
    [
        ([0, 20, 49], 20, None, [0, 20, 49]),  # as programs count that decode the video
        ([1, 20, 50], 20, None, [0, 19, 49]),
        ([0, 20, 59], 17, None, [0, 20, -1]),  # the times are no frames of this rate
        ([100, 130, 159], 20, 100, [0, 20, 49]),
        ([100, 130, 149], 20, 100, [0, 30, 49]),
    ],
)
def test_times_count_only_where_frames_go_beyond_the_pictures(
    video_with_a_gap, frames, fps, first, right
):
    index = map_frames(np.array(frames), video_with_a_gap, first, fps=fps).index
    assert index.tolist() == right


def test_the_frame_of_the_first_picture_goes_before_every_rule(tmp_path: Path):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=5))
    index, note = index_of([2330, 2332, 2340], video, 2330)
    assert index == [0, 2, -1]
    assert note.startswith("The first picture shows frame 2330, as given. 1 of 3 listed")
    pictures = folder_of(tmp_path / "b", ["000001", "000002"])
    assert index_of([0, 1], pictures, 1)[0] == [-1, 0]


@pytest.mark.parametrize(
    ("frames", "names", "right", "words"),
    [
        ([19, 59], ["I00019", "I00039", "I00059"], [0, 2], "a picture's name is the frame."),
        (
            [0, 1, 2],
            ["000001", "000002", "000003"],
            [0, 1, 2],
            "a picture's name, minus one, is the frame (names that count from 1).",
        ),
        ([1, 2, 3], ["1", "2", "3", "4"], [0, 1, 2], "minus one would do as well"),
        ([10, 11, 12, 13], ["10", "12", "13"], [0, -1, 1, 2], "1 of 4 listed frames have no pict"),
    ],
)
def test_the_number_in_a_name_is_the_frame(
    tmp_path: Path, frames: list[int], names: list[str], right: list[int], words: str
):
    index, note = index_of(frames, folder_of(tmp_path, names))
    assert index == right
    assert note.startswith("The number in a picture's name")
    assert words in note


@pytest.mark.parametrize("names", [["501", "502", "503"], ["a", "b", "c"]])
def test_names_that_do_not_fit_give_way_to_the_order(tmp_path: Path, names: list[str]):
    pictures = folder_of(tmp_path, names)
    note = "The pictures in their order show the listed frames."
    assert index_of([0, 20, 40], pictures) == ([0, 1, 2], note)
    index, note = index_of([0, 2], pictures)
    assert (index, note) == ([0, 2], "The pictures in their order show frame 0, 1, 2 and so on.")


@pytest.mark.parametrize(
    ("frames", "numbers", "right"),
    [
        # every second frame was exported, and numbered anew
        (range(0, 120, 2), range(1, 61), range(60)),
        (range(0, 120, 2), range(60), range(60)),
        (range(0, 300, 5), range(1, 61), range(60)),
        # the frames count from 0, the pictures have the numbers of the whole drive
        (range(60), range(30, 90), range(60)),
        (range(60), range(5000, 5060), range(60)),
        # pictures of the whole drive, of which a part is evaluated, and the other way round
        (range(30, 60), range(100), range(30, 60)),
        (range(100), range(30, 60), [*[-1] * 30, *range(30), *[-1] * 40]),
        (range(19, 1019, 20), range(110), [19, 39, 59, 79, 99, *[-1] * 45]),
        # pictures were lost here and there
        (range(9), [0, 1, 3, 4, 5, 6, 7, 8, 9, 10], [0, 1, -1, 2, 3, 4, 5, 6, 7]),
        (range(9), [1, 2, 4, 5, 6, 7, 8, 9, 10, 11], [0, 1, -1, 2, 3, 4, 5, 6, 7]),
        # it cannot be told
        (range(60), range(30, 100), [-1] * 60),
        (range(0, 120, 2), range(1, 60), [-1] * 60),
        (range(0, 120, 2), range(1, 62), [-1] * 60),
        (range(0, 300, 5), range(70), [-1] * 60),
        (range(60), range(501, 1501), [-1] * 60),
        (range(4), [1000, 1001, 1007, 1008], [-1] * 4),
    ],
)  # fmt: skip
def test_every_frame_shows_its_own_picture_or_none(
    frames: Sequence[int], numbers: Sequence[int], right: Sequence[int]
):
    index, rule = mapped(frames, numbers)
    assert index == [*right]
    assert (rule is NumberingRule.UNCLEAR) == ({*right} == {-1})


def mapped(frames: Sequence[int], numbers: Sequence[int]) -> tuple[list[int], NumberingRule]:
    facts = {"n": len(numbers), "numbers": np.array(numbers), "is_video": False}
    pictures = cast(Pictures, SimpleNamespace(**facts, name="", notes=()))
    result = map_frames(np.array(frames), pictures)
    return result.index.tolist(), result.rule


@pytest.mark.parametrize("first", [0, 1])
def test_names_from_one_begin_with_the_first_frame_also_where_the_last_ones_are_missing(first: int):
    index, rule = mapped(range(200), range(first, first + 100))
    assert index == [*range(100), *[-1] * 100]
    assert rule is (NumberingRule.NUMBER_LESS_ONE if first else NumberingRule.NUMBER)


def test_what_does_not_fit_is_said_with_its_numbers(tmp_path: Path):
    pictures = folder_of(tmp_path, [f"{n:03}" for n in range(30, 50)])
    index, note = index_of([*range(40)], pictures)
    assert index == [-1] * 40
    assert note == (
        "Which picture shows which frame is not clear, so that none is shown. There are 20 "
        "pictures for 40 frames (0 to 39), and the numbers in the pictures' names (30 to 49) are "
        "those of 10 of these frames."
    )
    nameless = folder_of(tmp_path / "b", ["a", "b"])
    assert index_of([0, 5], nameless)[0] == [0, 1]
    assert (
        "2 pictures for 3 frames (0 to 5), and the pictures' names have no numbers."
        in (index_of([0, 3, 5], nameless)[1])
    )


def test_a_recording_without_frames_has_no_pictures(tmp_path: Path):
    assert index_of([], folder_of(tmp_path, ["1"]))[0] == []


def test_what_is_wrong_with_a_video_is_in_the_note(tmp_path: Path):
    path = write_numbered_video(tmp_path / "a.avi", "mjpeg", pixels="yuvj420p")
    path.write_bytes(path.read_bytes()[:40_000])
    video = open_pictures(path)
    note = index_of(list(range(100)), video)[1]
    assert f"{100 - video.n} of 100 listed frames have no picture ({video.n} pictures in" in note
    assert f"a.avi: {video.n} pictures of 100 can be read: the file is damaged" in note


def test_pictures_of_another_size_are_told(tmp_path: Path):
    pictures = folder_of(tmp_path, ["1"])
    assert size_note(pictures, 64, 48) == ""
    assert size_note(pictures, 640, 480) == (
        "The pictures are 64 x 48 px, the recording is 640 x 480 px: boxes are drawn scaled."
    )
    assert "by 0.1 across and 0.2 down; check that they belong together" in size_note(
        pictures, 640, 240
    )


def test_frames_have_the_names_of_their_picture_files_and_those_of_a_video_none(tmp_path: Path):
    folder = folder_of(tmp_path / "a", ["I00019", "I00039", "I00059"])
    video = open_pictures(write_numbered_video(tmp_path / "b.mp4", n=5))
    made = make_dataset(places=[Place([19, 20, 59]), Place(range(5))])
    indices = {0: np.array([0, -1, 2]), 1: np.arange(5)}
    pictures = RecordingPictures({0: folder, 1: video}, indices)
    names = picture_names(made.frame_columns, [2, 0, 1, 4, 2], pictures)
    assert names == {0: "I00019.png", 2: "I00059.png"}
    assert picture_names(made.frame_columns, [], pictures) == {}


@pytest.mark.parametrize("chosen", [[1, 2], [3], [1, 3, 5]])
def test_a_selection_of_frames_changes_no_rule(tmp_path: Path, chosen: list[int]):
    video = open_pictures(write_numbered_video(tmp_path / "a.mp4", n=5))
    every = np.arange(1, 6)
    listed = np.array(chosen)
    index = map_frames(listed, video, others=np.setdiff1d(every, listed)).index
    assert index.tolist() == [frame - 1 for frame in chosen]
    pictures = folder_of(tmp_path / "b", ["000001", "000002", "000003"])  # of frames 0 to 2
    index = map_frames(np.array([1, 2]), pictures, others=np.array([0])).index
    assert index.tolist() == [1, 2]


def test_the_frames_that_are_not_evaluated_are_those_of_the_truth(tmp_path: Path):
    truth = pd.DataFrame({"frame": range(1, 6), "x": 5.0, "y": 5.0, "w": 5.0, "h": 9.0})
    dataset = nv.load(
        truth=truth, x=truth.assign(frame=7), size=(64, 64), fps=5, frames=range(2, 4)
    )
    (name,) = dataset.recordings["name"]
    assert dataset.unlisted_frames(name).tolist() == [1, 4, 5]
