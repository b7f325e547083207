"""The driver in the encounters: what they see of each, in words, and over the threshold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from builders import NAN, at, make_dataset, result_of
from hypothesis import given
from hypothesis import strategies as st

from nvcore.comparison.compare import Result, compare
from nvcore.subjects.driver.comparison.encounters import (
    DRIVER_THRESHOLDS,
    describe_sight,
    driver_sights,
    over_driver_threshold,
)
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.driver.inputs.record import EstimateRecord

TRACKS = "abcdefgh"


def result_with(*shares: float, sd: float = NAN, x: str = "", y: str = "", **more: float) -> Result:
    """An encounter a, b, ... of each detectability; X and Y detect those that they name."""
    boxes = [
        at(0, 10 + 10 * i, track=i, detectability=share, **more) for i, share in enumerate(shares)
    ]
    detections = [
        [
            box._replace(score=1.0)
            for box, letter in zip(boxes, TRACKS, strict=False)
            if letter in who
        ]
        for who in (x, y)
    ]
    dataset = make_dataset(boxes, *detections, n_frames=1)
    return compare(replace(dataset, boxes=dataset.boxes.assign(detectability_sd=sd)))


def test_each_encounter_is_seen_not_seen_open_or_not_known():
    result = result_with(0.9, 0.1, 0.55, 0.45, NAN, sd=0.1)
    assert driver_sights(result).tolist() == ["sees", "unseen", "open", "open", "unknown"]


def test_without_a_standard_deviation_nothing_is_open():
    assert driver_sights(result_with(0.5, 0.49)).tolist() == ["sees", "unseen"]


def test_who_stays_distant_is_neither_seen_nor_unknown():
    result = result_with(0.9, h=1.0)
    assert driver_sights(result).tolist() == ["distant"]
    assert describe_sight(result, 0) == ""


def test_an_encounter_is_told_with_its_largest_detectability():
    result = result_with(0.52, 0.9, NAN, sd=0.15)
    assert [describe_sight(result, encounter) for encounter in range(3)] == [
        "Driver: open. Detectability reaches 0.52 ± 0.15 by the first frame that counts.",
        "Driver: sees. Detectability reaches 0.90 ± 0.15 by the first frame that counts.",
        "Driver: not known, because detectability is known in no frame up to the first that "
        "counts.",
    ]
    assert describe_sight(result_with(0.2), 0) == (
        "Driver: does not see. Detectability reaches 0.20 by the first frame that counts."
    )


def test_where_nothing_is_known_of_anybody_an_encounter_says_nothing():
    assert describe_sight(result_with(NAN), 0) == ""


def test_estimates_learnt_from_simulated_subjects_are_called_so():
    result = result_with(0.2)
    own = frozenset(result.dataset.recordings["name"])
    record = EstimateRecord("m", "", "all", 12, estimated_in=own)
    named = replace(result, dataset=replace(result.dataset, of_subjects={"driver": record}))
    assert "0.20 (learnt from simulated subjects) by the" in describe_sight(named, 0)


def test_over_the_threshold_encounters_pass_from_the_driver_to_the_systems():
    # X detects a and b, Y b; nobody c
    result = result_with(0.3, 0.6, 0.6, NAN, x="abd", y="b")
    table = over_driver_threshold(result).set_index("driver_threshold")
    assert len(table) == 19
    counts = ["known", "seen", "useful_x", "useful_y", "nobody"]
    assert table.loc[0.3, counts].tolist() == [3, 3, 0, 0, 0]
    assert table.loc[0.35, counts].tolist() == [3, 2, 1, 0, 0]
    assert table.loc[0.6, counts].tolist() == [3, 2, 1, 0, 0]
    assert table.loc[0.65, counts].tolist() == [3, 0, 2, 1, 1]


@pytest.mark.parametrize("result", [result_of(make_dataset()), result_with(NAN)])
def test_where_it_is_known_of_nobody_there_is_no_row_over_the_threshold(result: Result):
    table = over_driver_threshold(result)
    assert table.empty
    assert table.columns[0] == "driver_threshold"


@given(
    shares=st.lists(st.integers(0, 20).map(lambda i: i / 20), min_size=1, max_size=8),
    threshold=st.sampled_from(DRIVER_THRESHOLDS.tolist()),
    names=st.tuples(st.sets(st.sampled_from(TRACKS)), st.sets(st.sampled_from(TRACKS))),
)
def test_each_row_is_what_a_comparison_at_that_threshold_counts(shares, threshold, names):
    x, y = ("".join(who) for who in names)
    result = result_with(*shares, x=x, y=y)
    anew = driver_in(compare(result.dataset, replace(result.params, driver_threshold=threshold)))
    table = over_driver_threshold(result)
    (row,) = table[table["driver_threshold"] == threshold].to_dict("records")
    counts = anew.counts
    assert row == {
        "driver_threshold": threshold,
        "known": anew.n_known,
        "seen": anew.n_seen,
        "useful_x": counts["x_y"] + counts["x"],
        "useful_y": counts["x_y"] + counts["y"],
        "nobody": counts["nobody"],
    }


def test_thresholds_are_round_numbers():
    assert DRIVER_THRESHOLDS.tolist() == [round(0.05 * i, 2) for i in range(1, 20)]
    assert np.isin(0.5, DRIVER_THRESHOLDS)
