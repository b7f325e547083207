"""Time to contact, the last chance to stop, confirmation, impact speed: countable by hand."""

from __future__ import annotations

import numpy as np
import pytest
from approach import PLACE, approach, only
from builders import NAN, Box, Place, at, make_dataset, result_of
from hypothesis import given
from hypothesis import strategies as st

from nvcore.comparison.compare import Result, compare
from nvcore.settings.params import Params
from nvcore.subjects.time_left.judging import SPEEDS_KMH, turning_speeds
from nvcore.subjects.time_left.steps import confirmed_by, time_left_in, time_left_of

# At 50 km/h the car needs 1.2 s + 13.889 / 14 s = 2.1921 s: with contact after 5 s the last chance
# is frame 29 (2.1 s left), the first of ten a second that is below.
CONTACT_S = 5.0
LAST_CHANCE = 29


def met(x=(), y=(), *, boxes=None, place=PLACE, **params) -> Result:
    """The comparison of one pedestrian who is driven up to."""
    boxes = approach(range(40), CONTACT_S) if boxes is None else boxes
    return result_of(make_dataset(boxes, only(boxes, x), only(boxes, y), places=[place]), **params)


def ttc_of(result: Result) -> list[float]:
    return time_left_in(result).contact.ttc_s.round(6).tolist()


def test_on_an_exact_line_time_to_contact_is_exact_in_every_frame():
    left = [round(CONTACT_S - frame / 10, 6) for frame in range(40)]
    assert ttc_of(met()) == left


def test_distances_are_taken_where_every_box_has_one():
    boxes = [box._replace(distance_m=10.0 * (7 - box.frame / 10)) for box in approach(range(40), 5)]
    assert ttc_of(met(boxes=boxes))[:2] == [7.0, 6.9]
    boxes[20] = boxes[20]._replace(distance_m=NAN)
    assert ttc_of(met(boxes=boxes))[:2] == [5.0, 4.9]


def test_who_stands_still_relative_to_the_car_is_never_reached():
    result = result_of(make_dataset([at(f, 50, track=1) for f in range(20)]))
    assert ttc_of(result) == [np.inf] * 20
    assert time_left_in(result).urgency["urgency"].tolist() == ["not_urgent"]
    assert time_left_in(result).urgency["min_ttc_s"].tolist() == [np.inf]


def test_who_gets_smaller_or_jitters_is_not_being_approached():
    away = [at(f, 50, h=60.0 - f, track=1) for f in range(20)]
    assert set(ttc_of(result_of(make_dataset(away)))) == {np.inf}
    jitter = [at(f, 50, h=50.0 + (-1) ** f, track=1) for f in range(20)]
    assert set(ttc_of(result_of(make_dataset(jitter)))) == {np.inf}


def test_contact_in_the_past_is_contact_now():
    boxes = approach(range(10), 1.2)
    late = [boxes[-1]._replace(frame=frame) for frame in range(10, 13)]
    result = met(boxes=[*boxes, *late], place=Place(range(13), height=2000.0))
    assert min(ttc_of(result)) >= 0


def test_fewer_than_five_boxes_in_the_window_are_unknown():
    boxes = approach(range(40), CONTACT_S)
    short = met(boxes=boxes[:4])
    assert np.isnan(time_left_in(short).contact.ttc_s).all()
    assert time_left_in(short).urgency["urgency"].tolist() == ["unknown"]
    assert np.isnan(time_left_in(short).urgency["min_ttc_s"]).all()
    assert not np.isnan(time_left_in(met(boxes=boxes[:5])).contact.ttc_s).any()


def test_the_window_includes_its_edges():
    boxes = approach(range(40), CONTACT_S)
    assert not np.isnan(
        time_left_in(met(boxes=boxes, ttc_window=0.8)).contact.ttc_s[0]
    )  # 0.4 s: frames 0 to 4
    first = time_left_in(met(boxes=boxes, ttc_window=0.78)).contact.ttc_s[:2]
    assert np.isnan(first[0])
    assert np.isfinite(first[1])


