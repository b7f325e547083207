"""Time to contact from box heights beside that from metres: the table's ways, and the page."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from places import ROOT

import nvcore as nv
from nvcore.comparison.compare import Result, compare
from nvcore.settings.params import Params
from scripts.contact_in_metres import (
    PICTURE,
    SIZES,
    closing_speeds,
    load_kitti,
    measure_boxes,
    ratio_cells,
    section_of,
)

FOCAL_PX, STATURE_M = 600.0, 1.8


@pytest.fixture(scope="module")
def approached() -> Result:
    """One pedestrian who stands, passed after 4 s at 10 m/s: the last box is cut by the edge.

    X draws every second box; all are as high as the truth's.
    """
    time_s = np.arange(36) / 10
    metres = 40 - 10 * time_s
    height_px = FOCAL_PX * STATURE_M / metres
    truth = pd.DataFrame(
        {
            "frame": range(36),
            "x": np.where(time_s < 3.45, 300.0, 0.0),
            "y": 5.0,
            "w": 20.0,
            "h": height_px,
            "track": 1,
            "distance_m": metres,
        }
    )
    drawn = truth[["frame", "x", "y", "w", "h"]].iloc[::2]
    dataset = nv.load(truth=truth, x=drawn, y=drawn, size=(640, 480), fps=10)
    return compare(dataset, Params())


def test_heights_give_the_time_that_metres_give(approached: Result):
    boxes = measure_boxes(approached)
    expected = 4 - np.arange(36) / 10
    assert boxes["metres"].to_numpy() == pytest.approx(expected)
    for way in ("heights", "with_cut"):
        assert boxes[way].to_numpy() == pytest.approx(expected)
    assert boxes["near_side"].to_numpy() == pytest.approx(expected - 0.04)  # 0.4 m at 10 m/s


def test_the_speed_at_which_people_come_nearer_is_that_of_the_metres(approached: Result):
    boxes = measure_boxes(approached)
    named = pd.concat([boxes.assign(recording=name) for name in SIZES])
    assert closing_speeds(named) == "36 km/h in 0013, 36 km/h in 0015, 36 km/h in 0016"


def test_boxes_that_are_drawn_stand_where_the_system_matches_the_pedestrian(approached: Result):
    boxes = measure_boxes(approached)
    assert boxes["is_missed_x"].tolist() == [False, True] * 18
    assert np.isnan(boxes["drawn"].to_numpy()[1::2]).all()
    drawn = boxes["drawn"].to_numpy()[4:32:2]  # with five boxes within half a second
    assert drawn == pytest.approx(4 - np.arange(4, 32, 2) / 10)
    assert boxes["relative_height"].dropna().tolist() == [1.0] * 18
    assert boxes.index[boxes["is_cut"]].tolist() == [35]


def test_a_ratio_is_of_boxes_known_both_ways_and_says_how_many_are_called_not_closing():
    boxes = pd.DataFrame(
        {
            "metres": [1.0, 2.0, 4.0, np.inf, np.nan, 2.0, 5.0],
            "heights": [1.0, 4.0, 12.0, 1.0, 1.0, np.nan, np.inf],
        }
    )
    assert ratio_cells(boxes, "heights") == ("4", "2.00 (1.20 to 2.80)", "25.0 %")
    assert ratio_cells(boxes[:0], "heights") == ("0", "–", "–")


@pytest.mark.realdata
def test_the_page_on_validation_has_the_figures_as_they_are(realdata: Path):
    result = compare(load_kitti(realdata), Params())
    section = section_of(result, measure_boxes(result))
    assert section in (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert (ROOT / "docs" / PICTURE).is_file()
