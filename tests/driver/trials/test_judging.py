"""Which responses are right: squares and centre regions countable by hand."""

from __future__ import annotations

import math

import pandas as pd
import pytest
from driver_trials import parsed_trials

from nvcore.common.errors import InputError, ParameterError
from nvcore.subjects.driver.trials import Judging, judge_trials, side_of_angle

HEADER = (
    "subject,run,position,order,image,pedestrian,adaptation_asked_s,adaptation_measured_s,"
    "touch_x,touch_y,response_s,not_seen,device"
)
BOXES = pd.DataFrame(
    [("a.jpg", "p1", 400.0, 200.0, 40.0, 100.0)],
    columns=["image", "pedestrian", "x", "y", "w", "h"],
)
"""Its centre is (420, 250); the middle half reaches 10 px across and 25 px down."""


def judged(x: float | str, y: float | str, judging: Judging | None = None, measured: str = "2.5"):
    seen = 1 if x == "" else 0
    row = f"S1,0,1,0,a.jpg,p1,2.5,{measured},{x},{y},1,{seen},d"
    trials = parsed_trials(f"{HEADER}\n{row}\n".encode())
    return judge_trials(trials, BOXES, judging or Judging()).iloc[0]


@pytest.mark.parametrize(
    ("touch", "is_right"),
    [
        ((420, 250), True),
        ((529, 250), True),  # 109 px across: half the square and half the region are 110
        ((531, 250), False),
        ((530, 250), False),  # the sides touch
        ((420, 374), True),
        ((420, 376), False),
        ((529, 374), True),
        ((529, 376), False),
    ],
)
def test_a_response_is_right_where_the_square_overlaps_the_centre_region(touch, is_right):
    assert judged(*touch)["is_right"] == is_right


def test_the_sizes_are_parameters():
    assert not judged(521, 250, Judging(centre_share=0))["is_right"]
    assert judged(438, 250, Judging(square_px=2, centre_share=1))["is_right"]
    assert not judged(442, 250, Judging(square_px=2, centre_share=1))["is_right"]


def test_what_was_not_seen_is_wrong():
    assert not judged("", "")["is_right"]


def test_the_period_ends_with_the_display():
    assert judged(1, 1)["period_s"] == 3.0
    assert judged(1, 1, Judging(display_s=1.0))["period_s"] == 3.5


@pytest.mark.parametrize(("measured", "is_off"), [("2.55", False), ("2.449", True), ("", False)])
def test_a_trial_off_by_more_than_50_ms_is_marked(measured: str, is_off: bool):
    assert judged(1, 1, measured=measured)["is_off_time"] == is_off


def test_a_pedestrian_without_a_box_is_refused_with_the_line():
    row = "S1,0,1,0,b.jpg,p1,2.5,2.5,1,1,1,0,d"
    trials = parsed_trials(f"{HEADER}\n{row}\n".encode())
    with pytest.raises(InputError, match=r"trials.csv, line 2: there is no box .* p1 .* b\.jpg"):
        judge_trials(trials, BOXES, Judging(), name="trials.csv")


def test_200_px_are_5_degrees_at_20_cm_in_display_pixels_and_at_27_in_those_of_the_picture():
    """The paper: a display of 10.5 inches and 2560 x 1600 px, pictures of 1920 px."""
    width_mm = 25.4 * 10.5 * 2560 / math.hypot(2560, 1600)
    assert width_mm == pytest.approx(226.2, abs=0.05)
    of_display = side_of_angle(5, distance_mm=202.4, shown_width_mm=width_mm, picture_width_px=2560)
    of_picture = side_of_angle(5, distance_mm=269.8, shown_width_mm=width_mm, picture_width_px=1920)
    assert of_display == pytest.approx(200, abs=0.1)
    assert of_picture == pytest.approx(200, abs=0.1)


def test_impossible_settings_are_refused():
    with pytest.raises(ParameterError, match=r"centre_share: expected 0 to 1, got 1\.5"):
        Judging(centre_share=1.5)
    with pytest.raises(ParameterError, match="distance_mm: expected a length above 0"):
        side_of_angle(5, distance_mm=0, shown_width_mm=1, picture_width_px=1)
    with pytest.raises(ParameterError, match="degrees: expected 0 to 90"):
        side_of_angle(0, distance_mm=1, shown_width_mm=1, picture_width_px=1)
