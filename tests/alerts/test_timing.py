"""When an alert begins and ends: counted by hand in a drive of ten frames a second."""

from __future__ import annotations

import pytest
from approach import PLACE
from builders import Box, at, make_dataset, result_of

from nvcore.dataset.schema import NO_TRACK
from nvcore.subjects.alerts.steps import alerts_in

AT_ONCE = {"alert_on_s": 0.0, "alert_off_s": 0.0, "alert_least_s": 0.0, "alert_pause_s": 0.0}


def spans(boxes: list[Box], **policy: object) -> list[tuple[int, int]]:
    """First and last frame of each alert."""
    params = {"alerts": "policy", "alert_corridor": 1, **AT_ONCE, **policy}
    result = result_of(make_dataset([], boxes, places=[PLACE]), **params)
    table = alerts_in(result).table
    return list(zip(table["start_frame"], table["end_frame"], strict=True))


def seen(*frames: int, track: int = 7, **more: float) -> list[Box]:
    """Boxes of one track in these frames, from 0 to 39."""
    return [at(frame, 50, track=track, **more) for frame in frames]


def test_every_run_of_boxes_is_an_alert():
    assert spans(seen(0, 1, 2, 5, 9)) == [(0, 2), (5, 5), (9, 9)]


@pytest.mark.parametrize(
    ("frames", "expected"),
    [
        (range(10), [(3, 9)]),
        ([0, 1, 2, 4, 5, 6, 7, 8], [(7, 8)]),  # frame 3 is missing: it starts anew
        ([0, 1, 2], []),
    ],
)
def test_it_begins_once_a_run_is_long_enough(frames, expected):
    assert spans(seen(*frames), alert_on_s=0.3) == expected


@pytest.mark.parametrize(
    ("frames", "expected"),
    [
        ([0, 1, 2, 4], [(0, 6)]),  # on for two frames more
        ([0, 1, 2, 5], [(0, 7)]),  # on in frame 4, and in frame 5 by its own box
        ([0, 1, 2, 6], [(0, 4), (6, 8)]),  # off in frame 5
        ([*range(12, 18), 20, 21], [(12, 23)]),  # a detector that misses two frames
        ([38], [(38, 39)]),  # the recording ends
    ],
)
def test_it_ends_so_long_after_the_last_box(frames, expected):
    assert spans(seen(*frames), alert_off_s=0.2) == expected


def test_it_lasts_at_least_so_long_and_what_comes_meanwhile_is_part_of_it():
    assert spans(seen(3), alert_least_s=1.0) == [(3, 12)]
    assert spans(seen(3, 10), alert_least_s=1.0) == [(3, 12)]
    assert spans(seen(3, 12, 13, 14), alert_least_s=1.0) == [(3, 14)]
    assert spans(seen(3, 13, 14), alert_least_s=1.0) == [(3, 14)]
    assert spans(seen(3, 14), alert_least_s=1.0) == [(3, 12), (14, 23)]


def test_after_it_the_track_pauses_and_no_other():
    # the alert of frame 0 ends at 0.1 s
    assert spans(seen(0, 10, 15), alert_pause_s=1.0) == [(0, 0), (15, 15)]
    assert spans(seen(0, 11, 15), alert_pause_s=1.0) == [(0, 0), (11, 11)]
    assert spans(seen(0, *range(9, 14)), alert_pause_s=1.0) == [(0, 0), (11, 13)]
    both = [*seen(0, 5), *seen(6, track=8)]
    assert spans(both, alert_pause_s=1.0) == [(0, 0), (6, 6)]


def test_a_track_that_is_back_before_its_alert_was_off_needs_no_pause():
    policy = {"alert_off_s": 0.2, "alert_pause_s": 2.0}
    assert spans(seen(0, 3, 6, 9), **policy) == [(0, 11)]
    assert spans(seen(0, 3, 7), **policy) == [(0, 5)]
    # nor does it have to meet the policy for so long again
    assert spans(seen(0, 1, 4), alert_on_s=0.1, **policy) == [(1, 6)]


def test_boxes_without_a_track_are_linked_over_two_missing_frames():
    boxes = seen(0, 3, 7, track=NO_TRACK)
    assert spans(boxes, alert_off_s=0.5) == [(0, 8), (7, 12)]
    apart = [at(0, 20), at(1, 80)]
    assert spans(apart, alert_off_s=0.5) == [(0, 5), (1, 6)]


def test_boxes_must_be_near_in_the_corridor_and_score_enough():
    near = {"proximity": "height", "alert_k": 0.5}  # 10 px
    assert spans([*seen(0, h=9.9), *seen(1, h=10.1)], **near) == [(1, 1)]
    aside = [at(0, 81, track=7), at(1, 79, track=7)]  # 31 and 29 of 50 px from the middle
    assert spans(aside, alert_corridor=0.6) == [(1, 1)]
    scored = [*seen(0, score=0.4), *seen(1, score=0.5), *seen(2)]
    assert spans(scored, alert_score=0.5) == [(1, 2)]  # without a score it has decided itself


def test_a_reported_distance_decides_in_place_of_the_weight():
    policy = {"proximity": "height", "alert_k": 0.5, "alert_distance_m": 30.0}
    boxes = [*seen(0, h=9.0, distance_m=29.0), *seen(1, h=50.0, distance_m=31.0)]
    assert spans([*boxes, *seen(3, h=50.0), *seen(5, h=9.0)], **policy) == [(0, 0), (3, 3)]


def test_alerts_do_not_cross_recordings():
    boxes = [*seen(39), *(box._replace(recording=1) for box in seen(0))]
    dataset = make_dataset([], boxes, places=[PLACE, PLACE])
    policy = {**AT_ONCE, "alert_off_s": 1.0, "alert_pause_s": 5.0}
    table = alerts_in(result_of(dataset, alerts="policy", **policy)).table
    assert table[["recording", "start_frame", "end_frame"]].values.tolist() == [
        ["r0", 39, 39],
        ["r1", 0, 10],
    ]
