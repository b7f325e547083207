"""Comma-separated detections on KITTI tracking, in 6 or 15 columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.caltech import kaist_results
from nvcore.inputs.readers.kitti.detections import read, recognise

GOLDEN = DATA / "kitti_detections"
DETECTIONS = ReadOptions(role="detections", recordings=("0015", "0016"))


def golden(name: str) -> SourceFile:
    return SourceFile(GOLDEN / name, "rrc_ped/0016.txt")


def source(tmp_path: Path, content: str, name: str = "rrc_ped/0016.txt") -> SourceFile:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return SourceFile(path, name)


def test_inclusive_corners_become_position_and_size():
    boxes = read([golden("corners.txt")], DETECTIONS).boxes
    assert boxes.iloc[0][["x", "y", "w", "h"]].tolist() == [276, 156, 28, 74]
    assert boxes.iloc[1][["x", "y", "w", "h"]].tolist() == [212.5, 156, 24.75, 62]


def test_frames_scores_and_recording_are_kept():
    boxes = read([golden("corners.txt")], DETECTIONS).boxes
    assert boxes["frame"].tolist() == [0, 0, 3]
    assert boxes["score"].tolist() == [0.88, 0.87, 0.86]
    assert set(boxes["recording"]) == {"0016"}


def test_the_choice_of_corners_is_told():
    conversion = read([golden("corners.txt")], DETECTIONS).conversion
    assert "columns 2 to 5 taken for corners (x2 > x1 and y2 > y1 in every row)" in conversion


def test_the_long_layout_gives_pedestrians_with_score_and_distance():
    reading = read([golden("ab3dmot.txt")], DETECTIONS)
    assert reading.boxes["x"].tolist() == [432, 777]
    assert reading.boxes["w"].tolist() == [58, 76]
    assert reading.boxes["score"].tolist() == [5.9, -0.5]
    assert reading.boxes["distance_m"].tolist() == [14.25, 11.5]
    assert "Pedestrian counted; others left out" in reading.conversion


@pytest.mark.parametrize("classes", [("Car",), ("2",), ("car",)])
def test_the_classes_that_count_can_be_named_or_numbered(classes):
    options = ReadOptions(role="detections", classes=classes)
    assert read([golden("ab3dmot.txt")], options).boxes["x"].tolist() == [100]


def test_an_unknown_class_is_answered_with_the_known_ones():
    options = ReadOptions(role="detections", classes=("dog",))
    with pytest.raises(InputError, match="no class 'dog'; the classes are Pedestrian, Car, Cyc"):
        read([golden("ab3dmot.txt")], options)


def test_an_unknown_type_number_is_reported(tmp_path):
    rows = (GOLDEN / "ab3dmot.txt").read_text().replace("0,2,", "0,9,")
    (finding,) = read([source(tmp_path, rows)], DETECTIONS).findings
    assert (finding.code, finding.example) == ("unknown-class", "line 2: 9")


def test_both_layouts_may_stand_in_different_files(tmp_path):
    files = [source(tmp_path, "0,1,2,30,40,0.5\n", "0015.txt"), golden("ab3dmot.txt")]
    boxes = read(files, DETECTIONS).boxes
    assert boxes["recording"].tolist() == ["0015", "0016", "0016"]
    assert boxes["x"].tolist() == [1, 432, 777]
    assert np.isnan(boxes["distance_m"][0])


def test_both_layouts_in_one_file_are_an_error(tmp_path):
    rows = "0,1,2,30,40,0.5\n" + (GOLDEN / "ab3dmot.txt").read_text()
    with pytest.raises(FormatError, match="line 2: expected the same number of columns"):
        read([source(tmp_path, rows)], DETECTIONS)


def test_a_row_that_is_no_pair_of_corners_is_named_by_line(tmp_path):
    file = source(tmp_path, "1,100,50,130,90,0.5\n1,100,50,20,40,0.5\n")
    with pytest.raises(
        FormatError, match=r"line 2: expected corners .*100,50,20,40.*kaist-results"
    ):
        read([file], DETECTIONS)


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,2,3,4,5", "expected 6 or 15 fields"),
        ("1,2,3,40,50,high", "expected numbers .*found 'high'"),
        ("1.5,2,3,40,50,0.5", "expected a whole number as frame"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"rrc_ped/0016\.txt, line 2: {words}"):
        read([source(tmp_path, f"1,2,3,40,50,0.5\n{row}\n")], DETECTIONS)


def test_a_type_that_is_no_whole_number_is_named_by_line(tmp_path):
    row = "0,1.5,432,157,489,253,5.9,1.8,0.7,1.0,-2.9,1.4,14.25,0.8,1.0\n"
    with pytest.raises(FormatError, match="line 1: expected a whole number as type"):
        read([source(tmp_path, row)], DETECTIONS)


def test_two_files_of_one_recording_are_an_error():
    with pytest.raises(InputError, match="holds recording '0016'"):
        read([golden("corners.txt"), golden("ab3dmot.txt")], DETECTIONS)


def test_an_empty_file_is_a_recording_without_detections(tmp_path):
    reading = read([source(tmp_path, "")], DETECTIONS)
    assert len(reading.boxes) == 0
    assert reading.recordings["name"].tolist() == ["0016"]


@pytest.mark.parametrize("name", ["corners.txt", "ab3dmot.txt"])
def test_own_rows_are_recognised_as_detections_only(name):
    text = (GOLDEN / name).read_text()
    assert recognise("0016.txt", text, "detections")
    assert not recognise("0016.txt", text, "truth")


def test_positions_and_sizes_are_kaists_and_corners_are_not():
    text = "1,502.33,212.455,19.922,41.648,0.03658492\n"
    assert not recognise("x.txt", text, "detections")
    assert kaist_results.recognise("x.txt", text, "detections")


@pytest.mark.parametrize(
    "text",
    [
        "",
        "1,1,1,1,9,9,1\n",
        "frame,x1,y1,x2,y2,score\n",
        "1,2,3,40,50,0.5\n1,2,3\n",
        "0.5,1,2,3,4,5",
    ],
)
def test_rows_of_other_formats_are_not_claimed(text):
    assert not recognise("0016.txt", text, "detections")


@pytest.mark.realdata
@pytest.mark.parametrize(("folder", "n_boxes"), [("rrc_ped", 1894), ("pointrcnn_ped", 1562)])
def test_the_real_detections_are_all_read(realdata, folder, n_boxes):
    path = realdata / "kitti_tracking" / folder / "0016.txt"
    boxes = read([SourceFile(path, f"{folder}/0016.txt")], DETECTIONS).boxes
    assert len(boxes) == n_boxes  # wc -l
    assert boxes["distance_m"].notna().all() == (folder == "pointrcnn_ped")
    assert (boxes[["w", "h"]] > 0).all(axis=None)


def test_numbers_in_quotes_are_told_apart_as_without():
    text = '"1","502.3","212.4","522.2","254.0","0.9"\n'
    assert recognise("x.txt", text, "detections")
    sizes = text.replace("522.2", "19.9").replace("254.0", "41.6")
    assert not recognise("x.txt", sizes, "detections")
    assert kaist_results.recognise("x.txt", sizes, "detections")
