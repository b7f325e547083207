"""KITTI tracking labels and results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.kitti.tracking import read, recognise
from nvcore.schema import NO_TRACK, UNKNOWN_OCCLUSION

GOLDEN = DATA / "kitti_tracking" / "0016.txt"
ROW = "0 5 Pedestrian 0 0 1.0 100 150 119 199 1.7 0.6 0.8 -3.0 1.4 14.2 0.8"


def golden() -> SourceFile:
    return SourceFile(GOLDEN, "label_02/0016.txt")


def source(tmp_path: Path, content: str, name: str = "label_02/0016.txt") -> SourceFile:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return SourceFile(path, name)


def test_inclusive_corners_become_position_and_size():
    # peers.md 43: a pixel more or less flips matches
    boxes = read([golden()], ReadOptions()).boxes
    assert boxes.iloc[1][["x", "y", "w", "h"]].tolist() == [100, 150, 20, 50]
    assert boxes.iloc[3][["x", "y", "w", "h"]].tolist() == [110.5, 150, 10.75, 50]


def test_frames_tracks_and_lines_are_kept():
    boxes = read([golden()], ReadOptions()).boxes
    assert boxes["frame"].tolist() == [0, 0, 0, 2]
    assert boxes["track"].tolist() == [NO_TRACK, 5, 6, 5]
    assert boxes["line"].tolist() == [1, 2, 3, 6]
    assert set(boxes["recording"]) == {"0016"}


def test_a_dontcare_row_and_a_sitting_person_become_ignore_regions():
    boxes = read([golden()], ReadOptions()).boxes
    assert boxes["ignore"].tolist() == [True, False, True, False]


def test_cyclists_and_cars_are_left_out_and_that_is_said():
    reading = read([golden()], ReadOptions())
    assert len(reading.boxes) == 4
    assert reading.conversion.endswith(
        "Pedestrian counted; Person, Person_sitting, DontCare ignored; others left out"
    )
    assert reading.findings == ()


def test_depth_becomes_the_distance_and_dontcare_has_none():
    boxes = read([golden()], ReadOptions()).boxes
    assert np.isnan(boxes["distance_m"][0])
    assert boxes["distance_m"].tolist()[1:] == [14.2, 12.5, 13.9]


def test_occlusion_3_is_unknown():
    boxes = read([golden()], ReadOptions()).boxes
    assert boxes["occlusion"].tolist() == [UNKNOWN_OCCLUSION, 2, 0, UNKNOWN_OCCLUSION]


def test_named_classes_count_and_neutral_ones_among_them_are_not_ignored():
    boxes = read([golden()], ReadOptions(classes=("person", "cyclist"))).boxes
    assert boxes["x"].tolist() == [534.9, 200, 300]
    assert boxes["ignore"].tolist() == [True, False, False]


def test_an_unknown_class_is_answered_with_the_known_ones():
    with pytest.raises(InputError, match=r"0016\.txt: .*no class 'dog'; the classes are Ped"):
        read([golden()], ReadOptions(classes=("dog",)))


def test_results_have_their_score_in_column_18_and_no_ignore_regions(tmp_path):
    rows = f"{ROW} 0.75\n" + ROW.replace("Pedestrian", "Person") + " 0.5\n"
    reading = read([source(tmp_path, rows)], ReadOptions(role="detections"))
    assert reading.boxes["score"].tolist() == [0.75]
    assert not reading.boxes["ignore"].any()
    assert "Pedestrian counted; others left out" in reading.conversion


def test_results_without_scores_are_said_to_have_none(tmp_path):
    reading = read([source(tmp_path, ROW)], ReadOptions(role="detections"))
    assert reading.boxes["score"].isna().all()
    assert "no score column: no scores" in reading.conversion


def test_a_blank_at_the_end_of_a_row_is_no_further_field(tmp_path):
    boxes = read([source(tmp_path, f"{ROW} \r\n" * 100)], ReadOptions()).boxes
    assert boxes["line"].tolist() == list(range(1, 101))


def test_several_recordings_are_told_apart(tmp_path):
    files = [source(tmp_path, ROW, "0013.txt"), source(tmp_path, f"{ROW}\n{ROW}", "0015.txt")]
    reading = read(files, ReadOptions())
    assert reading.boxes["recording"].tolist() == ["0013", "0015", "0015"]
    assert reading.boxes["file"].tolist() == [0, 1, 1]
    assert reading.recordings["name"].tolist() == ["0013", "0015"]


def test_an_empty_file_is_a_recording_without_boxes(tmp_path):
    reading = read([source(tmp_path, "")], ReadOptions())
    assert len(reading.boxes) == 0
    assert reading.recordings["name"].tolist() == ["0016"]
    assert reading.images is None


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
        read([source(tmp_path, f"{ROW}\n{row}\n")], ReadOptions())


def test_own_rows_are_recognised():
    assert recognise("0016.txt", GOLDEN.read_text(), "truth")
    assert recognise("0016.txt", f"{ROW} 0.5\n", "detections")


@pytest.mark.parametrize(
    "text",
    ["", "1 2 3 4 5 6 7\n", ROW[4:], "person 1 2 3 4 0 0 0 0 0\n", " ".join(["1"] * 17)],
)
def test_rows_of_other_formats_are_not_claimed(text):
    assert not recognise("0016.txt", text, "truth")


@pytest.mark.realdata
def test_the_real_labels_have_the_rows_of_their_files(realdata):
    file = SourceFile(realdata / "kitti_tracking/label_02/0016.txt", "0016.txt")
    boxes = read([file], ReadOptions()).boxes
    # grep -c ' Pedestrian ' and grep -c ' DontCare '; the picture is 1224 x 370
    assert boxes["ignore"].value_counts().to_dict() == {False: 2027, True: 1010}
    assert (boxes["x"] + boxes["w"]).max() <= 1224
    assert (boxes["y"] + boxes["h"]).max() <= 370
    assert boxes.loc[~boxes["ignore"], "distance_m"].between(4, 50).all()
