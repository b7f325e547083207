"""Which files of a folder are the pictures of a recording, and their numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from picture_files import encoded, number_in, numbered, write_picture, write_zip

from nvcore.common.errors import MediaError
from nvcore.common.findings import Remedy, Step
from nvcore.pictures import open_pictures
from nvcore.pictures.base import Pictures
from nvcore.pictures.index import NumberingRule, map_frames
from nvcore.pictures.notes import PictureNote, PictureTrait
from nvcore.pictures.series import natural_order, series_of

IMG = [f"img_{number:05}.png" for number in range(60)]


def numbers_in(names: list[str]) -> list[int] | None:
    numbers = series_of(names, "drive").numbers
    return None if numbers is None else numbers.tolist()


@pytest.mark.parametrize(
    "stray",
    [
        "calib.png",
        "cover.jpg",
        "mask_2.png",
        "img_00012 (1).png",
        "img_00012 - Kopie.png",
        "img_00012 copy.png",
        "00012.png",
        "img_00012.jpg",
        "IMG_8761.JPG",
        "aaa 5.png",
    ],
)
def test_what_is_not_of_the_series_is_passed_over_and_named(stray: str):
    series = series_of([*IMG, stray], "drive")
    assert (series.names, series.numbers.tolist()) == (IMG, [*range(60)])
    assert series.passed_over == (stray,)


@pytest.mark.parametrize(
    "names",
    [
        ["set06_V000_I00019.png", "set06_V000_I00039.png", "set06_V000_I00059.png"],
        ["I00019_lwir.png", "I00039_lwir.png", "I00059_lwir.png"],
        ["I00019_8bit_640x480.png", "I00039_8bit_640x480.png", "I00059_8bit_640x480.png"],
        ["19.png", "039.png", "59.PNG"],
        ["frame (19).png", "frame (39).png", "frame (59).png"],
        [f"f_{n}_jpg.rf.{n * 7919:032x}.jpg" for n in (19, 39, 59)],
        ["000019_14678192341.png", "000039_14678192361.png", "000059_14678192380.png"],
        ["20230101_120000_0019.png", "20230101_120001_0039.png", "20230101_120002_0059.png"],
        ["day_19.png", "night_39.png", "night_59.png"],
        ["img_19.png", "img_39.jpg", "img_59.png"],
    ],
)  # fmt: skip
def test_the_number_is_the_one_in_which_the_names_differ(names: list[str]):
    assert numbers_in(names) == [19, 39, 59]


@pytest.mark.parametrize(
    "names", [["a.png", "b.png"], ["1.png", "01.png"], ["x1a.png", "b1.png", "1c.png"]]
)
def test_names_that_tell_no_number_are_all_taken_in_their_order(names: list[str]):
    series = series_of(names, "drive")
    assert (series.names, series.numbers) == (sorted(names, key=natural_order), None)


@pytest.mark.parametrize(
    "name",
    [
        lambda n: f"2023-01-05_12-{12 + (n + 50) // 60:02}-{(n + 50) % 60:02}.png",
        lambda n: f"20230105_{121240 + n if n < 20 else 121280 + n}.png",
        lambda n: f"drive_20230105-1212{n // 10:02}_{n % 10 * 100:03}.png",
        lambda n: f"{1600000000 + n // 20}_{n % 20 * 50_000_000:09}.png",
        lambda n: f"{1600000000 + n // 20}.{n % 20 * 50:03}.png",
    ],
)
@pytest.mark.parametrize("n", [40, 63])
def test_times_in_names_are_one_series_in_their_order(name: Callable[[int], str], n: int):
    names = [name(number) for number in range(n)]
    series = series_of([*reversed(names), "calib.png"], "drive")
    assert (series.names, series.passed_over) == (names, ("calib.png",))
    facts = {"n": n, "numbers": series.numbers, "is_video": False, "name": "", "notes": ()}
    pictures = SimpleNamespace(**facts)
    frames = map_frames(np.arange(0, 2 * n, 2), cast(Pictures, pictures))
    assert (frames.rule, frames.index.tolist()) == (NumberingRule.ORDER, [*range(n)])


@pytest.mark.parametrize(
    "name", ["20230105_1212_{:04}.png", "20230105_121200_{:06}.png", "2023-01-05_12-12-00_{}.png"]
)
def test_numbers_behind_a_time_are_frames_also_where_some_are_missing(name: str):
    numbers = [n for n in range(60) if n not in (7, 8, 30)]
    assert numbers_in([name.format(n) for n in numbers]) == numbers


@pytest.mark.parametrize(("width", "copy"), [(4, "img_12.png"), (1, "img_012.png")])
def test_a_number_written_with_other_zeros_is_a_copy(width: int, copy: str):
    names = [f"img_{n:0{width}}.png" for n in range(60)]
    series = series_of([*names, copy], "drive")
    assert (series.names, series.numbers.tolist()) == (names, [*range(60)])
    assert series.passed_over == (copy,)


def test_a_frame_that_was_saved_in_another_format_is_of_the_series():
    names = [*IMG[:12], "img_00012.jpg", *IMG[13:]]
    series = series_of(names, "drive")
    assert (series.numbers.tolist(), series.passed_over) == ([*range(60)], ())
    mask = series_of([*IMG[:12], "mask_00012.png", *IMG[13:]], "drive")
    assert (len(mask.names), mask.passed_over) == (59, ("mask_00012.png",))


TWO = {
    "*.png": [f"FLIR_{n:04}.png" for n in range(20)],
    "*.jpg": [f"FLIR_{n:04}.jpg" for n in range(20)],
}
CAMERAS = {
    "cam0_*.png": [f"cam0_{n}.png" for n in range(20)],
    "cam1_*.png": [f"cam1_{n}.png" for n in range(18)],
}
SPECTRA = {
    "I*_lwir.png": [f"I{n:05}_lwir.png" for n in range(20)],
    "I*_visible.png": [f"I{n:05}_visible.png" for n in range(20)],
}
BEHIND = {
    "*_cam0.png": [f"{n:05}_cam0.png" for n in range(20)],
    "*_cam1.png": [f"{n:05}_cam1.png" for n in range(20)],
}


@pytest.mark.parametrize("kinds", [TWO, CAMERAS, SPECTRA, BEHIND], ids=lambda kinds: min(kinds))
@pytest.mark.parametrize("is_packed", [False, True])
def test_two_series_are_asked_about_and_either_can_be_named(
    tmp_path: Path, kinds: dict[str, list[str]], is_packed: bool
):
    pictures = {
        name: encoded(numbered(n + 100 * which), Path(name).suffix)
        for which, names in enumerate(kinds.values())
        for n, name in enumerate(names)
    }
    place = tmp_path / "two"
    if is_packed:
        write_zip(place, {**pictures, "calib.png": encoded(numbered(1))})
    else:
        place.mkdir()
        for name, content in pictures.items():
            (place / name).write_bytes(content)
    with pytest.raises(MediaError, match="several pictures for the same frame numbers") as error:
        open_pictures(place)
    patterns = [step.value for step in error.value.steps]
    assert sorted(patterns) == sorted(kinds)
    assert error.value.steps[0] == Step(Remedy.PICTURES, patterns[0])
    assert all(pattern in error.value.message for pattern in patterns)
    for which, (pattern, names) in enumerate(kinds.items()):
        chosen = open_pictures(place / pattern)
        assert chosen.numbers.tolist() == [*range(len(names))]
        assert number_in(chosen.read(7)) == 7 + 100 * which


def test_a_pattern_that_nothing_matches_is_an_error(tmp_path: Path):
    write_picture(tmp_path / "img" / "1.png", numbered(1))
    with pytest.raises(MediaError, match=r"img: holds no PNG, .* of the name \*.jpg"):
        open_pictures(tmp_path / "img" / "*.jpg")
    with pytest.raises(MediaError, match="there is no such file or folder of pictures"):
        open_pictures(tmp_path / "none" / "*.jpg")


def test_a_folder_whose_name_looks_like_a_pattern_is_a_folder(tmp_path: Path):
    write_picture(tmp_path / "img [1]" / "1.png", numbered(1))
    assert open_pictures(tmp_path / "img [1]").n == 1


def test_a_cover_beside_the_folder_of_pictures_is_passed_over(tmp_path: Path):
    write_picture(tmp_path / "cover.jpg", numbered(99))
    for n in range(5):
        write_picture(tmp_path / "img1" / f"{n:06}.png", numbered(n))
    pictures = open_pictures(tmp_path)
    assert [number_in(pictures.read(n)) for n in range(5)] == [*range(5)]
    note = PictureNote(PictureTrait.PASSED_OVER, 1, names=("cover.jpg",))
    assert pictures.notes == (note,)


def test_names_from_a_mac_are_found_by_the_same_names(tmp_path: Path):
    composed, decomposed = "Nacht_f\u00fcnf", "Nacht_fu\u0308nf"
    for n in range(3):
        write_picture(tmp_path / decomposed / f"Stra\u00dfe_gru\u0308n_{n}.png", numbered(n))
    pictures = open_pictures(tmp_path / composed)
    assert number_in(pictures.read(2)) == 2
    assert open_pictures(tmp_path / composed / "*gr\u00fcn_1.png").n == 1
    mixed = ["gru\u0308n_1.png", "gr\u00fcn_2.png", "gr\u00fcn_3.png"]
    assert numbers_in(mixed) == [1, 2, 3]


def test_natural_order_takes_numbers_of_any_length():
    names = ["9" * 5000, "1" + "0" * 5000, "007", "8"]
    assert sorted(names, key=natural_order) == ["007", "8", "9" * 5000, "1" + "0" * 5000]
    assert numbers_in(["9" * 5000 + ".png", "1.png"]) is None


def test_a_long_recording_is_numbered():
    names = [f"a_{n}.png" for n in range(50_000)]
    assert np.array_equal(series_of(names, "drive").numbers, np.arange(50_000))
