"""KAIST results by image number and Caltech detections by frame."""

from __future__ import annotations

import json
from pathlib import Path

import pandas as pd
import pytest
from places import DATA

from nvcore.errors import FormatError, InputError, MissingFactError
from nvcore.findings import Severity
from nvcore.inputs.readers.base import ReadOptions, SourceFile
from nvcore.inputs.readers.caltech.kaist_results import read, recognise

GOLDEN = DATA / "kaist_results"
IMAGES = pd.DataFrame(
    {
        "recording": ["set06/V000", "set06/V000", "set06/V001"],
        "frame": [19, 39, 19],
        "image_id": [0, 1, 2],
    }
)


def options(**changes: object) -> ReadOptions:
    given = {"recordings": ("set06/V000", "set06/V001"), "images": IMAGES}
    return ReadOptions(role="detections", **{**given, **changes})


def golden(name: str) -> SourceFile:
    return SourceFile(GOLDEN / name, f"results/{name}")


def source(tmp_path: Path, content: str, name: str = "MBNet_result.txt") -> SourceFile:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content)
    return SourceFile(path, name)


def test_the_image_number_is_the_position_in_the_list_of_the_truth():
    # peers.md 34: image and annotation ids begin at 0 on KAIST
    boxes = read([golden("MBNet_result.txt")], options()).boxes
    assert boxes["recording"].tolist() == ["set06/V000", "set06/V001", "set06/V001"]
    assert boxes["frame"].tolist() == [19, 19, 19]


def test_boxes_and_scores_are_kept_as_they_are():
    reading = read([golden("MBNet_result.txt")], options())
    first = reading.boxes.iloc[0]
    assert first[["x", "y", "w", "h"]].tolist() == [502.33, 212.455, 19.922, 41.648]
    assert first["score"] == 0.03658492
    assert reading.boxes["line"].tolist() == [1, 2, 3]
    assert "1-based position in the truth's image list" in reading.conversion


def test_the_recordings_are_all_of_the_list_with_or_without_detections(tmp_path):
    reading = read([source(tmp_path, "1,1,2,3,4,0.5\n")], options())
    assert reading.recordings["name"].tolist() == ["set06/V000", "set06/V001"]


def test_caltech_frames_become_the_numbers_of_the_pictures():
    reading = read([golden("set06/V000.txt")], options())
    assert reading.boxes["frame"].tolist() == [0, 29]
    assert set(reading.boxes["recording"]) == {"set06/V000"}
    assert "frames from 1-based to 0-based" in reading.conversion


def test_caltech_frames_that_are_0_based_already_are_kept():
    boxes = read([golden("set06/V000.txt")], options(frame_base=0)).boxes
    assert boxes["frame"].tolist() == [1, 30]


def test_caltech_detections_need_no_truth():
    boxes = read([golden("set06/V000.txt")], ReadOptions(role="detections")).boxes
    assert set(boxes["recording"]) == {"set06/V000"}


def test_a_folder_called_like_a_recording_does_not_make_a_result_file_a_recording(tmp_path):
    images = IMAGES.assign(recording="kaist")
    file = source(tmp_path, "2,1,2,3,4,0.5\n", "kaist/MBNet.txt")
    boxes = read([file], options(recordings=("kaist",), images=images)).boxes
    assert boxes["frame"].tolist() == [39]


def test_results_by_image_number_without_a_list_ask_for_the_truth():
    with pytest.raises(MissingFactError, match="the truth's image list is needed"):
        read([golden("MBNet_result.txt")], options(images=None))


def test_an_image_number_off_the_list_is_an_error_finding_and_its_row_is_kept_out(tmp_path):
    reading = read([source(tmp_path, "1,1,2,3,4,0.5\n0,1,2,3,4,0.5\n9,1,2,3,4,0.5\n")], options())
    (finding,) = reading.findings
    assert finding.severity is Severity.ERROR
    assert finding.count == 2
    assert finding.example == "line 2: image number 0"
    assert reading.boxes["line"].tolist() == [1]


def test_a_truth_of_a_part_of_the_set_keeps_the_ids_of_the_whole(tmp_path):
    night = IMAGES.assign(image_id=[1455, 1456, 1457])
    reading = read([source(tmp_path, "1457,1,2,3,4,0.5\n3,1,2,3,4,0.5\n")], options(images=night))
    assert reading.boxes["frame"].tolist() == [39]
    assert "image number = image id + 1" in reading.conversion
    assert reading.findings[0].example == "line 2: image number 3"


def test_two_files_of_one_recording_are_an_error(tmp_path):
    files = [source(tmp_path, "", "a/set06/V000.txt"), source(tmp_path, "", "b/set06/V000.txt")]
    with pytest.raises(InputError, match="holds recording 'set06/V000', as a/set06"):
        read(files, options())


def test_an_empty_file_is_a_system_without_detections(tmp_path):
    reading = read([source(tmp_path, "")], options())
    assert len(reading.boxes) == 0
    assert reading.findings == ()


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("1,2,3,4,5", "expected 6 fields"),
        ("1.5,2,3,4,5,6", "expected a whole number as image number or frame"),
        ("1,2,3,4,5,high", "expected numbers .*found 'high'"),
    ],
)
def test_a_fault_is_named_by_file_and_line(tmp_path, row, words):
    with pytest.raises(FormatError, match=rf"MBNet_result\.txt, line 2: {words}"):
        read([source(tmp_path, f"1,1,2,3,4,0.5\n{row}\n")], options())


def test_own_rows_are_recognised_as_detections_only():
    text = (GOLDEN / "MBNet_result.txt").read_text()
    assert recognise("x.txt", text, "detections")
    assert not recognise("x.txt", text, "truth")


@pytest.mark.parametrize(
    "text", ["", "0,1,2,3,4,0.5\n", "1,1,2,3,4\n", "1,1,1,2,3,4,0.5\n", "a,1,2,3,4,0.5\n"]
)
def test_rows_of_other_formats_are_not_claimed(text):
    assert not recognise("x.txt", text, "detections")


@pytest.mark.realdata
def test_the_real_results_fall_on_the_real_images(realdata):
    truth = json.loads((realdata / "kaist/KAIST_annotation.json").read_text())
    images = pd.DataFrame(
        [(i["im_name"][:10], int(i["im_name"][-5:]), i["id"]) for i in truth["images"]],
        columns=["recording", "frame", "image_id"],
    )
    file = SourceFile(realdata / "kaist/results/MBNet_result.txt", "MBNet_result.txt")
    reading = read([file], options(recordings=tuple(images["recording"].unique()), images=images))
    first = reading.boxes.iloc[0]
    assert (first["recording"], first["frame"]) == ("set06/V000", 19)
    assert len(reading.boxes) == 12937  # wc -l
    assert reading.findings == ()
    # the best detection of an image lies on a pedestrian of that image far more often than not
    best = reading.boxes[reading.boxes["score"] > 0.9].merge(images, on=["recording", "frame"])
    people = pd.DataFrame(
        [(a["image_id"], *a["bbox"]) for a in truth["annotations"]],
        columns=["image_id", "left", "top", "width", "height"],
    )
    both = best.reset_index().merge(people, on="image_id", how="left")
    both["offset"] = (both["x"] + both["w"] / 2 - both["left"] - both["width"] / 2).abs()
    assert (both.groupby("index")["offset"].min() < 10).mean() > 0.9