def test_a_cut_box_has_no_time_of_its_own_but_may_be_told_by_the_others():
    boxes = approach(range(40), CONTACT_S)
    cut = [box._replace(y=1.0, h=box.h + 20) if box.frame == 10 else box for box in boxes]
    assert ttc_of(met(boxes=cut)) == ttc_of(met(boxes=boxes))
    all_cut = [box._replace(x=90.0 - box.w + 9.0) for box in boxes]  # right edges at 99 of 100 px
    assert np.isnan(time_left_in(met(boxes=all_cut)).contact.ttc_s).all()
    inside = [box._replace(x=box.x - 0.001) for box in all_cut]
    assert ttc_of(met(boxes=inside)) == ttc_of(met(boxes=boxes))


def test_a_gap_is_skipped_and_ignored_boxes_do_not_count():
    boxes = approach(range(40), CONTACT_S)
    with_gap = [box for box in boxes if not 10 <= box.frame < 14]
    assert ttc_of(met(boxes=with_gap)) == [round(5 - box.frame / 10, 6) for box in with_gap]
    ignored = [box._replace(ignore=box.frame < 10) for box in boxes]
    known = np.isnan(time_left_in(met(boxes=ignored)).contact.ttc_s)
    assert known.tolist() == [True] * 10 + [False] * 30


def test_a_track_that_occurs_twice_in_a_frame_is_where_he_is_nearest():
    boxes = approach(range(40), CONTACT_S)
    twice = [*boxes, *(box._replace(h=box.h / 2, x=20.0) for box in boxes)]
    assert time_left_in(met(boxes=sorted(twice))).urgency.equals(
        time_left_in(met(boxes=boxes)).urgency
    )


def test_the_last_chance_is_the_first_frame_with_less_time_than_needed():
    urgency = time_left_in(met()).urgency.iloc[0]
    assert (urgency["urgency"], urgency["urgent_row"]) == ("urgent", LAST_CHANCE)
    assert urgency["min_ttc_s"] == pytest.approx(1.1)
    assert time_left_in(met(reaction_s=0.0)).urgency["urgent_row"].tolist() == [
        -1
    ]  # 0.99 s are never left
    assert time_left_in(met(deceleration=3.5)).urgency["urgent_row"].tolist() == [19]  # 3.18 s


def test_who_is_too_near_when_first_known_leaves_no_chance():
    near = met(boxes=approach(range(20), 2.1), place=Place(range(40), height=4000.0))
    assert time_left_in(near).urgency["urgency"].tolist() == ["no_chance"]
    assert time_left_of(near.x)["time_left"].tolist() == [None]
    assert time_left_in(near).count_urgency()["no_chance"] == 1


def test_who_is_outside_the_corridor_does_not_count():
    boxes = approach(range(40), CONTACT_S, centre=80)
    assert time_left_in(met(boxes=boxes, corridor=0.6)).urgency["urgency"].tolist() == ["urgent"]
    assert time_left_in(met(boxes=boxes, corridor=0.59)).urgency["urgency"].tolist() == ["outside"]
    near = approach(range(20), 2.1, centre=80)
    outside = met(boxes=near, corridor=0.5, place=Place(range(40), height=4000.0))
    assert time_left_in(outside).urgency["urgency"].tolist() == ["outside"]  # before no_chance


@pytest.mark.parametrize(
    ("matched", "confirmed"),
    [
        ([0, 1, 2], 2),  # fewer frames at the start
        ([0, 2, 4], 4),
        ([0, 1, 5], -1),  # frame 5 looks back to frame 1
        ([1, 2, 5], 5),
        ([10, 20, 30, 31, 33], 33),
        ([], -1),
    ],
)
def test_three_of_the_last_five_frames_confirm(matched, confirmed):
    assert confirmed_by(met(matched).x)["confirmed_row"].tolist() == [confirmed]


