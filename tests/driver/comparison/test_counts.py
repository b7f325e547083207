"""All encounters of the Driver page and all urgent ones, in parts that add up."""

from __future__ import annotations

from approach import approach, only
from builders import NAN, Place, at, make_dataset, result_of

from nvcore.notes import Note
from nvcore.subjects.driver.comparison.notes import counts, driver_notes


def test_each_encounter_and_each_urgent_one_is_in_one_part():
    """In time are nobody, Y alone, X and Y, the driver too, and of the driver it is unknown."""
    late, always = range(30, 40), range(40)
    kinds = [(0.1, late, late), (0.1, late, always), (0.1, always, always)]
    kinds += [(0.9, always, always), (NAN, always, always)]
    truth, x, y = [], [], []
    for recording, (seen, by_x, by_y) in enumerate(kinds):
        boxes = approach(always, 5, recording=recording)
        truth += [box._replace(detectability=seen) for box in boxes]
        x += only(boxes, by_x)
        y += only(boxes, by_y)
    truth += [at(0, 5, h=4, track=9)._replace(detectability=0.5)]
    dataset = make_dataset(truth, x, y, places=[Place(always)] * len(kinds))
    result = result_of(dataset, proximity="height")
    assert counts(result).fields == {
        "n": 6,
        "n_seen": 1,
        "n_unseen": 3,
        "n_unknown": 1,
        "n_distant": 1,
    }
    in_time = Note("driver.in_time", n=4, driver=1, both=1, x=0, y=1, nobody=1)
    assert in_time in driver_notes(result)


def test_where_all_are_near_and_known_and_none_is_urgent_no_more_is_said():
    truth = [at(0, 50)._replace(detectability=0.1)]
    result = result_of(make_dataset(truth, x=[at(0, 50)], n_frames=1))
    assert [*counts(result).fields.values()] == [1, 0, 1, 0, 0]
