"""YOLO text: one file per picture, shares of its width and height."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError, MissingFactError
from nvcore.inputs.readers.base import Reading, ReadOptions, SourceFile
from nvcore.inputs.readers.yolo import FORMAT, read, recognise

FOLDER = DATA / "yolo"
NAMES = ("drive1/000001.txt", "drive1/000002.txt", "drive1/000003.txt")
SIZE = (640, 480)


def golden(**options: object) -> Reading:
    files = [SourceFile(FOLDER / name, name) for name in NAMES]
    return read(files, ReadOptions(**{"size": SIZE, **options}))  # type: ignore[arg-type]


def read_files(tmp_path: Path, files: dict[str, str], **options: object) -> Reading:
    given = []
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
        given.append(SourceFile(tmp_path / name, name))
    return read(given, ReadOptions(**{"size": SIZE, **options}))  # type: ignore[arg-type]


def test_shares_become_pixels() -> None:
    boxes = golden().boxes
    # 0.5 ± 0.125 of 640 and 0.5 ± 0.25 of 480; 0.25 ± 0.05 of 640 and 0.75 ± 0.1 of 480
    assert boxes[["x", "y", "w", "h"]].to_numpy() == pytest.approx(
        np.array([[240, 120, 160, 240], [128, 312, 64, 96]])
    )
    assert boxes["line"].tolist() == [1, 1]
    assert boxes["file"].tolist() == [0, 2]


def test_an_empty_file_is_an_evaluated_frame() -> None:
    reading = golden()
    assert reading.boxes["frame"].tolist() == [1, 3]
    assert reading.images is not None
    assert reading.images[["recording", "frame"]].to_numpy().tolist() == [
        ["drive1", 1],
        ["drive1", 2],
        ["drive1", 3],
    ]


def test_the_size_is_that_of_the_recording() -> None:
    recordings = golden().recordings
    assert recordings[["name", "width", "height"]].to_numpy().tolist() == [["drive1", 640, 480]]


def test_without_a_size_the_error_names_the_flag() -> None:
    with pytest.raises(MissingFactError, match="--size WIDTHxHEIGHT"):
        golden(size=None)


def test_class_0_counts_and_others_are_left_out() -> None:
    reading = golden()
    assert "classes: 0 counted" in reading.conversion
    assert "left out: 1 (1)" in reading.conversion
    assert not reading.boxes["ignore"].any()


def test_other_class_numbers_can_be_chosen() -> None:
    assert golden(classes=("0", "1")).boxes["frame"].tolist() == [1, 1, 3]


def test_a_class_that_does_not_occur_is_a_finding() -> None:
    reading = golden(classes=("7",))
    assert len(reading.boxes) == 0
    assert [one.code for one in reading.findings] == ["no-counted-class"]


def test_class_names_need_a_list_of_names() -> None:
    with pytest.raises(InputError, match=r"class numbers, found the class 'person'.*classes\.txt"):
        golden(classes=("person",))


def test_classes_txt_names_the_classes_and_is_no_picture(tmp_path: Path) -> None:
    files = {
        "classes.txt": "car\nperson\nrider\n",
        "data.yaml": "names: [car, person, rider]\n",
        "d/1.txt": "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n2 .5 .5 .1 .1\n",
    }
    reading = read_files(tmp_path, files)
    assert reading.boxes[["line", "file", "ignore"]].to_numpy().tolist() == [
        [2, 2, False],
        [3, 2, True],
    ]
    assert "class names from classes.txt" in reading.conversion
    assert "not read as pictures: classes.txt, data.yaml" in reading.conversion
    assert "left out: car (1)" in reading.conversion


def test_with_names_a_class_is_chosen_by_name_or_number(tmp_path: Path) -> None:
    files = {"classes.txt": "car\nvan\n", "d/1.txt": "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n"}
    assert read_files(tmp_path, files, classes=("van",)).boxes["line"].tolist() == [2]
    assert read_files(tmp_path, files, classes=("1",)).boxes["line"].tolist() == [2]


def test_classes_txt_above_the_labels_is_found(tmp_path: Path) -> None:
    (tmp_path / "classes.txt").write_text("car\nperson\n", encoding="utf-8")
    reading = read_files(tmp_path, {"labels/1.txt": "0 .5 .5 .1 .1\n1 .5 .5 .1 .1\n"})
    assert reading.boxes["line"].tolist() == [2]


def test_a_confidence_in_the_last_field_is_told_from_the_boxes(tmp_path: Path) -> None:
    # with the confidence second, the first box would reach from 0.05 to 1.15
    reading = read_files(tmp_path, {"d/1.txt": "0 .2 .6 .3 .8 .9\n"}, role="detections")
    assert reading.boxes["score"].tolist() == [0.9]
    assert reading.boxes["w"].tolist() == pytest.approx([0.3 * 640])
    assert "confidence in the last field" in reading.conversion
    assert reading.findings == ()


def test_a_confidence_in_the_second_field_is_told_from_the_boxes(tmp_path: Path) -> None:
    # with the confidence last, the box would be 0.6 wide about 0.9
    reading = read_files(tmp_path, {"d/1.txt": "0 .9 .2 .6 .3 .8\n"}, role="detections")
    assert reading.boxes["score"].tolist() == [0.9]
    assert reading.boxes["w"].tolist() == pytest.approx([0.3 * 640])
    assert "confidence in the second field" in reading.conversion


def test_a_confidence_that_could_be_either_is_reported(tmp_path: Path) -> None:
    reading = read_files(tmp_path, {"d/1.txt": "0 .5 .5 .4 .3 .2\n"}, role="detections")
    assert reading.boxes["score"].tolist() == [0.2]
    assert [one.code for one in reading.findings] == ["confidence-field"]


def test_rows_without_confidence_keep_their_places(tmp_path: Path) -> None:
    text = "0 .9 .2 .6 .3 .8\n0 .2 .6 .3 .8\n"
    boxes = read_files(tmp_path, {"d/1.txt": text}, role="detections").boxes
    assert boxes["w"].tolist() == pytest.approx([0.3 * 640] * 2)
    assert boxes["score"].isna().tolist() == [False, True]


def test_whole_numbers_in_the_last_field_are_track_ids(tmp_path: Path) -> None:
    reading = read_files(tmp_path, {"d/1.txt": "0 .5 .5 .1 .1 1\n0 .5 .5 .1 .1 12\n"})
    assert reading.boxes["track"].tolist() == [1, 12]
    assert reading.boxes["score"].isna().all()
    assert "last field = track id" in reading.conversion


def test_seven_fields_have_confidence_and_track_id(tmp_path: Path) -> None:
    boxes = read_files(tmp_path, {"d/1.txt": "0 .5 .5 .1 .1 .75 3\n"}).boxes
    assert boxes[["score", "track"]].to_numpy().tolist() == [[0.75, 3]]


def test_empty_numbers_are_passed_on(tmp_path: Path) -> None:
    boxes = read_files(tmp_path, {"d/1.txt": "0 nan .5 .1 .1\n"}).boxes
    assert boxes["x"].isna().all()


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
        read_files(tmp_path, {"d/1.txt": "0 .5 .5 .1 .1\n", "d/2.txt": text})


def test_a_file_name_without_number_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"left\.txt: .*frame number"):
        read_files(tmp_path, {"left.txt": ""})


def test_nothing_but_class_names_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="one text file per picture"):
        read_files(tmp_path, {"classes.txt": "person\n"})


def test_own_files_are_recognised_and_no_others() -> None:
    assert recognise("1.txt", "0 0.5 0.5 0.25 0.5\n", "truth")
    assert recognise("1.txt", "0 0.5 0.5 0.25 0.5 0.9\n", "detections")
    assert recognise("labels/classes.txt", "car\nperson\n", "truth")
    assert not recognise("1.txt", "", "truth")
    assert not recognise("1.txt", "1,1,1,1,1,1,1\n", "truth")
    assert not recognise("1.txt", "0 320 240 64 96\n", "truth")
    assert not recognise("1.txt", '"0" "0.5" "0.5" "0.1" "0.1"\n', "truth")
    assert not recognise("1.txt", "Car 0.0 0 -1.5 1 2 3 4 1 1 1 1 1 1 1\n", "truth")
    assert not recognise("train.txt", "images/1.jpg\n", "truth")
    assert FORMAT.name == "yolo"
