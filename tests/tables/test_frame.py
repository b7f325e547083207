"""All about one frame."""

from __future__ import annotations

import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
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


def test_pedestrians_are_listed_by_their_larger_term_with_who_misses_them(result: Result):
    table = frame_summary(result, 6).pedestrians
    # track 1 is 20 px from the edge, 30 px from Y's nearest detection; of half a width of 50 px
    assert table["term_y"].tolist() == [0.4, 0]
    assert table["term_x"].tolist() == [0, 0]
    assert table[["track", "height_px"]].to_numpy().tolist() == [[1, 30], [2, 50]]
    assert table[["is_matched_x", "is_matched_y"]].to_numpy().tolist() == [
        [True, False], [True, True],
    ]  # fmt: skip
    assert table["missed_by"].tolist() == ["Y", ""]
    assert table["is_salient_y"].tolist() == [True, False]
    assert table["distance_m"].tolist()[1] == 22
    assert table["k"].tolist() == [1, 1]
    assert table["border_px"].tolist() == [20, 50]
    assert table["nearest_px_y"].tolist() == [30, 0]
    assert table["cost"].tolist() == [0.4, 1]


def test_detections_are_listed_by_their_part_in_what_false_alarms_cost(result: Result):
    table = frame_summary(result, 6).detections
    # Y's box at 70 is 20 px from track 2; X's third lies on the ignore region and does not count
    assert table["system"].tolist() == ["Y", "X", "X", "Y"]
    assert table["outcome"].tolist() == ["false", "match", "match", "match"]
    assert table["term"].tolist() == [0.4, 0, 0, 0]
    assert table["border_px"].tolist()[0] == 30
    assert table["nearest_px"].tolist()[0] == 20
    assert table["score"].isna().all()


def test_the_largest_terms_are_what_the_frame_loses():
    """Two recordings, rural and urban, proximity by height, strict pairing and not."""
    truth = [at(0, 30, h=12), at(0, 62, h=9), at(1, 80, h=20), at(1, 40, recording=1, h=14)]
    x = [at(0, 33, h=12), at(0, 90, h=30), at(1, 50, h=8), at(1, 90, recording=1)]
    places = [Place(range(3), context=1.0), Place(range(2), width=200.0)]
    dataset = make_dataset(truth, x, [], places=places)
    for pairing in ("nearest", "matched"):
        result = result_of(dataset, proximity="height", pairing=pairing, alpha=0.7)
        for row in range(5):
            facts = frame_summary(result, row)
            for letter, system in (("x", facts.x), ("y", facts.y)):
                terms = facts.pedestrians[f"term_{letter}"]
                assert 0.7 * terms.max() == pytest.approx(system.loss_miss) or terms.empty
                assert (terms <= facts.pedestrians["cost"] + 1e-12).all()
                parts = facts.detections["term"][facts.detections["system"] == letter.upper()]
                assert 0.3 * parts.max() == pytest.approx(system.loss_false) or parts.empty
                lost = system.loss_miss + system.loss_false
                assert lost == pytest.approx(1 - system.similarity)


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
    assert len(facts.pedestrians) == len(facts.detections) == 0
    assert facts.x.similarity == 1


def test_far_pedestrians_are_listed_as_not_relevant():
    truth = [at(0, 50, track=1, h=3), at(0, 20, track=2)]
    table = frame_summary(result_of(make_dataset(truth), proximity="height"), 0).pedestrians
    assert table["is_relevant"].tolist() == [True, False]
