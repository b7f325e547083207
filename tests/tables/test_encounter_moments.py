"""Which frames of an encounter are worth opening."""

from __future__ import annotations

import pytest
from builders import Place, at, make_dataset, result_of

from nvcore.tables.moments import NEVER, encounter_box, encounter_moments


def moments(truth, x=(), y=(), **more) -> list[dict[str, int]]:
    result = result_of(make_dataset(truth, x, y, **more), proximity="height")
    return encounter_moments(result).to_dict("records")


def test_the_first_missed_frame_is_told_for_each_system():
    truth = [at(f, 50, track=1) for f in range(10)]
    x, y = ([box for box in truth if box.frame not in gone] for gone in ((5, 6), (3,)))
    assert moments(truth, x, y) == [
        {"first_row": 0, "missed_row_x": 5, "missed_row_y": 3, "shown_row": 3}
    ]


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
