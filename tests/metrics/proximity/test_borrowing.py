"""Distances borrowed from matches: medians, gaps, and nothing beyond what is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Box, Place, at, make_dataset

from nvcore.comparison.compare import compare
from nvcore.metrics.proximity.borrowing import borrowed_distances, weighing_truth
from nvcore.report.terminal import render_inputs
from nvcore.settings.params import Params

BORROW = Params(proximity="distance", missing_distance="borrow")


def walk(frames: dict[int, float] | range, *, track: int = -1, **more: float) -> list[Box]:
    """A box a frame around one place, with a distance where one is given."""
    known = frames if isinstance(frames, dict) else dict.fromkeys(frames, NAN)
    return [at(frame, 50, track=track, distance_m=m, **more) for frame, m in known.items()]


def test_a_gap_is_filled_linearly_and_nothing_before_or_after() -> None:
    dataset = make_dataset(walk(range(7), track=1), walk({1: 40.0, 4: 34.0}))
    borrowed = borrowed_distances(dataset)
    np.testing.assert_allclose(borrowed.distance_m, [NAN, 40, 38, 36, 34, NAN, NAN])
    counts = borrowed.n_own, borrowed.n_reported, borrowed.n_between, borrowed.n_unknown
    assert counts == (0, 2, 2, 3)


def test_several_systems_lend_their_median_and_their_difference_is_told() -> None:
    dataset = make_dataset(walk(range(3), track=1), walk({0: 20.0, 1: 30.0}), walk({1: 34.0}))
    borrowed = borrowed_distances(dataset)
    np.testing.assert_allclose(borrowed.distance_m, [20, 32, NAN])
    assert borrowed.lent == {"x": 2, "y": 1}
    assert (borrowed.n_compared, borrowed.spread) == (1, pytest.approx(4 / 32))
    assert "2 as x (2) and y (1) report, 0 between those; where several" in borrowed.text


def test_own_distances_stay_and_hold_the_track() -> None:
    truth = [at(0, 50, track=1, distance_m=30.0), *walk(range(1, 4), track=1)]
    dataset = make_dataset(truth, walk({0: 99.0, 2: 20.0}))
    np.testing.assert_allclose(borrowed_distances(dataset).distance_m, [30, 25, 20, NAN])
    assert borrowed_distances(dataset).lent == {"x": 1, "y": 0}


def test_a_gap_of_more_than_two_seconds_stays_open() -> None:
    frames = range(22)
    short = make_dataset(walk(frames, track=1), walk({0: 40.0, 20: 20.0}))
    assert np.isfinite(borrowed_distances(short).distance_m).sum() == 21
    long = make_dataset(walk(frames, track=1), walk({0: 40.0, 21: 20.0}))
    assert np.isfinite(borrowed_distances(long).distance_m).sum() == 2


def test_time_between_listed_frames_counts_not_their_number() -> None:
    truth = walk(dict.fromkeys((0, 1, 5), NAN), track=1)
    dataset = make_dataset(truth, walk({0: 40.0, 5: 30.0}), frames=[0, 1, 5])
    np.testing.assert_allclose(borrowed_distances(dataset).distance_m, [40, 38, 30])


def test_nothing_is_borrowed_from_another_pedestrian_recording_or_a_false_alarm() -> None:
    truth = [at(frame, centre, track=t) for t, centre in ((1, 20), (2, 80)) for frame in range(3)]
    truth += [at(0, 20, track=1, recording=1)]
    x = [at(0, 20, distance_m=9.0), at(2, 50, distance_m=7.0), at(2, 80, distance_m=5.0)]
    dataset = make_dataset(truth, x, places=[Place(range(3)), Place(range(1))])
    borrowed = borrowed_distances(dataset)
    lent = {
        (int(frame), int(track)): float(metres)
        for frame, track, metres in zip(
            dataset.truth.frame_index, dataset.truth.track, borrowed.distance_m, strict=True
        )
        if np.isfinite(metres)
    }
    assert lent == {(0, 1): 9.0, (2, 2): 5.0}


def test_neither_thresholds_nor_matching_nor_the_pair_move_what_is_borrowed() -> None:
    truth = walk(range(4), track=1)
    x, y = walk({0: 40.0, 3: 37.0}, score=0.1), walk({1: 45.0}, score=0.9)
    dataset = make_dataset(truth, x, y)
    k = compare(dataset, BORROW).k_truth.k
    for moved in (
        replace(BORROW, threshold_x=0.5, threshold_y=0.5),
        replace(BORROW, match="lateral", iou=0.9),
    ):
        np.testing.assert_array_equal(compare(dataset, moved).k_truth.k, k)
    np.testing.assert_array_equal(compare(dataset, BORROW, x="y", y="x").k_truth.k, k)
    swapped = make_dataset(truth, y, x)
    np.testing.assert_array_equal(compare(swapped, BORROW).k_truth.k, k)


def test_the_fused_systems_meet_pedestrians_of_the_same_weights() -> None:
    dataset = make_dataset(walk(range(4), track=1), walk({0: 40.0, 3: 37.0}), walk({1: 45.0}))
    result = compare(dataset, BORROW)
    np.testing.assert_array_equal(result.fusion.k_truth.k, result.k_truth.k)


def test_of_three_systems_the_fused_ones_still_name_the_lenders() -> None:
    near = walk({0: 40.0, 3: 37.0})
    two = make_dataset(walk(range(4), track=1), near, walk({1: 45.0}))
    third = two.boxes[two.boxes["source"] == 2].assign(source=3)
    boxes = pd.concat([two.boxes, third], ignore_index=True)
    result = compare(replace(two, boxes=boxes, systems=("x", "y", "z")), BORROW)
    assert result.fusion.borrowed is not None
    assert result.fusion.borrowed.lent == {"x": 2, "y": 1, "z": 1}
    assert "y (1) and z (1) report" in render_inputs(result.fusion)


def test_only_nearness_by_distance_borrows_and_contact_stays_with_the_truth() -> None:
    dataset = make_dataset(walk(range(8), track=1), walk({i: 40.0 - i for i in range(8)}))
    assert weighing_truth(dataset, Params(missing_distance="borrow")) is dataset.truth
    assert weighing_truth(dataset, Params(proximity="distance")) is dataset.truth
    assert compare(dataset, replace(BORROW, proximity="height")).borrowed is None
    borrowing, without = (compare(dataset, p) for p in (BORROW, Params(proximity="distance")))
    assert (without.k_truth.n_without_distance, borrowing.k_truth.n_without_distance) == (8, 0)
    ours, theirs = (result.of("time_left").contact for result in (borrowing, without))
    np.testing.assert_array_equal(ours.ttc_s, theirs.ttc_s)


def test_a_distance_of_zero_or_less_is_none() -> None:
    dataset = make_dataset(walk(range(2), track=1), walk({0: 0.0, 1: -3.0}))
    assert borrowed_distances(dataset).n_reported == 0
    assert "no match reports a distance" in borrowed_distances(dataset).text


def test_no_truth_and_no_detections_lend_nothing() -> None:
    assert borrowed_distances(make_dataset(n_frames=2)).n_borrowed == 0
    assert borrowed_distances(make_dataset(walk(range(2), track=1))).n_unknown == 2


def test_ignored_people_are_none_of_the_pedestrians_counted() -> None:
    truth = [at(0, 50, ignore=True), at(1, 50, track=1, distance_m=12.0)]
    borrowed = borrowed_distances(make_dataset(truth, walk({0: 20.0, 1: 20.0})))
    counts = borrowed.n_own, borrowed.n_reported, borrowed.n_between, borrowed.n_unknown
    assert counts == (1, 0, 0, 0)
