"""Ground truth of the German Traffic Sign Detection Benchmark."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from reader_files import rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.load import load
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.gtsdb import CLASSES, read
from nvcore.inputs.session import Session, Source
from nvcore.settings.objects import SPEED_SIGN, objects_from

ROWS = """00003.ppm;742;443;765;466;4
00003.ppm;742;466;764;489;9

00005.ppm;10;20;29;39;6
00005.ppm;100;200;119;219;0
"""


def read_rows(folder: Path, content: str = ROWS, **options: object) -> Reading:
    file = source(folder, content, "drive/gt.txt")
    return read([file], ReadOptions(**{"objects": SPEED_SIGN, **options}))  # type: ignore[arg-type]


def test_the_eight_limits_count_and_inclusive_corners_become_width_and_height(tmp_path: Path):
    # class 6, the end of a limit, is no speed sign, and class 9 is no limit
    reading = read_rows(tmp_path)
    assert rows(reading.boxes, "recording frame line x y w h ignore") == [
        ["drive", 3, 1, 742, 443, 24, 24, False],
        ["drive", 5, 5, 100, 200, 20, 20, False],
    ]
    assert "left out: end of speed limit 80 (1), no overtaking (1)" in reading.conversion
    assert reading.findings == ()


def test_the_limit_is_the_label_of_a_sign(tmp_path: Path):
    reading = read_rows(tmp_path)
    assert [reading.labels[code] for code in reading.boxes["label"]] == ["70", "20"]


def test_exactly_the_classes_of_the_benchmarks_readme_are_speed_signs():
    counted = [number for number, name in enumerate(CLASSES) if SPEED_SIGN.counts(name)]
    assert counted == [0, 1, 2, 3, 4, 5, 7, 8]
    assert len(CLASSES) == 43


def test_scenes_without_a_sign_are_frames_where_a_list_names_them(tmp_path: Path):
    source(tmp_path, "00003.ppm\n\n00004.ppm\n00005.ppm\n00009.ppm\n", "drive/scenes.txt")
    reading = read_rows(tmp_path)
    assert rows(reading.images, "recording frame") == [["drive", i] for i in (3, 4, 5, 9)]
    assert "as scenes.txt lists them" in reading.conversion


def test_else_every_picture_beside_the_file_is_a_frame(tmp_path: Path):
    for name in ("00003.ppm", "00007.JPG", "notes.txt", "logo.png"):
        source(tmp_path, "", f"drive/{name}")
    assert rows(read_rows(tmp_path).images, "frame") == [[3], [5], [7]]


def test_without_either_only_scenes_with_a_row_are_frames(tmp_path: Path):
    reading = read_rows(tmp_path)
    assert rows(reading.images, "frame") == [[3], [5]]
    assert "those without a sign are not known" in reading.conversion


def test_classes_are_chosen_by_number_or_name_and_other_limits_are_ignored(tmp_path: Path):
    reading = read_rows(tmp_path, classes=("9", "end of speed limit 80"))
    assert rows(reading.boxes, "line ignore") == [[1, True], [2, False], [4, False], [5, True]]
    with pytest.raises(InputError, match=r"no class 'tree'.*speed limit 20"):
        read_rows(tmp_path, classes=("tree",))


def test_other_objects_are_told_by_the_names_of_the_classes(tmp_path: Path):
    reading = read_rows(tmp_path, "1.ppm;1;1;9;9;14\n", objects=objects_from("stop"))
    assert rows(reading.boxes, "frame") == [[1]]


def test_pedestrians_are_not_among_traffic_signs(tmp_path: Path):
    with pytest.raises(InputError, match="none is called pedestrian") as raised:
        read_rows(tmp_path, objects=objects_from("pedestrian"))
    of_signs = Step(Remedy.OPTION, "speed sign", "objects")
    assert raised.value.steps == (of_signs, Step(Remedy.CLASSES))


@pytest.mark.parametrize(
    ("row", "why"),
    [
        ("1.ppm;1;1;9;9", "expected 6 fields"),
        ("1.ppm;1;1;9;x;1", "expected numbers"),
        ("1.ppm;1;1;9;9;43", "class from 0 to 42, found 43"),
        ("sign.ppm;1;1;9;9;1", "named by a number.*'sign.ppm'"),
    ],
)
def test_a_wrong_row_is_named_by_its_line(tmp_path: Path, row: str, why: str):
    with pytest.raises(FormatError, match=why) as error:
        read_rows(tmp_path, f"1.ppm;1;1;9;9;1\n{row}\n")
    assert error.value.line == 2


def test_a_list_of_scenes_alone_is_no_truth(tmp_path: Path):
    with pytest.raises(InputError, match=r"expected gt\.txt"):
        read([source(tmp_path, "1.ppm\n", "scenes.txt")], ReadOptions(objects=SPEED_SIGN))


@pytest.mark.realdata
@pytest.mark.parametrize(("part", "n_signs", "n_scenes"), [("report", 46, 46), ("train", 238, 248)])
def test_the_shared_part_of_the_benchmark_has_as_many_signs_as_its_readme_says(
    realdata: Path, part: str, n_signs: int, n_scenes: int
):
    truth = Source(os.fspath(realdata / "gtsdb" / part))
    session = Session(
        folder=realdata, truth=truth, systems=(), size=(1360, 800), fps=1, objects=SPEED_SIGN
    )
    dataset = load(session)
    assert (len(dataset.truth), len(dataset.frames)) == (n_signs, n_scenes)
    assert dataset.truth.w.min() >= 18
    assert dataset.findings == ()
