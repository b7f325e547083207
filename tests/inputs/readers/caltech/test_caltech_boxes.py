"""Caltech and KAIST ground truth as bbGt text."""

from __future__ import annotations

import pytest
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.readers.base import Reading, ReadOptions
from nvcore.inputs.readers.caltech import read_bbgt as read
from nvcore.inputs.readers.caltech import recognise_bbgt as recognise

NAME = "set06/V000/I00019.txt"
FRAMES = [f"set06/V000/{name}.txt" for name in ("I00019", "I00039", "I00059")]


def read_text(tmp_path, text: str, **options: object) -> Reading:
    return read([source(tmp_path, text, NAME)], ReadOptions(**options))


def test_labels_become_boxes_and_files_evaluated_frames():
    # people, person?, cyclist and a flagged person are ignore regions; person-fa (line 9 of
    # frame 19) is left out. KAIST's occlusion level is kept, Caltech's flag in frame 59 becomes a
    # level by the visible box: 0.2 hidden; 0.5 hidden; visible box equal to the box, nothing
    # visible. Frames without boxes, here 39, were dropped elsewhere
    reading = read(golden("bbgt", *FRAMES), ReadOptions())
    assert rows(reading.boxes, "frame line x y w h ignore occlusion") == [
        [19, 2, 505, 212, 20, 50, False, 0],
        [19, 3, 100, 200, 20, 50, False, 1],
        [19, 4, 130, 200, 20, 50, False, 2],
        [19, 5, 160, 200, 40, 50, True, 0],
        [19, 6, 210, 200, 20, 50, True, 0],
        [19, 7, 240, 200, 20, 50, True, 0],
        [19, 8, 270, 200, 20, 50, True, 0],
        [59, 2, 10, 20, 20, 50, False, 1],
        [59, 3, 10, 20, 20, 50, False, 2],
        [59, 4, 10, 20, 20, 50, False, 2],
    ]
    assert set(reading.boxes["recording"]) == {"set06/V000"}
    assert rows(reading.images, "frame image_id") == [[19, 1], [39, 2], [59, 3]]
    assert "person counted; people, person?, cyclist" in reading.conversion
    assert "others left out" in reading.conversion
    assert reading.findings == ()


def test_the_classes_that_count_can_be_named():
    boxes = read(golden("bbgt", *FRAMES), ReadOptions(classes=("Cyclist",))).boxes
    assert boxes.loc[~boxes["ignore"], "x"].tolist() == [240]


def test_a_class_that_only_the_files_have_can_count_and_others_are_an_error(tmp_path):
    text = "rider 1 2 3 4 0 0 0 0 0\n"
    reading = read_text(tmp_path, text, classes=("rider",))
    assert reading.boxes["ignore"].tolist() == [False]
    assert reading.findings == ()
    with pytest.raises(InputError, match=r"no class 'dog'; the classes are person, .*rider"):
        read_text(tmp_path, text, classes=("dog",))


@pytest.mark.parametrize(
    ("text", "code", "example"),
    [
        (
            "% bbGt version=3\nperson 1 2 3 4 0 0 0 0 0 0 0\ntree 1 2 3 4 0 0 0 0 0 0 0\n",
            "unknown-class",
            "line 3: tree",
        ),
        ("% bbGt version=3\nperson 1 2 3 4 0 0 0 0 0 0 30\n", "rotated-box", "line 2: angle 30"),
    ],
)
def test_what_the_format_does_not_have_is_reported(tmp_path, text, code, example):
    finding = only_finding(read_text(tmp_path, text), code)
    assert (finding.count, finding.example) == (1, example)


def test_files_of_which_no_row_counts_are_reported(tmp_path):
    reading = read_text(tmp_path, "cyclist 1 2 3 4 0 0 0 0 0\n")
    assert "found cyclist" in only_finding(reading, "no-counted-class").message


@pytest.mark.parametrize(
    ("version", "rest"), [(None, ""), (1, ""), (2, " 1"), (3, " 1 0")], ids=["v0", "v1", "v2", "v3"]
)
def test_all_versions_are_read(tmp_path, version, rest):
    header = "" if version is None else f"% bbGt version={version}\n"
    text = f"{header}person 1 2 3 4 0 0 0 0 0{rest}\n"
    assert recognise("I00019.txt", text, "truth")
    boxes = read_text(tmp_path, text).boxes
    assert rows(boxes, "x y w h ignore") == [[1, 2, 3, 4, rest != ""]]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("person 1 2 3 4 0 0 0 0", "expected 10 or 11 or 12 fields"),
        ("person 1 2 x 4 0 0 0 0 0 0 0", "expected numbers .*found 'x'"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"set06/V000/I00019\.txt, line 2: {words}"):
        read_text(tmp_path, f"% bbGt version=3\n{row}\n")


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["notes.txt"], r"notes\.txt: expected one file per frame"),
        (["a/I00019.txt", "a/I19.txt"], r"is frame 19 of recording 'a', as is a/I00019\.txt"),
    ],
)
def test_every_file_is_a_frame_of_its_own(tmp_path, names, words):
    with pytest.raises(InputError, match=words):
        read([source(tmp_path, "", name) for name in names], ReadOptions())


def test_images_are_listed_in_the_order_of_recording_and_frame(tmp_path):
    names = ["b/I00001.txt", "a/I00021.txt", "a/I00001.txt"]
    reading = read([source(tmp_path, "person 1 2 3 4 0 0 0 0 0", n) for n in names], ReadOptions())
    assert rows(reading.images, "recording frame image_id") == [
        ["a", 1, 1],
        ["a", 21, 2],
        ["b", 1, 3],
    ]
    assert rows(reading.boxes, "recording frame") == [["b", 1], ["a", 21], ["a", 1]]