def test_the_last_frames_are_those_of_the_track():
    boxes = [box for box in approach(range(40), CONTACT_S) if not 3 <= box.frame < 9]
    assert confirmed_by(met([1, 2, 9], boxes=boxes).x)["confirmed_row"].tolist() == [9]


def test_in_time_late_and_never_with_margin_and_impact_speed():
    before, at_it = range(26, 40), range(27, 40)  # confirmed in frames 28 and 29
    result = met(before, at_it)
    assert time_left_of(result.x).values.tolist() == [["in_time", pytest.approx(0.1), 0.0]]
    late = time_left_of(result.y).iloc[0]
    assert (late["time_left"], late["margin_s"]) == ("late", 0)
    v = 50 / 3.6  # 2.1 s left: braking over v * 0.9 m
    assert late["impact_kmh"] == pytest.approx(3.6 * np.sqrt(v**2 - 2 * 7 * v * 0.9))
    never = time_left_of(met(()).x).iloc[0]
    assert (never["time_left"], never["impact_kmh"]) == ("never", pytest.approx(50))
    assert np.isnan(never["margin_s"])


def test_who_is_confirmed_with_no_more_than_the_reaction_time_left_is_hit_at_full_speed():
    assert time_left_of(met(range(36, 40)).x)["impact_kmh"].tolist() == pytest.approx([50])  # 1.2 s


def test_an_unknown_time_to_contact_is_that_of_the_nearest_frame_before():
    boxes = approach(range(40), CONTACT_S)
    lost = [box._replace(x=0.0) if box.frame > 32 else box for box in boxes]
    result = met(range(37, 40), boxes=lost, ttc_window=0.5)  # 5 boxes: frames 30 - 2 to 30 + 2
    known = np.flatnonzero(~np.isnan(time_left_in(result).contact.ttc_s))[-1]
    assert known == 30
    v, left_s = 50 / 3.6, 2.0 - 1.2
    expected = 3.6 * np.sqrt(v**2 - 2 * 7 * v * left_s)
    assert time_left_of(result.x)["impact_kmh"].tolist() == pytest.approx([expected])


def test_a_recording_goes_by_its_own_speed_and_others_by_the_assumed_one():
    boxes = [box for r in range(2) for box in approach(range(40), CONTACT_S, recording=r)]
    dataset = make_dataset(boxes, places=[PLACE] * 2)
    own = dataset.recordings.assign(speed_kmh=[30.0, NAN])
    with_speed = type(dataset)(own, dataset.frames, dataset.boxes, dataset.systems, "f")
    result = compare(with_speed, Params(speed_kmh=80))
    assert time_left_in(result).urgency["speed_kmh"].tolist() == [30, 80]
    assert time_left_of(result.x)["impact_kmh"].tolist() == pytest.approx([30, 80])
    assert time_left_in(result).has_assumed_speed.tolist() == [False, True]


def test_sampled_frames_and_linked_tracks_are_unknown():
    sampled = Place(range(0, 400, 2))
    boxes = approach(range(0, 400, 2), 50.0)
    result = met(range(400), boxes=boxes, place=sampled)
    assert time_left_in(result).contact.is_sampled.tolist() == [True]
    linked = met(range(40), boxes=[b._replace(track=-1) for b in approach(range(40), CONTACT_S)])
    assert time_left_in(linked).contact.is_linked.tolist() == [True]
    for unknown in (result, linked):
        assert np.isnan(time_left_in(unknown).contact.ttc_s).all()
        assert time_left_in(unknown).urgency["urgency"].tolist() == ["unknown"]
        assert time_left_of(unknown.x)["time_left"].tolist() == [None]


