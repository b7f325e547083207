"""Urgent encounters one by one, and who is nearest to contact in each frame."""

from __future__ import annotations

import numpy as np
import pytest
from approach import ALL, LATE, NEVER, approach, met
from builders import at, make_dataset, result_of

from nvcore.notes import phrase
from nvcore.settings.objects import PEDESTRIAN
from nvcore.subjects.time_left.encounters import (
    contact_at,
    count_in_time,
    nearest_contact,
    urgent_encounters,
)
from nvcore.subjects.time_left.notes import responses


def test_the_fastest_impact_is_on_top_then_the_smaller_margin():
    result = met((ALL, ALL), (ALL, LATE), (range(20, 40), ALL), (NEVER, LATE), (NEVER, ALL))
    urgent = urgent_encounters(result)
    assert urgent.index.tolist() == [3, 4, 1, 2, 0]
    assert urgent["in_time"].tolist() == ["neither", "only_y", "only_x", "both", "both"]
    assert count_in_time(urgent) == {"both": 2, "only_x": 1, "only_y": 1, "neither": 1}


def test_moments_are_in_seconds_before_contact():
    (row,) = urgent_encounters(met((range(10, 40), NEVER))).to_dict("records")
    assert (row["first_row"], row["urgent_row"]) == (0, 29)
    assert (row["confirmed_row_x"], row["confirmed_row_y"]) == (12, -1)
    assert row["first_s"] == pytest.approx(5.0)
    assert row["last_s"] == pytest.approx(1.1)
    assert row["ttc_s"] == pytest.approx(2.1)
    assert row["confirmed_s_x"] == pytest.approx(3.8)
    assert np.isnan(row["confirmed_s_y"])
    assert row["confirmed_s_x"] - row["ttc_s"] == pytest.approx(row["margin_s_x"])
    assert row["speed_kmh"] == 50


def test_where_nobody_is_urgent_the_table_is_empty_with_its_columns():
    urgent = urgent_encounters(met((ALL, ALL), reaction_s=0.0))
    assert urgent.empty
    assert {"urgent_row", "confirmed_s_x", "in_time"} <= set(urgent.columns)
    assert set(count_in_time(urgent).values()) == {0}


def test_what_each_system_did_is_said_in_words():
    result = met((range(10, 40), LATE), (NEVER, range(27, 40)))
    of_both = responses(result, np.array([1, 0]))
    assert [phrase(response, PEDESTRIAN) for pair in of_both for response in pair] == [
        "X never confirms the pedestrian: impact at 50 km/h",
        "Y confirms the pedestrian late, only at the last chance: impact at 15 km/h",
        "X confirms the pedestrian in time, 1.70 s before the last chance",
        "Y confirms the pedestrian late, 0.30 s after the last chance: impact at 31 km/h",
    ]


def test_the_nearest_to_contact_of_each_frame_and_where_nobody_is_known():
    first = approach(range(10), 5, centre=20, track=1)
    second = approach(range(5, 25), 4, centre=70, track=2)
    standing = [at(frame, 50, track=3) for frame in range(20, 30)]
    boxes = sorted([*first, *second, *standing])
    nearest = nearest_contact(result_of(make_dataset(boxes, n_frames=40)), 0)
    assert nearest["ttc_s"][[0, 5, 9, 24]].round(6).tolist() == [5.0, 3.5, 3.1, 1.6]
    assert nearest["encounter"][[0, 5, 9, 24]].tolist() == [0, 1, 1, 1]
    assert np.isinf(nearest["ttc_s"][25])
    assert nearest["encounter"][25] == 2
    assert np.isnan(nearest["ttc_s"][35])
    assert nearest["encounter"][35] == -1


def test_the_time_to_contact_of_encounters_in_single_frames():
    result = met((ALL, ALL), (ALL, ALL))
    at_frames = contact_at(result, np.array([0, 1, 1, 0]), np.array([10, 50, 10, 79]))
    assert at_frames[:2].round(6).tolist() == [4.0, 4.0]
    assert np.isnan(at_frames[2:]).all()  # they are in other recordings
    nobody = result_of(make_dataset(n_frames=3))
    assert np.isnan(contact_at(nobody, np.array([0]), np.array([1]))).all()
