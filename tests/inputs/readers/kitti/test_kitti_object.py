"""KITTI object labels and results, one file per image."""

from __future__ import annotations

import pytest
from places import DATA
from reader_files import rows, source

from nvcore.common.errors import FormatError, InputError
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.kitti import read_object as read

FOLDER = DATA / "kitti_object" / "label_2"
NAME = "label_2/000007.txt"
ROW = "Pedestrian 0.00 1 -0.20 712.40 143.00 810.73 307.92 1.89 0.48 1.20 1.84 1.47 8.41 0.01"


def test_labels_become_boxes_and_files_evaluated_frames():
    # a sitting person and DontCare are ignore regions, a cyclist (line 3) is left out.
    # Frames without boxes were dropped elsewhere
    names = ("000007.txt", "000008.txt")
    reading = read(
        [SourceFile(FOLDER / name, f"training/label_2/{name}") for name in names], ReadOptions()
    )
    assert rows(reading.boxes, "line frame x y w h ignore distance_m occlusion") == [
        [1, 7, 712.4, 143, 99.33, 165.92, False, 8.41, 1],
        [2, 7, 100, 150, 20, 50, True, 9.5, 0],
        [4, 7, 503.89, 169.71, 87.72, 21.42, True, None, -1],
    ]
    assert rows(reading.images, "recording frame") == [["training", 7], ["training", 8]]
    assert "others left out" in reading.conversion


def test_results_have_their_score_in_column_16_and_the_recording_of_the_truth(tmp_path):
    options = ReadOptions(role="detections", recordings=("training",))
    reading = read([source(tmp_path, f"{ROW} 0.75\n", "out/000007.txt")], options)
    assert rows(reading.boxes, "score recording") == [[0.75, "training"]]


def test_a_fault_is_named_by_file_and_line(tmp_path):
    with pytest.raises(FormatError, match=r"label_2/000007\.txt, line 2: expected 15 or 16 fields"):
        read([source(tmp_path, f"{ROW}\nPedestrian 1 2\n", NAME)], ReadOptions())


def test_a_file_name_without_a_number_is_an_error(tmp_path):
    with pytest.raises(InputError, match=r"label_2/readme\.txt: expected one file per frame"):
        read([source(tmp_path, ROW, "label_2/readme.txt")], ReadOptions())


@pytest.mark.parametrize(
    ("classes", "counted", "ignored", "left_out"),
    [
        ("person", "person", "", ""),
        ("PERSON car roadsign", "PERSON", "", "car roadsign"),
        ("person pedestrian rider", "person pedestrian", "rider", ""),
        ("Person", "Person", "", ""),
        ("Pedestrian Person DontCare", "Pedestrian", "Person DontCare", ""),
        ("Pedestrian person", "Pedestrian person", "", ""),
    ],
)
@pytest.mark.parametrize("role", ["truth", "detections"])
def test_a_person_is_a_pedestrian_unless_kitti_s_own_labels_mean_one_who_sits(
    tmp_path, role, classes, counted, ignored, left_out
):
    # DeepStream, TAO and Datumaro write KITTI text with the class names of the data set
    text = "".join(f"{ROW.replace('Pedestrian', name)}\n" for name in classes.split())
    reading = read([source(tmp_path, text, NAME)], ReadOptions(role=role))
    names = classes.split()
    fates = {names[line - 1]: ignore for line, ignore in rows(reading.boxes, "line ignore")}
    neutral = ignored.split() if role == "truth" else []
    assert fates == dict.fromkeys(counted.split(), False) | dict.fromkeys(neutral, True)
    assert {item.name for item in reading.left_out} == {*names} - {*fates}
    assert {*left_out.split()} <= {*names} - {*fates}
    for name in counted.split():
        assert name.casefold() in reading.conversion.partition(" counted")[0].casefold()
