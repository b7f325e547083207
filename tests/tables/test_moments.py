"""The worst moments, the way from miss to miss, and the frames of an encounter to open."""

from __future__ import annotations

import pandas as pd
import pytest
from builders import Box, Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result
from nvcore.tables.moments import (
    NEVER,
    encounter_box,
    encounter_moments,
    encounter_time,
    next_misses,
    worst_moments,
)


def of_kind(result: Result, kind: str, *, n: int = 5) -> pd.DataFrame:
    table = worst_moments(result, n=n)
    return table[table["kind"] == kind]


def middle(frames: range | list[int], **more: object) -> list[Box]:
    return [at(f, 50, **more) for f in frames]


@pytest.fixture(scope="module")
def y_blind() -> Result:
    """Ten frames at 10 fps, track 7 in the middle: X sees it always, Y not in frames 2..5."""
    y = middle([0, 1, 6, 7, 8, 9])
    return result_of(make_dataset(middle(range(10), track=7), middle(range(10)), y))


def test_a_low_interval_tells_where_and_how_bad_it_is(y_blind: Result):
    (row,) = of_kind(y_blind, "y").to_dict("records")
    # similarity 0.1 in 4 frames of 0.1 s, low below 0.9
    assert row["depth_s"] == pytest.approx(0.32)
    assert row["duration_s"] == pytest.approx(0.4)
    assert [row[name] for name in ("recording", "first_frame", "last_frame", "row", "frame")] == [
        "r0", 2, 5, 2, 2,
    ]  # fmt: skip
    assert (row["time_s"], row["similarity_x"], row["track"]) == (0.2, 1, 7)
    assert row["similarity_y"] == pytest.approx(0.1)


def test_a_difference_is_summed_over_time(y_blind: Result):
    (row,) = of_kind(y_blind, "x_better").to_dict("records")
    assert row["depth_s"] == pytest.approx(0.9 * 0.4)
    assert (row["first_frame"], row["last_frame"]) == (2, 5)


def test_a_system_that_is_never_worse_has_no_moments(y_blind: Result):
    assert worst_moments(y_blind)["kind"].tolist() == ["y", "x_better"]


def test_the_reason_names_the_pedestrian_and_who_finds_it(y_blind: Result):
    table = worst_moments(y_blind)
    assert set(table["reason"]) == {
        "Y misses pedestrian 7 (up to 50 px tall) for 0.40 s; X does not."
    }


PERSON = middle(range(4), track=1)
IN_TURN = [*middle(range(3), track=1), *[at(f, 20, track=2) for f in range(3, 6)]]
APPROACH = [at(f, 50, track=1, h=50 if f >= 4 else 1) for f in range(8)]
ASIDE = [at(0, 50, track=2), *[at(f, 40, track=1) for f in range(1, 6)]]
TWICE = [at(0, 50, track=1), at(0, 20, track=1), at(1, 50, track=1)]
WIDE, BESIDE = [at(0, 50, w=40, track=1)], [at(0, 60, w=40)]  # IoU 0.6, 10 px apart


@pytest.mark.parametrize(
    ("boxes", "params", "reason"),
    [
        ((PERSON,), {}, "X misses pedestrian 1 (up to 50 px tall) for 0.40 s; Y does, too."),
        ((PERSON, [], middle([1])), {}, "for 0.40 s; Y matches for 0.10 s of that time."),
        ((IN_TURN,), {}, "pedestrian 1 (up to 50 px tall) for 0.30 s of 0.60 s"),
        ((TWICE, [at(0, 20)]), {}, "for 0.10 s of 0.20 s"),
        (([], middle([1, 2, 3])), {"low": 0.95}, "X has false alarms for 0.30 s."),
        (([], [at(0, 50), at(0, 40), at(1, 40)]), {"alpha": 0.5}, "for 0.20 s (up to 2 at once)."),
        ((WIDE, BESIDE), {}, "X's nearest detection is up to 10 px from pedestrian 1 (up to 50 px"),
        ((WIDE, BESIDE), {"alpha": 0.1}, "X has detections up to 10 px from the nearest pedes"),
        # a far one before frame 4: told for the interval, not for the time before
        ((APPROACH,), {"proximity": "height"}, "X misses pedestrian 1 (up to 50 px tall) for 0.4"),
        # track 2 in the middle for 1 frame, track 1 a little aside for 5: most of the interval
        ((ASIDE,), {}, "X misses pedestrian 1"),
    ],
)
def test_the_reason_of_a_moment_of_x(boxes: tuple[list[Box], ...], params: dict, reason: str):
    (row,) = of_kind(result_of(make_dataset(*boxes), **params), "x").to_dict("records")
    assert reason in row["reason"]
    assert pd.isna(row["track"]) == ("pedestrian 1" not in row["reason"])


