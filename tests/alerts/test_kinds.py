"""What alerts are worth, on drives small enough to count: one case for each kind."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from approach import ALL, PLACE, approach, only
from builders import NAN, Box, at, make_dataset, result_of

from nvcore.comparison.compare import Result, compare
from nvcore.notes import say
from nvcore.settings.objects import PEDESTRIAN, SPEED_SIGN
from nvcore.settings.params import Params
from nvcore.subjects.alerts.episodes import AlertKind
from nvcore.subjects.alerts.measures import MEASURES
from nvcore.subjects.alerts.notes import alert_notes
from nvcore.subjects.alerts.section import SECTIONS, render_alerts
from nvcore.subjects.alerts.steps import alerts_in

# The car reaches the pedestrian after 5 s; at 50 km/h the last chance is frame 29 (ten a second).
LAST_CHANCE = 29
AT_ONCE = {"alert_on_s": 0, "alert_off_s": 0, "alert_least_s": 0, "alert_pause_s": 0}
ANY_BOX = {"alerts": "policy", "alert_k": 0, "alert_corridor": 1, **AT_ONCE}


def judged(truth, x=(), y=(), **params) -> Result:
    """The comparison of four seconds in which every box alerts at once; nearness by height."""
    dataset = make_dataset(truth, x, y, places=[PLACE])
    return result_of(dataset, **{"proximity": "height", **ANY_BOX, **params})


def kinds(result: Result, letter: str = "x") -> list[str]:
    return alerts_in(result).of(result.system(letter))["kind"].tolist()


def repeats(result: Result) -> list[bool]:
    table = alerts_in(result).table
    return table["is_repeat"][table["system"] == "x"].tolist()


def measure(result: Result, key: str) -> list[float]:
    of = next(measure.of for measure in MEASURES if measure.key == key)
    return [of(result, system) for _, system in result.sides]


def met(frames, *, detectability=NAN, **params) -> Result:
    """An urgent pedestrian whom X detects in these frames; how detectable they are in frame 3."""
    boxes = approach(ALL, 5)
    truth = [box._replace(detectability=detectability if box.frame == 3 else NAN) for box in boxes]
    truth[0] = truth[0]._replace(detectability=0.0 if detectability == detectability else NAN)
    return judged(truth, only(boxes, frames), **params)


def far(frames, *, track: int = 5, h: float = 5.0, centre: float = 20.0) -> list[Box]:
    """Somebody who stands still; 5 px of 100 weigh 0.08, 50 px 1.0."""
    return [at(frame, centre, h=h, w=4.0, track=track) for frame in frames]


def test_an_alert_whose_boxes_match_nobody_is_false():
    result = judged(approach(ALL, 5), far([3, 4], track=9))
    assert kinds(result) == ["false"]
    assert alerts_in(result).of(result.x)["encounter"].tolist() == [-1]


def test_an_alert_about_what_the_truth_ignores_is_no_kind_of_error():
    ignored = [box._replace(ignore=True) for box in far([3, 4])]
    assert kinds(judged([*approach(ALL, 5), *ignored], far([3, 4]))) == ["ignored"]


@pytest.mark.parametrize(
    ("boxes", "params", "kind"),
    [
        (far(ALL), {}, "nuisance"),  # not urgent and far
        (far(ALL, h=50), {}, "wanted"),  # not urgent, near, in the corridor
        (far(ALL, h=50), {"corridor": 0.5}, "nuisance"),  # near, 30 of 50 px from the middle
        (far(ALL, h=50, centre=40), {"corridor": 0.5}, "wanted"),
    ],
)
def test_an_alert_about_who_is_not_urgent_is_a_nuisance_if_he_is_far_or_outside(
    boxes, params, kind
):
    assert kinds(judged(boxes, only(boxes, [7, 8]), **params)) == [kind]


def test_an_urgent_pedestrian_is_no_nuisance_however_far():
    # in frame 0 the pedestrian is 10 px tall: below the midpoint of 20 px
    assert kinds(met([0], midpoint=20.0, spread=2.0)) == ["wanted"]


def test_an_alert_is_redundant_if_the_driver_has_seen_before_needed_if_not():
    seen = {"detectability": 0.9, "midpoint": 20.0, "spread": 2.0}
    assert kinds(met([4, 5], **seen)) == ["redundant"]
    assert kinds(met([3, 4], **seen)) == ["needed"]  # the driver sees in that very frame
    assert kinds(met([4, 5], **{**seen, "detectability": 0.4})) == ["needed"]


def test_an_alert_is_wanted_where_nobody_knows_whether_the_driver_sees():
    result = met([4, 5])
    assert kinds(result) == ["wanted"]
    for key in ("alerts_redundant", "alerts_needed"):
        assert np.isnan(measure(result, key)).all()
    own = alerts_in(result).curve.set_index("of").loc["in use"].iloc[0]
    assert own[["redundant", "needed", "wanted"]].isna().tolist() == [True, True, False]
    known = met([4, 5], detectability=0.9)
    assert measure(known, "alerts_redundant") == [1, 0]
    assert measure(known, "alerts_needed") == [0, 0]


def test_whether_he_sees_must_be_known_before_the_alert_begins():
    # detectability is stated of frame 3 alone
    boxes = approach(ALL, 5)
    truth = [box._replace(detectability=0.1 if box.frame == 3 else NAN) for box in boxes]
    far_away = {"midpoint": 20.0, "spread": 2.0}
    assert kinds(judged(truth, only(boxes, [4, 5]), only(boxes, [3, 4]), **far_away)) == ["needed"]
    result = judged(truth, only(boxes, [3, 4]), **far_away)
    assert kinds(result) == ["wanted"]
    assert measure(result, "alerts_needed") == [0, 0]  # it is known of somebody


def test_an_alert_after_one_that_was_wanted_is_marked_as_a_repeat():
    boxes = [*approach(ALL, 5), *approach(ALL, 5, centre=80, track=2)]
    first, other = ([box for box in boxes if box.track == track] for track in (1, 2))
    # X tells of the first one in frames 4, 8 and 12 by one track and the next, of the other once
    x = [*only(first, [4, 8]), only(first, [12])[0]._replace(track=9), *only(other, [8])]
    result = judged(boxes, x)
    assert kinds(result) == ["wanted"] * 4
    assert repeats(result) == [False, True, False, True]
    assert measure(result, "alerted") == [2, 0]


def test_an_alert_after_a_nuisance_is_no_repeat():
    # 9 px weigh less than 0.5, 11 px more; the pedestrian stands still and is not urgent
    truth = [at(frame, 50, h=9.0 if frame < 10 else 11.0, w=4, track=1) for frame in ALL]
    result = judged(truth, only(truth, [2, 15, 30]))
    assert kinds(result) == ["nuisance", "wanted", "wanted"]
    assert repeats(result) == [False, False, True]


def test_the_first_box_that_matches_says_whom_an_alert_is_about():
    # box of frame 2 beside the pedestrian, as of a track about to take them: the alert is theirs
    boxes = approach(ALL, 5)
    early = boxes[2]._replace(x=boxes[2].x + 30)
    result = judged(boxes, [early, *only(boxes, [3, 4])])
    alerts = alerts_in(result).of(result.x)
    assert alerts[["first_row", "last_row", "encounter"]].to_numpy().tolist() == [[2, 4, 0]]


@pytest.mark.parametrize(
    ("frames", "kind"), [(range(1, 12), "nuisance"), ((1, 2), "wanted")], ids=["known", "unknown"]
)
def test_nearness_is_that_of_the_frame_in_which_the_alert_begins(frames, kind):
    # weight 0.5 from 10 px on: 9 px in frame 0, then 11 px, where a box matches; in three
    # frames it is not known whether they are urgent, and nothing is called a nuisance
    truth = [at(0, 50, h=9.0, w=4, track=1), *(at(f, 50, h=11.0, w=4, track=1) for f in frames)]
    missed = Box(0, 20, 10, 4, 9, track=1)
    assert kinds(judged(truth, [missed, *only(truth, [1, 2])])) == [kind]
    assert kinds(judged(truth, only(truth, [1, 2]))) == ["wanted"]


def test_an_alert_that_begins_where_he_is_still_ignored_is_about_him_once_he_is_annotated():
    boxes = approach(ALL, 5)
    truth = [box._replace(ignore=box.frame < 12) for box in boxes]
    result = judged(truth, only(boxes, range(8, 20)))
    alerts = alerts_in(result).of(result.x)
    assert alerts[["first_row", "encounter", "kind"]].to_numpy().tolist() == [[8, 0, "wanted"]]


def test_rates_are_of_an_hour_and_what_is_unwanted_is_false_nuisance_or_redundant():
    truth = [*approach(ALL, 5, centre=80), *far(ALL)]
    x = [*only(truth, [3, 4]), *far([20, 21, 23], track=9, centre=50)]
    result = judged(truth, x, truth)
    assert sorted(kinds(result)) == ["false", "false", "nuisance", "wanted"]
    assert sorted(kinds(result, "y")) == ["nuisance", "wanted"]
    per_alert = 3600 / 4  # four seconds
    assert measure(result, "alerts_unwanted_per_hour") == [3 * per_alert, per_alert]
    assert measure(result, "alerts_false") == [2, 0]
    assert measure(result, "alerts_wanted") == [1, 1]
    assert measure(result, "alerted") == [1, 1]  # the far one does not count
    counts = alerts_in(result).count(result.x)
    assert np.nansum([*counts.values()]) == len(kinds(result))
    assert set(counts) == set(AlertKind)


@pytest.mark.parametrize(
    ("frames", "lead_s"), [([9, 10], 2.0), ([28], 0.1), ([29], 0), ([31], -0.2)]
)
def test_the_lead_runs_to_the_last_chance_which_has_the_reaction_in_it(frames, lead_s):
    result = met(frames)
    assert alerts_in(result).lead_s(result.x) == pytest.approx([lead_s])
    assert measure(result, "alerted_in_time") == [lead_s > 0, 0]
    assert measure(result, "urgent_not_alerted") == [0, 1]
    later = met(frames, reaction_s=0.7)  # the last chance is frame 34
    assert alerts_in(later).lead_s(later.x) == pytest.approx([lead_s + 0.5])


def test_the_median_lead_is_of_those_whom_both_alert():
    boxes = [*approach(ALL, 5), *approach(ALL, 5, centre=80, track=2)]
    first = [box for box in boxes if box.track == 1]
    result = judged(boxes, only(boxes, [19]), only(first, [9]))
    assert measure(result, "median_alert_lead_s") == [1.0, 2.0]
    assert measure(met([9]), "median_alert_lead_s") == pytest.approx([NAN, NAN], nan_ok=True)


def test_the_oracle_holds_back_whom_the_driver_has_seen_but_no_false_alarm():
    truth = [*approach(ALL, 5, centre=80), *approach(ALL, 5, track=2)]
    truth = [box._replace(detectability=0.9 if box.track == 2 else 0.1) for box in truth]
    x = [*only(truth, [4, 5]), *far([4], track=9)]
    assert sorted(kinds(judged(truth, x))) == ["false", "needed", "redundant"]
    assert sorted(kinds(judged(truth, x, alert_oracle="on"))) == ["false", "needed"]


def test_the_oracle_leaves_those_whom_the_driver_sees_in_time_out_of_not_in_time():
    # three urgent ones; the driver sees the second from the first frame on; X alerts of all three
    truth = [box for track in (1, 2, 3) for box in approach(ALL, 5, centre=20 * track, track=track)]
    truth = [box._replace(detectability=0.9 if box.track == 2 else 0.1) for box in truth]
    anyway, held = (judged(truth, only(truth, [4, 5]), alert_oracle=on) for on in ("off", "on"))
    counts = ("alerted_in_time", "urgent_not_alerted")
    assert [measure(anyway, key) for key in counts] == [[3, 0], [0, 3]]
    assert [measure(held, key) for key in counts] == [[2, 0], [0, 2]]
    said = [say(fact, PEDESTRIAN) for fact in alert_notes(held)]
    assert said[0].endswith("in time for 2 of 2 urgent encounters.")
    assert "The driver sees 1 urgent encounter in time without an alert; this encounter" in said[-1]
    assert len(alerts_in(held).in_time_for_drivers.chances) == 2
    curve = alerts_in(held).curve
    assert curve[curve["of"] == "in use"]["share_in_time"].tolist() == [1, 0]


def test_nothing_is_said_of_urgency_where_no_car_could_hit_the_objects():
    boxes = approach(ALL, 5)
    dataset = make_dataset(boxes, only(boxes, [4]), places=[PLACE])
    dataset = dataset.with_settings(replace(dataset.settings, objects=SPEED_SIGN))
    result = compare(dataset, Params(**ANY_BOX))
    texts = [*(say(fact, SPEED_SIGN) for fact in alert_notes(result))]
    texts += [render_alerts(alerts_in(result)), str(SECTIONS[0].make(result))]
    for words in ("urgent encounter", "median lead", "driver had seen", "in time"):
        assert not [text for text in texts if words in text], words
    assert "X gives 1 alert (1 wanted)." in texts


def test_without_a_policy_there_are_no_alerts():
    result = met([4, 5], alerts="off")
    assert kinds(result) == []
    assert alerts_in(result).table.empty


def test_exchanged_systems_have_exchanged_alerts():
    truth = [*approach(ALL, 5, centre=80), *far(ALL)]
    dataset = make_dataset(truth, only(truth, [3, 4]), far([2, 9], track=9), places=[PLACE])
    params = Params(**ANY_BOX)
    result, other = compare(dataset, params), compare(dataset, params, x="y", y="x")
    for key in (measure.key for measure in MEASURES if measure.of is not None):
        assert measure(other, key) == pytest.approx(measure(result, key)[::-1], nan_ok=True)
    by = ["system", "of", "threshold"]
    curves = [
        alerts_in(of).curve.replace({"system": names}).sort_values(by, ignore_index=True)
        for of, names in ((result, {}), (other, {"x": "y", "y": "x"}))
    ]
    pd.testing.assert_frame_equal(*curves)


def test_the_mirrored_drive_has_the_same_alerts():
    truth = [*approach(ALL, 5, centre=80), *far(ALL)]
    x = [*only(truth, [3, 4]), *far([2, 9], track=9, centre=45)]

    def mirrored(boxes):
        return [box._replace(x=100 - box.x - box.w) for box in boxes]

    params = {"alert_corridor": 0.55, "corridor": 0.7}
    tables = [
        alerts_in(judged(*(turn(boxes) for boxes in (truth, x)), **params)).table
        for turn in (list, mirrored)
    ]
    assert len(tables[0])
    assert tables[0].equals(tables[1])


def test_a_point_of_the_curve_is_the_comparison_at_that_threshold():
    boxes = approach(ALL, 5)
    scored = [box._replace(score=0.01 * box.frame) for box in boxes]
    false = [box._replace(score=0.02 * (box.frame % 13)) for box in far(ALL, track=9, centre=30)]
    dataset = make_dataset(boxes, [*scored, *false], scored, places=[PLACE])
    params = Params(**{**ANY_BOX, "alert_on_s": 0.2, "alert_pause_s": 0.5})
    curve = alerts_in(compare(dataset, params)).curve
    own = curve[(curve["system"] == "x") & (curve["of"] == "policy")]
    assert own["threshold"].is_monotonic_increasing
    assert len(own) > 20
    for row in own.iloc[::5].to_dict("records"):
        at_threshold = compare(dataset, replace(params, threshold_x=max(row["threshold"], -1.0)))
        counts = alerts_in(at_threshold).count(at_threshold.x)
        assert [row[kind.value] for kind in AlertKind] == pytest.approx(
            [*counts.values()], nan_ok=True
        )
        assert row["in_time"] == measure(at_threshold, "alerted_in_time")[0]
        by_policy = compare(dataset, replace(params, alert_score=row["threshold"]))
        assert (
            alerts_in(by_policy).of(by_policy.x).equals(alerts_in(at_threshold).of(at_threshold.x))
        )
    in_use = curve[curve["of"] == "in use"].iloc[0]
    assert in_use.drop(["of"]).equals(own.iloc[0].drop(["of"]))
    assert np.isneginf(in_use["threshold"])
