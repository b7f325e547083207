"""Caltech and KAIST ground truth as bbGt text."""

from __future__ import annotations

from pathlib import Path

import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.caltech.boxes import read, recognise

GOLDEN = DATA / "bbgt"
FRAMES = ("I00019.txt", "I00039.txt", "I00059.txt")


def golden() -> list[SourceFile]:
    return [SourceFile(GOLDEN / "set06/V000" / name, f"set06/V000/{name}") for name in FRAMES]


def source(tmp_path: Path, content: str, name: str = "set06/V000/I00019.txt") -> SourceFile:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return SourceFile(path, name)


def test_boxes_are_kept_as_they_are():
    first = read(golden(), ReadOptions()).boxes.iloc[0]
    assert first[["x", "y", "w", "h"]].tolist() == [505, 212, 20, 50]
    assert (first["recording"], first["frame"], first["line"]) == ("set06/V000", 19, 2)


def test_a_frame_without_boxes_is_an_evaluated_frame():
    # peers.md 29, 30: frames without boxes were dropped elsewhere
    images = read(golden(), ReadOptions()).images
    assert images["frame"].tolist() == [19, 39, 59]
    assert images["image_id"].tolist() == [1, 2, 3]


def test_people_doubtful_people_cyclists_and_flagged_persons_are_ignore_regions():
    boxes = read(golden(), ReadOptions()).boxes
    ignored = boxes.loc[boxes["ignore"], "x"]
    assert ignored.tolist() == [160, 210, 240, 270]


def test_a_marked_false_alarm_is_left_out_and_that_is_said():
    reading = read(golden(), ReadOptions())
    assert 300 not in reading.boxes["x"].tolist()
    assert "person counted; people, person?, cyclist" in reading.conversion
    assert "others left out" in reading.conversion
    assert reading.findings == ()


def test_occlusion_levels_of_kaist_are_kept():
    boxes = read(golden(), ReadOptions()).boxes
    assert boxes.loc[boxes["frame"] == 19, "occlusion"].tolist()[:3] == [0, 1, 2]


def test_the_visible_box_makes_a_level_of_the_flag_of_caltech():
    boxes = read(golden(), ReadOptions()).boxes
    # 0.2 hidden; 0.5 hidden; flagged with the visible box equal to the box: nothing visible
    assert boxes.loc[boxes["frame"] == 59, "occlusion"].tolist() == [1, 2, 2]


def test_the_classes_that_count_can_be_named():
    boxes = read(golden(), ReadOptions(classes=("Cyclist",))).boxes
    assert boxes.loc[~boxes["ignore"], "x"].tolist() == [240]


def test_an_unknown_class_is_answered_with_the_known_and_the_found_ones(tmp_path):
    file = source(tmp_path, "rider 1 2 3 4 0 0 0 0 0\n")
    with pytest.raises(InputError, match=r"no class 'dog'; the classes are person, .*have rider"):
        read([file], ReadOptions(classes=("dog",)))


def test_a_class_that_only_the_files_have_can_count(tmp_path):
    file = source(tmp_path, "rider 1 2 3 4 0 0 0 0 0\n")
    reading = read([file], ReadOptions(classes=("rider",)))
    assert reading.boxes["ignore"].tolist() == [False]
    assert reading.findings == ()


def test_rows_of_a_class_that_the_format_does_not_have_are_reported(tmp_path):
    content = "% bbGt version=3\nperson 1 2 3 4 0 0 0 0 0 0 0\ntree 1 2 3 4 0 0 0 0 0 0 0\n"
    (finding,) = read([source(tmp_path, content)], ReadOptions()).findings
    assert (finding.code, finding.count, finding.example) == ("unknown-class", 1, "line 3: tree")


def test_files_of_which_no_row_counts_are_reported(tmp_path):
    (finding,) = read([source(tmp_path, "cyclist 1 2 3 4 0 0 0 0 0\n")], ReadOptions()).findings
    assert finding.code == "no-counted-class"
    assert "found cyclist" in finding.message


@pytest.mark.parametrize(
    ("version", "rest"), [(None, ""), (1, ""), (2, " 1"), (3, " 1 0")], ids=["v0", "v1", "v2", "v3"]
)
def test_all_versions_are_read(tmp_path, version, rest):
    header = "" if version is None else f"% bbGt version={version}\n"
    text = f"{header}person 1 2 3 4 0 0 0 0 0{rest}\n"
    assert recognise("I00019.txt", text, "truth")
    boxes = read([source(tmp_path, text)], ReadOptions()).boxes
    assert boxes[["x", "y", "w", "h"]].iloc[0].tolist() == [1, 2, 3, 4]
    assert boxes["ignore"].tolist() == [rest != ""]


def test_a_rotated_box_is_reported(tmp_path):
    file = source(tmp_path, "% bbGt version=3\nperson 1 2 3 4 0 0 0 0 0 0 30\n")
    (finding,) = read([file], ReadOptions()).findings
    assert finding.code == "rotated-box"
    assert finding.example == "line 2: angle 30"


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("person 1 2 3 4 0 0 0 0", "expected 10 or 11 or 12 fields"),
        ("person 1 2 x 4 0 0 0 0 0 0 0", "expected numbers .*found 'x'"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"set06/V000/I00019\.txt, line 2: {words}"):
        read([source(tmp_path, f"% bbGt version=3\n{row}\n")], ReadOptions())


def test_a_file_name_without_a_frame_number_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"notes\.txt: expected one file per frame"):
        read([source(tmp_path, "", "notes.txt")], ReadOptions())


def test_two_files_of_one_frame_are_an_error(tmp_path):
    files = [source(tmp_path, "", "a/I00019.txt"), source(tmp_path, "", "a/I19.txt")]
    with pytest.raises(InputError, match=r"is frame 19 of recording 'a', as is a/I00019\.txt"):
        read(files, ReadOptions())


def test_images_are_listed_in_the_order_of_recording_and_frame(tmp_path):
    names = ["b/I00001.txt", "a/I00021.txt", "a/I00001.txt"]
    reading = read([source(tmp_path, "person 1 2 3 4 0 0 0 0 0", n) for n in names], ReadOptions())
    assert reading.images["recording"].tolist() == ["a", "a", "b"]
    assert reading.images["frame"].tolist() == [1, 21, 1]
    assert reading.images["image_id"].tolist() == [1, 2, 3]
    assert reading.boxes["frame"].tolist() == [1, 21, 1]
    assert reading.boxes["recording"].tolist() == ["b", "a", "a"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1,2,3,4,5,6\n",
        "0 0.5 0.5 0.1 0.2\n",
        "Pedestrian 0 0 0 1 2 3 4 1 1 1 1 1 1 1\n",
        "1 1 2 3 4 0 0 0 0 0\n",
    ],
)
def test_rows_of_other_formats_are_not_claimed(text):
    assert not recognise("I00019.txt", text, "truth")


def test_detections_are_not_claimed():
    assert not recognise("I00019.txt", "% bbGt version=3\n", "detections")