def test_of_two_that_miss_somebody_the_better_one_is_nearer_to_them():
    truth = middle(range(10), track=3)
    x, y = ([at(f, c) for f in range(10)] for c in (60, 95))  # 10 px and 45 px off
    (better,) = of_kind(result_of(make_dataset(truth, x, y)), "x_better").to_dict("records")
    assert better["reason"].endswith(
        "X does, too, but its nearest detection is closer (up to 10 px away; the other: 45 px)."
    )
    (low, *_) = of_kind(result_of(make_dataset(truth, x, y)), "y").to_dict("records")
    assert low["reason"].endswith("X does, too.")


def test_the_reason_of_a_difference_is_what_makes_the_difference():
    # both miss track 1; Y's false alarm makes the difference
    result = result_of(make_dataset([at(0, 20, track=1)], y=[at(0, 70)]), alpha=0.6)
    assert of_kind(result, "y")["reason"].iloc[0].startswith("Y misses pedestrian 1")
    assert of_kind(result, "x_better")["reason"].iloc[0].startswith("Y has false alarms")


def test_differences_of_less_than_a_hundredth_are_noise():
    result = result_of(make_dataset(middle([0], w=40, track=1), [at(0, 50, w=40)],
                                  [at(0, 50.4, w=40)]))  # fmt: skip
    assert result.y.similarity[0] == pytest.approx(0.992)
    assert worst_moments(result).empty


def test_both_signs_of_the_difference_are_told():
    truth = middle(range(4), track=1)
    result = result_of(make_dataset(truth, middle([0, 1, 3]), middle([2, 3])))
    assert of_kind(result, "x_better")[["first_frame", "last_frame"]].to_numpy().tolist() == [
        [0, 1]
    ]
    assert of_kind(result, "y_better")["frame"].tolist() == [2]


def test_the_n_worst_come_first_and_recordings_are_kept_apart():
    # r0 ends and r1 starts with a miss: 2 and 3 frames; another one of 1 frame
    truth = [*middle(range(5), track=1), *middle(range(5), track=1, recording=1)]
    x = [*middle([0, 2]), *middle([3, 4], recording=1)]
    places = [Place(range(5)), Place(range(5))]
    result = result_of(make_dataset(truth, x, places=places))
    table = of_kind(result, "x", n=2)
    assert table["recording"].tolist() == ["r1", "r0"]
    assert table["recording_index"].tolist() == [1, 0]
    assert table["row"].tolist() == [5, 3]
    assert table["depth_s"].tolist() == pytest.approx([0.24, 0.16])


def test_without_any_low_frame_the_table_has_its_columns_and_no_rows():
    table = worst_moments(result_of(make_dataset(n_frames=3)))
    assert list(table)[:3] == ["kind", "recording", "recording_index"]
    assert len(table) == 0
    assert str(table["track"].dtype) == "Int64"


def test_no_frames_no_moments():
    assert worst_moments(result_of(make_dataset(frames=[]))).empty


def test_the_way_from_miss_to_miss_visits_those_of_both_systems(y_blind: Result):
    assert next_misses(y_blind, 0).tolist() == [2]
    truth = middle(range(6), track=1)
    result = result_of(make_dataset(truth, middle([0, 1, 3, 5]), middle([0, 3, 5])))
    assert next_misses(result, 0).tolist() == [1, 2, 4]


def test_misses_are_rows_within_their_recording():
    truth = [at(2, 50, track=1, recording=1)]
    result = result_of(make_dataset(truth, places=[Place(range(7)), Place(range(4))]))
    assert next_misses(result, 0).tolist() == []
    assert next_misses(result, 1).tolist() == [2]


def moments(truth, x=(), y=(), **more) -> list[dict[str, int]]:
    result = result_of(make_dataset(truth, x, y, **more), proximity="height")
    return encounter_moments(result).to_dict("records")


def test_the_first_missed_frame_is_told_for_each_system():
    truth = [at(f, 50, track=1) for f in range(10)]
    x, y = ([box for box in truth if box.frame not in gone] for gone in ((5, 6), (3,)))
    assert moments(truth, x, y) == [
        {"first_row": 0, "missed_row_x": 5, "missed_row_y": 3, "shown_row": 5}
    ]


