"""Time left in words."""

from __future__ import annotations

import numpy as np
import pytest
from approach import PLACE, approach, only
from builders import Place, at, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.objects import PEDESTRIAN
from nvcore.params import Params
from nvcore.time_left.steps import time_left_in
from nvcore.time_left.texts import (
    describe_encounter,
    describe_needed,
    describe_turns,
    few_urgent,
)


def met(boxes=None, place=PLACE, **params) -> Result:
    boxes = approach(range(40), 5) if boxes is None else boxes
    found = only(boxes, range(10, 40))
    return result_of(make_dataset(boxes, found, places=[place]), **params)


def test_an_urgent_encounter_says_when_and_what_each_system_did():
    assert describe_encounter(met(), 0) == (
        "Urgent at 50 km/h (assumed): the last chance to stop is frame 29 (2.90 s). X confirms him "
        "1.70 s before it, in time. Y never confirms him: impact at 50 km/h."
    )


@pytest.mark.parametrize(
    ("result", "text"),
    [
        (met(reaction_s=0.0), "Not urgent at 50 km/h (assumed): never less than 1.1 s to contact."),
        (
            met([at(frame, 50, track=1) for frame in range(20)]),
            "Not urgent: the car never comes nearer, as far as the boxes tell.",
        ),
        (
            met(approach(range(20), 2.1), Place(range(40), height=4000.0)),
            "No chance at 50 km/h (assumed): too near to stop when first known, in frame 0 "
            "(0.00 s).",
        ),
        (
            met(approach(range(40), 5, centre=80), corridor=0.1),
            "Outside the corridor when he becomes urgent at 50 km/h (assumed), in frame 29 "
            "(2.90 s).",
        ),
        (
            met(approach(range(4), 5)),
            "Time left to stop is unknown: he is there for too few frames, or cut by the picture's "
            "edge.",
        ),
        (
            met(approach(range(0, 40, 2), 5), Place(range(0, 40, 2))),
            "Time left to stop is unknown: not every frame is evaluated.",
        ),
        (
            met([box._replace(track=-1) for box in approach(range(40), 5)]),
            "Time left to stop is unknown: the truth gives this pedestrian no track id.",
        ),
    ],
    ids=["not urgent", "standing", "no chance", "outside", "short", "sampled", "linked"],
)
def test_whoever_is_not_urgent_has_the_reason(result: Result, text: str):
    assert describe_encounter(result, 0) == text


def test_a_recording_that_states_its_speed_assumes_none():
    result = met()
    own = result.dataset.recordings.assign(speed_kmh=[30.0])
    stated = type(result.dataset)(
        own, result.dataset.frames, result.dataset.boxes, result.dataset.systems, "f"
    )
    assert describe_encounter(result_of(stated), 0).startswith("Urgent at 30 km/h: the last")


def test_what_is_needed_to_stop_follows_the_settings():
    text = describe_needed(Params(speed_kmh=100, reaction_s=1.0, deceleration=5), PEDESTRIAN)
    assert "At 100 km/h the car still stops" in text
    assert "more than 3.8 s before contact: 1 s pass" in text  # 1 + 27.8 / 10


def test_few_urgent_encounters_are_called_few():
    assert few_urgent(0) == few_urgent(10) == ""
    assert few_urgent(1).startswith("The only urgent encounter says what happened")
    assert few_urgent(9).startswith("9 urgent encounters are few")


def test_who_is_ahead_at_which_speed():
    curve = time_left_in(met()).over_speed
    speeds = curve["speed_kmh"].to_numpy()
    first, second = describe_turns(curve)
    assert first == "X confirms the larger share in time at every speed."
    assert second.startswith("X has the lower mean impact speed at every speed")
    even = curve.assign(share_in_time_y=curve["share_in_time_x"])
    assert describe_turns(even)[0] == "The share in time of X and Y is the same at every speed."
    once = curve.assign(share_in_time_x=0.5, share_in_time_y=np.where(speeds < 90, 0.0, 1.0))
    assert describe_turns(once)[0] == (
        "Below 90 km/h X confirms the larger share in time, from there on Y."
    )
    share = np.select([speeds < 50, speeds < 90], [0.0, 0.5], 1.0)
    some = curve.assign(share_in_time_x=1.0, share_in_time_y=np.where(speeds < 20, 1.0, 0.0))
    assert describe_turns(some)[0] == (
        "X confirms the larger share in time at every speed but 2 of 25, at which X and Y are "
        "equal."
    )
    tied = curve.assign(share_in_time_x=0.5, share_in_time_y=share)
    assert describe_turns(tied)[0] == (
        "Below 90 km/h X confirms the larger share in time, from there on Y; at 8 of 25 speeds X "
        "and Y are equal."
    )
    often = curve.assign(share_in_time_x=0.5, share_in_time_y=np.where(speeds % 20 < 10, 0.0, 1.0))
    assert describe_turns(often)[0].startswith("The share in time turns ")
    still = met([at(frame, 50, track=1) for frame in range(20)])
    assert describe_turns(time_left_in(still).over_speed) == ()
