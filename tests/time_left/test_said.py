"""What time left has to say of one encounter, and of the speed of the car."""

from __future__ import annotations

import numpy as np
import pytest
from approach import PLACE, approach, only
from builders import Place, at, make_dataset, result_of

from nvcore.comparison import Result
from nvcore.objects import PEDESTRIAN
from nvcore.params import Params
from nvcore.sentences import say
from nvcore.time_left.facts import (
    Ahead,
    Equal,
    FewUrgent,
    LastChance,
    OrderOverSpeed,
    OverSpeed,
    SpeedOfOne,
    WhyUnknown,
)
from nvcore.time_left.said import few_urgent, last_chance, needed, orders
from nvcore.time_left.steps import time_left_in

ASSUMED = SpeedOfOne("assumed", 50)


def met(boxes=None, place=PLACE, **params) -> Result:
    boxes = approach(range(40), 5) if boxes is None else boxes
    detections = only(boxes, range(10, 40))
    return result_of(make_dataset(boxes, detections, places=[place]), **params)


def test_an_urgent_encounter_says_when_and_what_each_system_did():
    assert say(last_chance(met(), 0), PEDESTRIAN) == (
        "Urgent at 50 km/h (assumed): the last chance to stop is frame 29 (2.90 s). X confirms him "
        "1.70 s before it, in time. Y never confirms him: impact at 50 km/h."
    )


@pytest.mark.parametrize(
    ("result", "kind", "why"),
    [
        (met([at(frame, 50, track=1) for frame in range(20)]), "never nearer", None),
        (met(approach(range(4), 5)), "unknown", "short"),
        (met(approach(range(0, 40, 2), 5), Place(range(0, 40, 2))), "unknown", "sampled"),
        (met([box._replace(track=-1) for box in approach(range(40), 5)]), "unknown", "linked"),
    ],
)
def test_whoever_is_not_urgent_has_the_reason(result: Result, kind: str, why: str | None):
    chance = last_chance(result, 0)
    assert (chance.kind, chance.why) == (kind, why and WhyUnknown(why))


def test_whoever_could_not_be_stopped_for_has_the_place():
    outside = last_chance(met(approach(range(40), 5, centre=80), corridor=0.1), 0)
    assert outside == LastChance("outside", speed=ASSUMED, frame=29, time_s=pytest.approx(2.9))
    near = met(approach(range(20), 2.1), Place(range(40), height=4000.0))
    assert last_chance(near, 0) == LastChance("no chance", speed=ASSUMED)  # in the first frame
    calm = last_chance(met(reaction_s=0.0), 0)
    assert calm == LastChance("not urgent", speed=ASSUMED, least_s=pytest.approx(1.1))


def test_a_recording_that_states_its_speed_assumes_none():
    result = met()
    own = result.dataset.recordings.assign(speed_kmh=[30.0])
    stated = type(result.dataset)(
        own, result.dataset.frames, result.dataset.boxes, result.dataset.systems, "f"
    )
    assert last_chance(result_of(stated), 0).speed == SpeedOfOne("own", 30)


def test_what_is_needed_to_stop_follows_the_settings():
    fact = needed(Params(speed_kmh=100, reaction_s=1.0, deceleration=5))
    assert fact.needed_s == pytest.approx(1 + 100 / 3.6 / 10)
    assert (fact.speed_kmh, fact.reaction_s, fact.deceleration) == (100, 1, 5)


def test_few_urgent_encounters_are_called_few():
    assert few_urgent(met()) == (FewUrgent("one", 1),)
    assert few_urgent(met(reaction_s=0.0)) == ()
    boxes = [box for t in range(10) for box in approach(range(40), 5, centre=32 + 4 * t, track=t)]
    assert few_urgent(met(boxes[: 9 * 40])) == (FewUrgent("many", 9),)
    assert few_urgent(met(boxes)) == ()


def test_who_is_ahead_at_which_speed():
    curve = time_left_in(met()).over_speed
    speeds, measure = curve["speed_kmh"].to_numpy(), OverSpeed("share_in_time")
    x = Ahead("share_in_time", "x")
    first, second = orders(curve)
    assert first == OrderOverSpeed("always", measure, x, "y")
    assert (second.kind, second.ahead) == ("always", Ahead("mean_impact_kmh", "x"))
    even = curve.assign(share_in_time_y=curve["share_in_time_x"])
    assert orders(even)[0] == OrderOverSpeed("same", measure)
    once = curve.assign(share_in_time_x=0.5, share_in_time_y=np.where(speeds < 90, 0.0, 1.0))
    assert orders(once)[0] == OrderOverSpeed("once", measure, x, "y", (90,))
    some = curve.assign(share_in_time_x=1.0, share_in_time_y=np.where(speeds < 20, 1.0, 0.0))
    assert orders(some)[0] == OrderOverSpeed("always", measure, x, "y", equal=Equal("but", 2, 25))
    share = np.select([speeds < 50, speeds < 90], [0.0, 0.5], 1.0)
    tied = orders(curve.assign(share_in_time_x=0.5, share_in_time_y=share))[0]
    assert tied == OrderOverSpeed("once", measure, x, "y", (90,), Equal("addition", 8, 25))
    assert say(tied, PEDESTRIAN) == (
        "Below 90 km/h X confirms the larger share in time, from there on Y; at 8 of 25 speeds X "
        "and Y are equal."
    )
    often = curve.assign(share_in_time_x=0.5, share_in_time_y=np.where(speeds % 20 < 10, 0.0, 1.0))
    assert orders(often)[0].kind == "often"
    still = met([at(frame, 50, track=1) for frame in range(20)])
    assert orders(time_left_in(still).over_speed) == ()
