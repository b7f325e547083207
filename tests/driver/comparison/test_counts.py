"""All encounters of the Driver page and all urgent ones, in parts that add up."""

from __future__ import annotations

from approach import approach, only
from builders import NAN, Place, at, make_dataset, result_of

from nvcore.driver.comparison.texts import describe_counts, describe_driver


def test_each_encounter_and_each_urgent_one_is_in_one_part():
    """In time are nobody, Y alone, X and Y, the driver too, and it is unknown of him."""
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
    assert describe_counts(result) == (
        "6 encounters in all: 1 seen by the driver, 3 not seen, 1 unknown, 1 distant (never near "
        "enough to count)."
    )
    assert (
        "Of 4 urgent encounters of which it is known, the driver is in time unaided in 1; of "
        "the others, both systems are in 1, X alone in 0, Y alone in 1, none of them in 1."
    ) in describe_driver(result)


def test_where_all_are_near_and_known_and_none_is_urgent_no_more_is_said():
    truth = [at(0, 50)._replace(detectability=0.1)]
    result = result_of(make_dataset(truth, x=[at(0, 50)], n_frames=1))
    assert describe_counts(result) == ("1 encounter in all: 0 seen by the driver, 1 not seen.")