def test_the_curve_at_the_assumed_speed_is_the_comparison():
    result = met(range(20), boxes=approach(range(30), CONTACT_S))
    curve = time_left_in(result).over_speed.set_index("speed_kmh")
    assert tuple(curve.index) == SPEEDS_KMH
    assert curve.loc[50.0, ["urgent", "in_time_x", "in_time_y"]].tolist() == [1, 1, 0]
    assert curve.loc[50.0, "mean_impact_kmh_y"] == pytest.approx(50)
    assert curve.loc[45.0, "urgent"] == 0  # 2.1 s are left at the end, and 1.99 s needed
    assert np.isnan(curve.loc[45.0, "mean_impact_kmh_x"])


def test_the_speed_from_which_on_the_other_system_is_ahead():
    curve = time_left_in(met()).over_speed
    zero = np.zeros(len(curve))
    x = np.where(curve["speed_kmh"] < 70, 0.5, np.where(curve["speed_kmh"] < 90, 0, -0.5))
    turned = curve.assign(share_in_time_x=x, share_in_time_y=zero)
    assert turning_speeds(turned, "share_in_time") == [90]
    assert turning_speeds(turned.assign(share_in_time_x=zero), "share_in_time") == []


def test_a_moved_speed_takes_over_the_matches_and_the_time_to_contact():
    first = met(range(20), range(30))
    moved = compare(first.dataset, Params(proximity="none", speed_kmh=90), previous=first)
    assert moved.x.matches is first.x.matches
    assert time_left_in(moved).contact is time_left_in(first).contact
    assert confirmed_by(moved.x) is confirmed_by(first.x)
    assert time_left_in(moved).urgency is not time_left_in(first).urgency
    brighter = compare(first.dataset, Params(proximity="none", alpha=0.5), previous=first)
    assert time_left_in(brighter).urgency is time_left_in(first).urgency
    assert time_left_of(brighter.x) is time_left_of(first.x)


@given(
    st.lists(
        st.tuples(st.floats(1.0, 8.0), st.floats(10, 90), st.sets(st.integers(0, 29))),
        min_size=1,
        max_size=4,
    ),
    st.floats(10, 130),
)
def test_classes_margins_and_speeds_belong_together(people, speed_kmh):
    truth: list[Box] = []
    x: list[Box] = []
    for track, (contact_s, centre, matched) in enumerate(people):
        frames = range(min(30, int(10 * contact_s)))
        boxes = approach(frames, contact_s + 0.01, centre=centre, track=track)
        truth += boxes
        x += only(boxes, matched)
    place = Place(range(30), width=100, height=20_000.0)
    dataset = make_dataset(sorted(truth), sorted(x), [], places=[place])
    result = result_of(dataset, speed_kmh=speed_kmh)
    judged, urgency = time_left_of(result.x), time_left_in(result).urgency
    is_urgent = time_left_in(result).is_urgent
    assert (judged["time_left"].notna() == is_urgent).all()
    assert (judged["impact_kmh"].notna() == is_urgent).all()
    assert (time_left_of(result.y)["time_left"][is_urgent] == "never").all()
    of_urgent = judged[is_urgent]
    in_time = of_urgent["time_left"] == "in_time"
    assert (of_urgent["margin_s"][in_time] > 0).all()
    assert (of_urgent["impact_kmh"][in_time] == 0).all()
    assert (of_urgent["margin_s"][of_urgent["time_left"] == "late"] <= 0).all()
    assert of_urgent["impact_kmh"].between(0, speed_kmh * (1 + 1e-9)).all()
    has_frame = (urgency["urgent_row"] >= 0).to_numpy()
    assert (urgency["urgency"].isin(["urgent", "no_chance", "outside"]) == has_frame).all()
    faster = (
        time_left_in(result_of(dataset, speed_kmh=speed_kmh + 10)).urgency["urgent_row"].to_numpy()
    )
    slower = urgency["urgent_row"].to_numpy()
    assert (faster[has_frame] <= slower[has_frame]).all()
    assert (faster[has_frame] >= 0).all()
