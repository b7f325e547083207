"""Comma-separated detections on KITTI tracking, in 6 or 15 columns."""

from __future__ import annotations

import pytest
from places import DATA
from reader_files import golden, only_finding, rows, source

from nvcore.common.errors import FormatError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.kitti import read_detections as read

NAME = "rrc_ped/0016.txt"
DETECTIONS = ReadOptions(role="detections", recordings=("0015", "0016"))
LONG = (DATA / "kitti_detections" / "ab3dmot.txt").read_text()


def read_text(tmp_path, text: str, options: ReadOptions = DETECTIONS):
    return read([source(tmp_path, text, NAME)], options)


def test_inclusive_corners_become_position_and_size():
    reading = read(golden("kitti_detections", "corners.txt"), DETECTIONS)
    assert rows(reading.boxes, "frame x y w h score distance_m") == [
        [0, 276, 156, 28, 74, 0.88, None],
        [0, 212.5, 156, 24.75, 62, 0.87, None],
        [3, 441, 160, 41, 96, 0.86, None],
    ]
    assert "columns 2 to 5 are corners (x2 > x1 and y2 > y1 in" in reading.conversion


def test_the_long_layout_gives_pedestrians_with_score_and_distance():
    reading = read(golden("kitti_detections", "ab3dmot.txt"), DETECTIONS)
    assert rows(reading.boxes, "frame x w score distance_m") == [
        [0, 432, 58, 5.9, 14.25],
        [2, 777, 76, -0.5, 11.5],
    ]
    assert "Pedestrian counted; others left out" in reading.conversion


@pytest.mark.parametrize("classes", [("Car",), ("2",), ("car",)])
def test_the_classes_that_count_can_be_named_or_numbered(classes):
    options = ReadOptions(role="detections", classes=classes)
    boxes = read(golden("kitti_detections", "ab3dmot.txt"), options).boxes
    assert boxes["x"].tolist() == [100]


def test_an_unknown_type_number_is_reported(tmp_path):
    reading = read_text(tmp_path, LONG.replace("0,2,", "0,9,"))
    assert only_finding(reading, "unknown-class").example == "line 2: 9"


def test_both_layouts_may_stand_in_different_files(tmp_path):
    files = [source(tmp_path, "0,1,2,30,40,0.5\n", "0015.txt"), source(tmp_path, LONG, NAME)]
    assert rows(read(files, DETECTIONS).boxes, "recording x distance_m") == [
        ["0015", 1, None],
        ["0016", 432, 14.25],
        ["0016", 777, 11.5],
    ]


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,2,3,4,5", "expected 6 or 15 fields"),
        ("1,2,3,40,50,high", "expected numbers .*found 'high'"),
        ("1.5,2,3,40,50,0.5", "expected a whole number as frame"),
        ("1,100,50,20,40,0.5", "expected corners .*100,50,20,40.*kaist-results"),
        (LONG, "expected the same number of columns"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"rrc_ped/0016\.txt, line 2: {words}"):
        read_text(tmp_path, f"1,2,3,40,50,0.5\n{row}\n")


def test_a_type_that_is_no_whole_number_is_named_by_line(tmp_path):
    row = "0,1.5,432,157,489,253,5.9,1.8,0.7,1.0,-2.9,1.4,14.25,0.8,1.0\n"
    with pytest.raises(FormatError, match="line 1: expected a whole number as type"):
        read_text(tmp_path, row)


@pytest.mark.realdata
@pytest.mark.parametrize(("folder", "n_boxes"), [("rrc_ped", 1894), ("pointrcnn_ped", 1562)])
def test_the_real_detections_are_all_read(realdata, folder, n_boxes):
    path = realdata / "kitti_tracking" / folder / "0016.txt"
    boxes = read([SourceFile(path, f"{folder}/0016.txt")], DETECTIONS).boxes
    assert len(boxes) == n_boxes  # wc -l
    assert boxes["distance_m"].notna().all() == (folder == "pointrcnn_ped")
    assert (boxes[["w", "h"]] > 0).all(axis=None)
