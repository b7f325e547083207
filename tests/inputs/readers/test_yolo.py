"""YOLO text: one file per picture, shares of its width and height."""

from __future__ import annotations

from pathlib import Path

import pytest
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError, InputError, MissingFactError, UnnamedClassesError
from nvcore.common.findings import Remedy, Step
from nvcore.inputs.readers.base import LeftOut, Reading, ReadOptions
from nvcore.inputs.readers.yolo import read, recognise

NAMES = [f"drive1/00000{number}.txt" for number in (1, 2, 3)]
SIZE = (640, 480)
PERSON = "0 .5 .5 .1 .1"


def read_golden(**options: object) -> Reading:
    return read(golden("yolo", *NAMES), ReadOptions(**{"size": SIZE, **options}))  # type: ignore[arg-type]


def read_files(folder: Path, files: dict[str, str], **options: object) -> Reading:
    given = [source(folder, text, name) for name, text in files.items()]
    return read(given, ReadOptions(**{"size": SIZE, **options}))  # type: ignore[arg-type]


def read_text(folder: Path, text: str, **options: object) -> Reading:
    return read_files(folder, {"d/1.txt": text}, **options)


def test_shares_become_pixels_and_an_empty_file_an_evaluated_frame() -> None:
    # 0.5 ± 0.125 of 640 and 0.5 ± 0.25 of 480; 0.25 ± 0.05 of 640 and 0.75 ± 0.1 of 480
    reading = read_golden()
    assert rows(reading.boxes, "file frame line x y w h ignore") == [
        [0, 1, 1, 240, 120, 160, 240, False],
        [2, 3, 1, 128, 312, 64, 96, False],
    ]
    assert rows(reading.images, "recording frame") == [["drive1", frame] for frame in (1, 2, 3)]
    assert rows(reading.recordings, "name width height") == [["drive1", 640, 480]]
    assert "class 0 throughout: counted (no names)" in reading.conversion


def test_without_a_size_the_error_asks_for_it() -> None:
    with pytest.raises(MissingFactError, match="the size of the pictures is needed") as raised:
        read_golden(size=None)
    assert raised.value.steps == (Step(Remedy.SIZE),)


def test_several_classes_without_names_are_asked_for(tmp_path: Path) -> None:
    text = "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n0 .2 .2 .1 .1\n"
    reading = read_text(tmp_path, text, classes=("0",))
    assert reading.boxes["line"].tolist() == [1, 3]
    assert reading.left_out == (LeftOut("class", "1", 1),)
    for classes in (None, ("person",)):
        with pytest.raises(UnnamedClassesError, match=r"found class 0 \(2 boxes\), 1 \(1 box\)"):
            read_text(tmp_path, text, classes=classes)


def test_a_class_that_does_not_occur_is_a_finding() -> None:
    reading = read_golden(classes=("7",))
    assert len(reading.boxes) == 0
    only_finding(reading, "no-counted-class")


def test_classes_txt_names_the_classes_and_is_no_picture(tmp_path: Path) -> None:
    files = {
        "classes.txt": "car\nperson\nrider\n",
        "data.yaml": "names: [car, person, rider]\n",
        "d/1.txt": "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n2 .5 .5 .1 .1\n",
    }
    assert recognise("labels/classes.txt", files["classes.txt"], "truth")
    reading = read_files(tmp_path, files)
    assert rows(reading.boxes, "line file ignore") == [[2, 2, False], [3, 2, True]]
    assert "class names from classes.txt" in reading.conversion
    assert "not read as pictures: classes.txt, data.yaml" in reading.conversion
    assert reading.left_out == (LeftOut("class", "car", 1),)


def test_with_names_a_class_is_chosen_by_name_or_number(tmp_path: Path) -> None:
    files = {"classes.txt": "car\nvan\n", "d/1.txt": "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n"}
    assert read_files(tmp_path, files, classes=("van",)).boxes["line"].tolist() == [2]
    assert read_files(tmp_path, files, classes=("1",)).boxes["line"].tolist() == [2]


def test_classes_txt_above_the_labels_is_found(tmp_path: Path) -> None:
    (tmp_path / "classes.txt").write_text("car\nperson\n", encoding="utf-8")
    reading = read_files(tmp_path, {"labels/1.txt": "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n"})
    assert reading.boxes["line"].tolist() == [2]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        # with the confidence second, the first box would reach from 0.05 to 1.15
        ("0 .2 .6 .3 .8 .9\n", "last"),
        # with the confidence last, the box would be 0.6 wide about 0.9
        ("0 .9 .2 .6 .3 .8\n", "second"),
    ],
)
def test_the_confidence_s_field_is_told_from_the_boxes(
    tmp_path: Path, text: str, place: str
) -> None:
    reading = read_text(tmp_path, text, role="detections")
    assert rows(reading.boxes, "score w") == [[0.9, 0.3 * 640]]
    assert f"confidence in the {place} field" in reading.conversion
    assert reading.findings == ()


def test_a_confidence_that_could_be_either_is_reported(tmp_path: Path) -> None:
    reading = read_text(tmp_path, "0 .5 .5 .4 .3 .2\n", role="detections")
    assert reading.boxes["score"].tolist() == [0.2]
    only_finding(reading, "confidence-field")


def test_rows_without_confidence_keep_their_places(tmp_path: Path) -> None:
    text = "0 .9 .2 .6 .3 .8\n0 .2 .6 .3 .8\n"
    boxes = read_text(tmp_path, text, role="detections").boxes
    assert rows(boxes, "w score") == [[0.3 * 640, 0.9], [0.3 * 640, None]]


def test_whole_numbers_in_the_last_field_are_track_ids(tmp_path: Path) -> None:
    reading = read_text(tmp_path, f"{PERSON} 1\n{PERSON} 12\n")
    assert rows(reading.boxes, "track score") == [[1, None], [12, None]]
    assert "last field = track id" in reading.conversion


def test_seven_fields_have_confidence_and_track_id(tmp_path: Path) -> None:
    assert rows(read_text(tmp_path, f"{PERSON} .75 3\n").boxes, "score track") == [[0.75, 3]]


def test_empty_numbers_are_passed_on(tmp_path: Path) -> None:
    assert rows(read_text(tmp_path, "0 nan .5 .1 .1\n").boxes, "x") == [[None]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0 .5 .5 .1 .1\n0 320 240 64 96\n", "line 2: expected shares .*found 320.*pixels"),
        ("0 .5 .5 .1\n", "line 1: expected 5 or 6 or 7 fields .*found 4"),
        ("person .5 .5 .1 .1\n", "line 1: expected numbers .*'person'"),
        ("0.5 .5 .5 .1 .1\n", "line 1: expected a whole number as class number"),
        ("0 .5 .5 .1 .1 .9 1.5\n", "line 1: expected a whole number as track id"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(FormatError, match=r"d/2\.txt, " + message):
        read_files(tmp_path, {"d/1.txt": f"{PERSON}\n", "d/2.txt": text})


@pytest.mark.parametrize(
    ("name", "message"),
    [("left.txt", r"left\.txt: .*frame number"), ("classes.txt", "one text file per picture")],
)
def test_files_that_belong_to_no_picture_are_an_error(
    tmp_path: Path, name: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        read_files(tmp_path, {name: "person\n"})
