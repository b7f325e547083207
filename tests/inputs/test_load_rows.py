"""Rows of the inputs, corrected, kept or left out with a reason; and each system's threshold."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from inputs import DETECTIONS, boxes_of, drive, one_box, session_of, write

from nvcore.inputs.load import load
from nvcore.inputs.session import SystemSource
from nvcore.params import Params

# corrections


def test_frame_numbers_are_moved_by_the_offset(tmp_path: Path):
    system = SystemSource(("fir.csv",), offset_frames=-2)
    dataset = load(session_of(one_box(tmp_path, "5,1,1,5,10,0.5"), "truth.csv", system))
    assert dataset.frames["frame"][int(dataset.system("fir").frame_index[0])] == 3
    assert "frame numbers moved by -2" in dataset.inputs["conversion"].iloc[-1]


def test_boxes_of_one_system_are_scaled_first_and_then_moved(tmp_path: Path):
    one_box(tmp_path, "0,1,4,5,10,0.5")
    system = SystemSource(("fir.csv",), name="moved", scale=(2.0, 0.5), offset_px=(10.0, -1.0))
    dataset = load(session_of(tmp_path, "truth.csv", system, "fir.csv"))
    assert boxes_of(dataset, 1) == [[12, 1, 10, 5]]
    assert boxes_of(dataset, 2) == [[1, 4, 5, 10]]
    conversion = dataset.inputs["conversion"][1]
    assert "coordinates scaled by 2, 0.5; boxes moved by 10, -1 px" in conversion


# nothing is lost


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ("city,0,1,1,5,10,0.5", "unknown recording"),
        ("urban,99,1,1,5,10,0.5", "frame not listed"),
        ("urban,-1,1,1,5,10,0.5", "frame not listed"),
        ("urban,9007199254740991,1,1,5,10,0.5", "frame not listed"),
        ("urban,0,nan,1,5,10,0.5", "not a number"),
        ("urban,0,1,1,0,10,0.5", "no area"),
        ("urban,0,1,1,5,-10,0.5", "no area"),
    ],
)
def test_a_row_without_a_place_is_left_out_with_its_reason(tmp_path: Path, row: str, reason: str):
    drive(tmp_path)
    write(tmp_path / "fir.csv", "recording," + DETECTIONS, "rural,3,1,1,5,10,0.5", row)
    dataset = load(session_of(tmp_path, "truth.csv", "fir.csv"))
    assert len(dataset.system("fir")) == 1
    lost = dataset.left_out
    assert lost[["subject", "line", "reason"]].to_numpy().tolist() == [["fir", 3, reason]]
    assert dataset.inputs["file"][int(lost["file"][0])].endswith("fir.csv")


def test_a_frame_between_listed_ones_is_not_listed(tmp_path: Path):
    one_box(tmp_path, "0,1,1,5,10,0.5", "1,1,1,5,10,0.5", "2,1,1,5,10,0.5")
    dataset = load(session_of(tmp_path, "truth.csv", "fir.csv", frames="0:8:2"))
    assert dataset.left_out.query("subject == 'fir'")["frame"].tolist() == [1]
    assert len(dataset.truth) == 5


# X and Y


SYSTEMS = (SystemSource(("fir.csv",), threshold=0.1), SystemSource(("nir.csv",), threshold=0.2))


@pytest.mark.parametrize(
    ("chosen", "expected", "thresholds"),
    [
        ({}, ("fir", "nir"), (0.1, 0.2)),
        ({"x": "nir"}, ("nir", "fir"), (0.2, 0.1)),
        ({"y": "fir"}, ("nir", "fir"), (0.2, 0.1)),
        ({"x": "nir", "y": "nir"}, ("nir", "nir"), (0.2, 0.2)),
        ({"params": Params(threshold_y=0.7)}, ("fir", "nir"), (0.1, 0.7)),
    ],
)
def test_each_compared_system_keeps_its_own_threshold(
    tmp_path: Path, chosen: dict, expected: tuple[str, str], thresholds: tuple[float, float]
):
    session = replace(session_of(drive(tmp_path)), systems=SYSTEMS, **chosen)
    dataset = load(session)
    params = dataset.params_of()
    assert dataset.compared() == expected
    assert (params.threshold_x, params.threshold_y) == thresholds


def test_a_single_system_is_compared_with_none(tmp_path: Path):
    session = session_of(drive(tmp_path), "truth.csv", "fir.csv")
    assert load(session).compared() == ("fir", None)
