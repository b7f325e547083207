"""All about one frame."""

from __future__ import annotations

import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.tables.frame import frame_summary


@pytest.fixture(scope="module")
def result() -> Result:
    """Frame 3 of r1: tracks 1 (30 px, only X finds it) and 2 (50 px, both), an ignore region."""
    truth = [
        at(3, 20, track=1, h=30, recording=1),
        at(3, 50, track=2, distance_m=22, recording=1),
        at(3, 80, w=10, ignore=True, recording=1),
    ]
    x = [at(3, 20, h=30, recording=1), at(3, 50, recording=1), at(3, 80, recording=1)]
    y = [at(3, 50, recording=1), at(3, 70, recording=1)]
    places = [Place(range(5)), Place([1, 3, 5], fps=4)]
    return result_of(make_dataset(truth, x, y, places=places))


def test_a_frame_is_named_by_recording_number_and_time(result: Result):
    facts = frame_summary(result, 6)
    assert (facts.recording, facts.recording_index) == ("r1", 1)
    assert (facts.row, facts.row_in_recording) == (6, 1)
    assert (facts.frame, facts.time_s) == (3, 0.5)


def test_pedestrians_and_ignored_boxes_are_counted_apart(result: Result):
    facts = frame_summary(result, 6)
    assert (facts.n_truth, facts.n_ignored) == (2, 1)


def test_pedestrians_are_listed_tallest_first_with_who_finds_them(result: Result):
    table = frame_summary(result, 6).pedestrians
    assert table[["track", "height_px", "found_x", "found_y"]].to_numpy().tolist() == [
        [2, 50, True, True], [1, 30, True, False],
    ]  # fmt: skip
    assert table["is_salient_y"].tolist() == [False, True]
    assert table["distance_m"].tolist()[0] == 22
    assert table["k"].tolist() == [1, 1]


def test_those_whom_x_or_y_misses_are_told_alone(result: Result):
    assert frame_summary(result, 6).missed["track"].tolist() == [1]


def test_each_system_has_its_figures(result: Result):
    facts = frame_summary(result, 6)
    assert (facts.x.n_det, facts.x.matched, facts.x.false_alarms, facts.x.n_absorbed) == (
        2, 2, 0, 1,
    )  # fmt: skip
    assert (facts.y.n_det, facts.y.matched, facts.y.false_alarms, facts.y.n_absorbed) == (
        2, 1, 1, 0,
    )  # fmt: skip
    # Y: track 1 is 20 px from the edge; the false alarm is 20 px from track 2
    assert facts.y.similarity == pytest.approx(0.6)
    assert facts.y.name == "y"


def test_the_moving_mean_is_that_of_the_frame(result: Result):
    # window 1 s: all three frames, half a second apart
    assert frame_summary(result, 6).y.similarity_window == pytest.approx((1 + 0.6 + 1) / 3)


def test_a_frame_without_boxes_has_an_empty_table_with_all_columns(result: Result):
    facts = frame_summary(result, 0)
    assert list(facts.pedestrians)[:4] == ["track", "height_px", "distance_m", "k"]
    assert len(facts.pedestrians) == len(facts.missed) == 0
    assert facts.x.similarity == 1


def test_far_pedestrians_are_listed_as_not_relevant():
    truth = [at(0, 50, track=1, h=3), at(0, 20, track=2)]
    table = frame_summary(result_of(make_dataset(truth), proximity="height"), 0).pedestrians
    assert table["is_relevant"].tolist() == [True, False]