def test_an_encounter_opens_where_the_heavier_failure_costs_most():
    # X misses three frames at the edge, Y two in the middle
    place = {0: 5, 1: 5, 2: 5, 3: 40, 4: 50, 5: 40}
    truth = [at(f, place[f], track=1) for f in range(6)]
    (row,) = moments(truth, truth[3:], [*truth[:4], truth[5]])
    assert row["shown_row"] == 4
    (row,) = moments(truth, truth[3:], truth)
    assert row["shown_row"] == 0


def test_an_encounter_opens_where_the_other_system_detects_the_pedestrian():
    # X misses all, Y two frames: the one that costs most, and another
    place = {0: 5, 1: 30, 2: 50, 3: 40, 4: 20, 5: 10}
    truth = [at(f, place[f], track=1) for f in range(6)]
    (row,) = moments(truth, [], [*truth[:2], *truth[3:5]])
    assert row["shown_row"] == 3  # in frame 2, which costs more, both miss
    (row,) = moments(truth, [], [])
    assert row["shown_row"] == 2


def test_an_encounter_without_a_miss_opens_where_it_begins_to_count():
    truth = [at(f, 50, track=1, h=3 if f < 4 else 50) for f in range(10)]
    assert moments(truth, truth, truth) == [
        {"first_row": 4, "missed_row_x": NEVER, "missed_row_y": NEVER, "shown_row": 4}
    ]


def test_a_miss_far_away_is_none():
    truth = [at(f, 50, track=1, h=3 if f < 4 else 50) for f in range(10)]
    (one,) = moments(truth, truth[7:], truth)
    assert (one["missed_row_x"], one["missed_row_y"]) == (4, NEVER)


def test_a_distant_encounter_opens_at_its_first_frame():
    (one,) = moments([at(f, 50, track=1, h=3) for f in (2, 3)])
    assert (one["first_row"], one["missed_row_x"], one["shown_row"]) == (2, NEVER, 2)


def test_rows_are_those_of_all_recordings_together():
    places = [Place(range(10)), Place(range(10))]
    truth = [at(f, 50, track=1, recording=1) for f in (6, 7)]
    (one,) = moments(truth, truth, truth[:1], places=places)
    assert (one["first_row"], one["missed_row_y"]) == (16, 17)


def test_a_track_that_stands_twice_in_a_frame_is_found_if_one_of_its_boxes_is():
    twice = [at(f, c, track=1) for f in range(3) for c in (20, 80)]
    (one,) = moments(twice, [box for box in twice if box.centre == 20], twice[:4])
    assert (one["missed_row_x"], one["missed_row_y"]) == (NEVER, 2)


def test_the_time_of_an_encounter_is_that_of_its_relevant_frames_and_the_missed_part_of_it():
    # ten frames at 10 fps, too far in four of them; X misses three that count, Y one, twice there
    truth = [at(f, 50, track=1, h=3 if f < 4 else 50) for f in range(10)]
    result = result_of(make_dataset(truth, truth[7:], truth[:9]), proximity="height")
    assert encounter_time(result, 0) == pytest.approx((0.6, 0.3, 0.1))
    twice = [at(f, c, track=1) for f in range(3) for c in (20, 80)]
    result = result_of(make_dataset(twice, [box for box in twice if box.centre == 20], twice[:4]))
    assert encounter_time(result, 0) == pytest.approx((0.3, 0, 0.1))


def test_a_distant_encounter_has_no_time():
    result = result_of(make_dataset([at(f, 50, track=1, h=3) for f in (2, 3)]), proximity="height")
    assert encounter_time(result, 0) == (0, 0, 0)


def test_without_encounters_the_columns_are_there():
    table = encounter_moments(result_of(make_dataset(n_frames=2)))
    columns = ["first_row", "missed_row_x", "missed_row_y", "shown_row"]
    assert (len(table), list(table)) == (0, columns)


def test_the_box_of_an_encounter_is_its_own_in_that_frame():
    truth = [at(f, c + f, track=t) for f in (2, 4) for t, c in ((1, 20), (2, 60))]
    result = result_of(make_dataset(truth, n_frames=6))
    x, _, w, _ = encounter_box(result, 1, 4)
    assert x + w / 2 == 64


@pytest.mark.parametrize("row", [3, 5])
def test_a_frame_without_the_pedestrian_has_no_box_of_it(row: int):
    truth = [at(f, 50, track=1) for f in (2, 4)]
    result = result_of(make_dataset([*truth, at(5, 20, track=2)], n_frames=6))
    with pytest.raises(ValueError, match=f"no box in row {row}"):
        encounter_box(result, 0, row)
