"""Trials from CSV text: what is read, and what is refused with file and line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from driver_trials import parsed_trials

from nvcore.common.errors import FormatError, InputError
from nvcore.subjects.driver.inputs.study_tables import picture_boxes, read_picture_boxes
from nvcore.subjects.driver.trials import TRIAL_COLUMNS
from nvcore.subjects.driver.trials.table import read_features, read_trials

HEADER = ",".join(TRIAL_COLUMNS)
SEEN = "S1,0,1,3,a.jpg,p1,2.5,2.512,640.5,300,1.25,0,tablet"
NOT_SEEN = "S1,0,2,3,b.jpg,p1,5.5,,,,,1,"


def parsed(*rows: str, header: str = HEADER):
    return parsed_trials("\n".join([header, *rows]).encode())


def test_trials_are_read_with_their_kinds():
    trials = parsed(SEEN, "", NOT_SEEN)
    assert list(trials.columns) == [*TRIAL_COLUMNS, "line"]
    first, second = trials.to_dict("records")
    assert first == {
        "subject": "S1",
        "run": 0,
        "position": 1,
        "order": 3,
        "image": "a.jpg",
        "pedestrian": "p1",
        "adaptation_asked_s": 2.5,
        "adaptation_measured_s": 2.512,
        "touch_x": 640.5,
        "touch_y": 300.0,
        "response_s": 1.25,
        "not_seen": False,
        "device": "tablet",
        "line": 2,
    }
    assert second["not_seen"]
    assert second["line"] == 4
    assert np.isnan([second["touch_x"], second["adaptation_measured_s"]]).all()
    assert second["device"] == ""


def test_columns_may_stand_in_any_order_beside_others_with_semicolons_and_decimal_commas():
    fields = dict(zip(TRIAL_COLUMNS, SEEN.split(","), strict=True)) | {"mood": "fine"}
    names = sorted(fields)
    row = ";".join(fields[name].replace(".", ",") if name == "touch_x" else fields[name]
                   for name in names)  # fmt: skip
    trials = parsed(row, header=";".join(names))
    assert trials["touch_x"].tolist() == [640.5]


@pytest.mark.parametrize(
    ("row", "line", "told"),
    [
        (SEEN.replace("S1", ""), 3, "subject is empty"),
        (SEEN.replace("640.5", "left"), 3, "touch_x: expected a number, found 'left'"),
        (SEEN.replace("640.5", "inf"), 3, "touch_x: expected a number"),
        (SEEN.replace("640.5", "1e9"), 3, r"touch_x: expected -1e\+06 to 1e\+06, found 1e9"),
        (SEEN.replace("640.5", ""), 3, "expected touch_x and touch_y"),
        (NOT_SEEN.replace("5.5,,,", "5.5,,1,2"), 3, "expected no touch where not_seen is 1"),
        (SEEN.replace("0,tablet", "maybe,tablet"), 3, "not_seen: expected 1 or 0, found 'maybe'"),
        (SEEN.replace("2.5,", "-1,"), 3, "adaptation_asked_s: expected 0 to 3600, found -1"),
        (SEEN.replace("S1,0", "S1,0.5"), 3, "run: expected a whole number, found 0.5"),
        (SEEN + ",more", 3, "expected 13 fields"),
        (
            "S2,0,1,3,a.jpg,p1,2.5,2.5,1,1,1,0,x\nS2,1,1,9,a.jpg,p1,2.5,2.5,1,1,1,0,x",
            4,
            r"S2 is shown the picture a.jpg after 2.5 s a second time \(first in line 3\)",
        ),
    ],
)
def test_a_wrong_row_is_refused_with_its_line(row: str, line: int, told: str):
    first = "S0,0,1,3,a.jpg,p1,2.5,2.5,1,1,1,0,x"
    with pytest.raises(FormatError, match=told) as caught:
        parsed(first, row)
    assert (Path(caught.value.file).name, caught.value.line) == ("trials.csv", line)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "it is empty"),
        (b"\xff\xfe\x00", "this is no CSV table of trials"),
        (b"subject,run\n1,2\n", "pedestrian, adaptation_asked_s.* are missing, found subject, run"),
        (f"{HEADER},run\n".encode(), "there are several columns run"),
        (f'{HEADER}\n"S1,0'.encode(), "this is no CSV table of trials"),
    ],
)
def test_what_is_no_table_of_trials_is_refused(content: bytes, told: str):
    with pytest.raises(FormatError, match=told):
        parsed_trials(content)


def test_a_file_that_is_not_there_is_named(tmp_path: Path):
    with pytest.raises(InputError, match=r"gone\.csv: cannot be opened"):
        read_trials(tmp_path / "gone.csv")


def test_a_box_needs_a_size_and_stands_once(tmp_path: Path):
    boxes = tmp_path / "boxes.csv"
    boxes.write_text("image,pedestrian,x,y,w,h\na.jpg,p1,-5,2,3,4\n")
    assert picture_boxes(read_picture_boxes(boxes)).to_dict("records") == [
        {"image": "a.jpg", "pedestrian": "p1", "x": -5.0, "y": 2.0, "w": 3.0, "h": 4.0}
    ]
    boxes.write_text("image,pedestrian,x,y,w,h\na.jpg,p1,1,2,0,4\n")
    with pytest.raises(FormatError, match="line 2: w: expected"):
        picture_boxes(read_picture_boxes(boxes))
    boxes.write_text("image,pedestrian,x,y,w,h\na.jpg,p1,1,2,3,4\na.jpg,p1,1,2,3,4\n")
    with pytest.raises(
        FormatError, match=r"line 3: the picture a\.jpg has the pedestrian p1 a sec"
    ):
        picture_boxes(read_picture_boxes(boxes))


def test_undefined_features_are_empty_and_boxes_may_stand_beside_them(tmp_path: Path):
    file = tmp_path / "features.csv"
    keys = (
        "width_px,height_px,luminance_sd,luminance_contrast,lab_distance,edge_contrast,colour_emd,"
        "fixation_distance_px"
    )
    file.write_text(f"image,pedestrian,{keys}\na.jpg,p1,1,2,3,4,,6,,8\n")
    features, boxes = read_features(file)
    assert boxes is None
    assert features.iloc[0, 2:].isna().tolist() == [False] * 4 + [True, False, True, False]
    file.write_text(f"image,pedestrian,x,y,w,h,{keys}\na.jpg,p1,9,8,7,6,1,2,3,4,5,6,7,8\n")
    assert read_features(file)[1].iloc[0, 2:].tolist() == [9, 8, 7, 6]
