"""KITTI tracking labels and results."""

from __future__ import annotations

import pytest
from reader_files import golden, rows, source

from nvcore.common.errors import FormatError
from nvcore.inputs.readers.base import ReadOptions
from nvcore.inputs.readers.kitti import read_tracking as read

NAME = "label_02/0016.txt"
ROW = "0 5 Pedestrian 0 0 1.0 100 150 119 199 1.7 0.6 0.8 -3.0 1.4 14.2 0.8"


def test_labels_become_boxes_with_track_distance_and_occlusion():
    # A pixel more or less flips matches. DontCare and Person are ignore regions, a
    # cyclist (line 4) and a car (line 5) are left out; occlusion 3 is unknown
    reading = read(golden("kitti_tracking", "0016.txt"), ReadOptions())
    assert rows(reading.boxes, "line frame track x y w h ignore distance_m occlusion") == [
        [1, 0, -1, 534.9, 163.4, 42.11, 27.73, True, None, -1],
        [2, 0, 5, 100, 150, 20, 50, False, 14.2, 2],
        [3, 0, 6, 200, 150, 20, 50, True, 12.5, 0],
        [6, 2, 5, 110.5, 150, 10.75, 50, False, 13.9, -1],
    ]
    assert set(reading.boxes["recording"]) == {"0016"}
    assert reading.conversion.endswith(
        "Pedestrian counted; Person, Person_sitting, DontCare ignored; others left out: "
        "Car (1), Cyclist (1)"
    )
    assert reading.findings == ()


def test_named_classes_count_and_neutral_ones_among_them_are_not_ignored():
    options = ReadOptions(classes=("person", "cyclist"))
    boxes = read(golden("kitti_tracking", "0016.txt"), options).boxes
    assert rows(boxes, "x ignore") == [[534.9, True], [200, False], [300, False]]


def test_results_have_their_score_in_column_18_and_no_ignore_regions(tmp_path):
    text = f"{ROW} 0.75\n" + ROW.replace("Pedestrian", "Person") + " 0.5\n"
    reading = read([source(tmp_path, text, NAME)], ReadOptions(role="detections"))
    assert rows(reading.boxes, "score ignore") == [[0.75, False]]
    assert "Pedestrian counted; others left out" in reading.conversion


def test_results_without_scores_are_said_to_have_none(tmp_path):
    reading = read([source(tmp_path, ROW, NAME)], ReadOptions(role="detections"))
    assert reading.boxes["score"].isna().all()
    assert "no score column: no scores" in reading.conversion


@pytest.mark.parametrize(
    ("row", "words"),
    [
        (ROW.rsplit(" ", 1)[0], "expected 17 or 18 fields"),
        (ROW.replace("100", "left"), "expected numbers .*found 'left'"),
        (ROW.replace("0 5", "0.5 5", 1), "expected a whole number as frame"),
        (ROW.replace("0 5", "0 5.5", 1), "expected a whole number as id"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"label_02/0016\.txt, line 2: {words}"):
        read([source(tmp_path, f"{ROW}\n{row}\n", NAME)], ReadOptions())
