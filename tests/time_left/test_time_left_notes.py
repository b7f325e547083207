"""Notes about time left: which one is made of which encounters, with which numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from approach import PLACE, approach, only
from builders import Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result, compare
from nvcore.notes import Note, say
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params
from nvcore.subjects.time_left.notes import (
    confirmed,
    few_urgent,
    last_chance,
    needed,
    orders,
    urgent,
)
from nvcore.subjects.time_left.steps import time_left_in

ASSUMED = Note("time_left.speed", kmh=50.0)
ASSUMED_OF_ONE = Note("time_left.speed_of_one", kmh=[50.0], is_stated=False)


def met(boxes=None, place=PLACE, **params) -> Result:
    boxes = approach(range(40), 5) if boxes is None else boxes
    detections = only(boxes, range(10, 40))
    return result_of(make_dataset(boxes, detections, places=[place]), **params)


def test_an_urgent_encounter_says_when_and_what_each_system_did():
    assert say(last_chance(met(), 0), PEDESTRIAN) == (
        "Urgent at 50 km/h (assumed): the last chance to stop is frame 29 (2.90 s). X confirms the "
        "pedestrian in time, 1.70 s before the last chance. Y never confirms the "
        "pedestrian: impact at 50 km/h."
    )


@pytest.mark.parametrize(
    ("result", "why"),
    [
        (met(approach(range(4), 5)), "short"),
        (met(approach(range(0, 40, 2), 5), Place(range(0, 40, 2))), "sampled"),
        (met([box._replace(track=-1) for box in approach(range(40), 5)]), "linked"),
    ],
)
def test_an_encounter_without_time_to_contact_has_the_reason(result: Result, why: str):
    assert last_chance(result, 0) == Note("time_left.one_unknown", why=why)


def test_an_encounter_that_is_not_urgent_says_how_near_the_car_comes():
    still = last_chance(met([at(frame, 50, track=1) for frame in range(20)]), 0)
    assert still == Note("time_left.one_not_urgent", speed=ASSUMED_OF_ONE)
    calm = last_chance(met(reaction_s=0.0), 0)
    least_s = pytest.approx(1.1)
    assert calm == Note("time_left.one_not_urgent", speed=ASSUMED_OF_ONE, least_s=least_s)


def test_an_encounter_outside_the_corridor_or_too_near_has_the_place():
    outside = last_chance(met(approach(range(40), 5, centre=80), corridor=0.1), 0)
    assert (outside["urgency"], outside["speed"]) == ("outside", ASSUMED_OF_ONE)
    assert (outside["frame"], outside["time_s"]) == (29, pytest.approx(2.9))
    assert "responses" not in outside.fields
    near = last_chance(met(approach(range(20), 2.1), Place(range(40), height=4000.0)), 0)
    assert (near["urgency"], near["frame"]) == ("no_chance", 0)


def test_a_recording_that_states_its_speed_assumes_none():
    dataset = met().dataset
    stated = replace(dataset, recordings=dataset.recordings.assign(speed_kmh=[30.0]))
    own = Note("time_left.speed_of_one", kmh=[30.0], is_stated=True)
    assert last_chance(result_of(stated), 0)["speed"] == own


def test_without_a_last_chance_a_series_has_its_span_with_the_assumed_speed():
    dataset = met([at(frame, 50, track=1) for frame in range(20)]).dataset
    speeds = np.where(np.arange(40) < 10, 60.0 + np.arange(40), np.nan)
    result = result_of(replace(dataset, frames=dataset.frames.assign(speed_kmh=speeds)))
    span = Note("time_left.speed_of_one", kmh=[50.0, 69.0], is_stated=False)
    assert last_chance(result, 0).fields == {"speed": span}
    assert say(span, PEDESTRIAN) == "50.0 to 69.0 km/h (assumed in some frames)"


def test_what_is_needed_to_stop_follows_the_settings():
    note = needed(Params(speed_kmh=100, reaction_s=1.0, deceleration=5))
    assert note["needed_s"] == pytest.approx(1 + 100 / 3.6 / 10)
    assert (note["speed_kmh"], note["reaction_s"], note["deceleration"]) == (100, 1, 5)


def test_few_urgent_encounters_are_called_few():
    assert few_urgent(met()) == (Note("time_left.few_urgent", n=1),)
    assert few_urgent(met(reaction_s=0.0)) == ()
    boxes = [box for t in range(10) for box in approach(range(40), 5, centre=32 + 4 * t, track=t)]
    assert few_urgent(met(boxes[: 9 * 40])) == (Note("time_left.few_urgent", n=9),)
    assert few_urgent(met(boxes)) == ()


def test_who_is_ahead_at_which_speed():
    curve = time_left_in(met()).over_speed
    speeds = curve["speed_kmh"].to_numpy()

    def order(y: object) -> dict[str, object]:
        return orders(curve.assign(share_in_time_x=0.5, share_in_time_y=y))[0].fields

    ahead = {"measure": "share_in_time", "first": "x", "second": "y", "turns_kmh": [], "n_all": 25}
    first, second = orders(curve)
    assert first.fields == ahead
    assert second.fields == {**ahead, "measure": "mean_impact_kmh"}
    assert order(0.5) == {"measure": "share_in_time"}
    assert order(np.where(speeds < 90, 0.0, 1.0)) == {**ahead, "turns_kmh": [90]}
    assert order(np.where(speeds < 20, 0.5, 0.0)) == {**ahead, "n_equal": 2}
    tied = order(np.select([speeds < 50, speeds < 90], [0.0, 0.5], 1.0))
    assert tied == {**ahead, "turns_kmh": [90], "n_equal": 8}
    assert len(order(np.where(speeds % 20 < 10, 0.0, 1.0))["turns_kmh"]) > 2
    still = met([at(frame, 50, track=1) for frame in range(20)])
    assert orders(time_left_in(still).over_speed) == ()


def test_who_is_urgent_and_why_others_are_not():
    people = [
        *approach(range(40), 5, centre=20, track=1),
        *approach(range(20), 2.1, centre=50, track=2),
        *approach(range(4), 5, centre=70, track=3),
        *(at(f, 85, track=4) for f in range(40)),
    ]
    tall = PLACE._replace(height=4000.0)
    result = result_of(make_dataset(sorted(people), places=[tall]))
    others = [
        Note("time_left.not_urgent", n=1, urgency="no_chance"),
        Note("time_left.not_urgent", n=1, urgency="not_urgent"),
        Note(
            "time_left.not_urgent",
            n=1,
            urgency="unknown",
            reasons=[Note("time_left.unknown", why="short")],
        ),
    ]
    assert urgent(result) == Note("time_left.urgent", n=1, speed=ASSUMED, others=others, n_all=4)
    corridor = urgent(result_of(result.dataset, corridor=0.5))
    assert corridor["n"] == 0
    assert Note("time_left.not_urgent", n=1, urgency="outside") in corridor["others"]


def test_distant_encounters_are_said_to_be_among_those_counted():
    far = [at(f, 85, track=2, h=5) for f in range(40)]
    result = compare(make_dataset([*approach(range(40), 5), *far], places=[PLACE]))
    assert result.venn.distant == 1
    note = urgent(result)
    assert (note["n"], note["n_all"], note["n_distant"]) == (1, 2, 1)
    assert note["others"] == [Note("time_left.not_urgent", n=1, urgency="not_urgent")]


def test_nobody_urgent_and_nothing_known_are_told_apart():
    still = result_of(make_dataset([at(f, 50, track=1) for f in range(20)]))
    assert urgent(still) == Note("time_left.urgent", n=0, speed=ASSUMED, others=[])
    assert confirmed(still) == ()
    sampled = make_dataset(approach(range(0, 40, 2), 5), places=[Place(range(0, 40, 2))])
    linked = make_dataset([b._replace(track=-1) for b in approach(range(40), 5)], places=[PLACE])
    for dataset, why in ((sampled, "sampled"), (linked, "linked")):
        reasons = [Note("time_left.unknown", why=why)]
        assert urgent(result_of(dataset)) == Note("time_left.all_unknown", reasons=reasons)


def test_of_several_reasons_each_has_its_count():
    boxes = [box._replace(track=-1) for box in approach(range(40), 5)]
    sampled = approach(range(0, 40, 2), 5, recording=1)
    places = [PLACE, Place(range(0, 40, 2))]
    note = urgent(result_of(make_dataset([*boxes, *sampled], places=places)))
    assert [reason.fields for reason in note["reasons"]] == [
        {"why": "sampled", "n": 1},
        {"why": "linked", "n": 1},
    ]


def test_the_verdict_tells_who_leaves_time_to_stop():
    boxes = approach(range(40), 5)
    result = result_of(make_dataset(boxes, boxes, only(boxes, range(38, 40)), places=[PLACE]))
    (note,) = confirmed(result)
    assert (note["n"], note["x"], note["y"]) == (1, 1, 0)
    assert (note["impact_x"], note["impact_y"]) == (0, pytest.approx(50))
    assert note["speed"] == ASSUMED


def test_speeds_of_recordings_are_told_from_the_assumed_one():
    boxes = [box for r in range(2) for box in approach(range(40), 5, recording=r)]
    dataset = make_dataset(boxes, places=[PLACE] * 2)
    for speeds, n_assumed in (([30.0, np.nan], 1), ([30.0, 90.0], None)):
        stated = replace(dataset, recordings=dataset.recordings.assign(speed_kmh=speeds))
        speed = Note("time_left.speed", by="recording", kmh=50.0, n_assumed=n_assumed)
        assert urgent(result_of(stated))["speed"] == speed
