"""KITTI object labels and results, one file per image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.kitti.object import read, recognise

GOLDEN = DATA / "kitti_object" / "label_2"
ROW = "Pedestrian 0.00 1 -0.20 712.40 143.00 810.73 307.92 1.89 0.48 1.20 1.84 1.47 8.41 0.01"


def golden() -> list[SourceFile]:
    names = ("000007.txt", "000008.txt")
    return [SourceFile(GOLDEN / name, f"training/label_2/{name}") for name in names]


def source(tmp_path: Path, content: str, name: str = "label_2/000007.txt") -> SourceFile:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return SourceFile(path, name)


def test_inclusive_corners_become_position_and_size():
    boxes = read(golden(), ReadOptions()).boxes
    assert boxes.iloc[1][["x", "y", "w", "h"]].tolist() == [100, 150, 20, 50]
    assert boxes.iloc[0]["w"] == pytest.approx(99.33)


def test_a_sitting_person_and_dontcare_are_ignored_and_a_cyclist_left_out():
    reading = read(golden(), ReadOptions())
    assert reading.boxes["ignore"].tolist() == [False, True, True]
    assert reading.boxes["line"].tolist() == [1, 2, 4]
    assert "others left out" in reading.conversion


def test_distance_and_occlusion_are_kept_where_known():
    boxes = read(golden(), ReadOptions()).boxes
    assert boxes["distance_m"].tolist()[:2] == [8.41, 9.5]
    assert np.isnan(boxes["distance_m"][2])
    assert boxes["occlusion"].tolist() == [1, 0, -1]


def test_a_file_without_rows_is_an_evaluated_frame():
    # peers.md 29: frames without boxes were dropped elsewhere
    images = read(golden(), ReadOptions()).images
    assert images["recording"].tolist() == ["training", "training"]
    assert images["frame"].tolist() == [7, 8]


def test_results_have_their_score_in_column_16_and_the_recording_of_the_truth(tmp_path):
    options = ReadOptions(role="detections", recordings=("training",))
    reading = read([source(tmp_path, f"{ROW} 0.75\n", "out/000007.txt")], options)
    assert reading.boxes["score"].tolist() == [0.75]
    assert reading.boxes["recording"].tolist() == ["training"]


def test_a_fault_is_named_by_file_and_line(tmp_path):
    with pytest.raises(FormatError, match=r"label_2/000007\.txt, line 2: expected 15 or 16 fields"):
        read([source(tmp_path, f"{ROW}\nPedestrian 1 2\n")], ReadOptions())


def test_a_file_name_without_a_number_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"label_2/readme\.txt: expected one file per frame"):
        read([source(tmp_path, ROW, "label_2/readme.txt")], ReadOptions())


def test_own_rows_are_recognised():
    assert recognise("000007.txt", (GOLDEN / "000007.txt").read_text(), "truth")
    assert recognise("000007.txt", f"{ROW} 0.5", "detections")


@pytest.mark.parametrize(
    "text",
    ["", f"0 5 {ROW}", "person 1 2 3 4 0 0 0 0 0\n", " ".join(["1"] * 15), "0 0.5 0.5 0.1 0.1"],
)
def test_rows_of_other_formats_are_not_claimed(text):
    assert not recognise("000007.txt", text, "truth")
