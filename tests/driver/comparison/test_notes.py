"""The driver in words: terminal, verdict, HTML report, gate; and silence where nothing is known."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from approach import approach, only
from builders import NAN, Place, at, make_dataset, result_of

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.table import MEASURES
from nvcore.evidence.measures import significance_table
from nvcore.notes import Note, say
from nvcore.report.gate import run_gate
from nvcore.report.gate.measures import gate_measures, listed_names, measure_names
from nvcore.report.gate.rules import parse_rule
from nvcore.report.terminal import render_scorecard
from nvcore.report.tiles import tiles
from nvcore.report.verdict import verdict
from nvcore.settings.objects import objects_from
from nvcore.settings.params import Params
from nvcore.subjects.driver.comparison.encounters import (
    detectability_course,
    driver_venn_table,
    features_of_course,
    saved_encounters,
)
from nvcore.subjects.driver.comparison.judging import DRIVER_REGION_TEXT, DriverRegion
from nvcore.subjects.driver.comparison.notes import (
    driver_notes,
    no_claim,
    seen_unaided,
    source,
    weighting,
    weighting_notes,
)
from nvcore.subjects.driver.comparison.report import driver_section
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.driver.inputs.record import EstimateRecord
from nvcore.tables.result import encounters_table, recordings_table
from nvcore.tables.scorecard import score_rows
from nvcore.tables.summary import summary

WHETHER = "whether the driver sees the pedestrian"


def eight(n_recordings: int = 1, *, unknown: int = 1, **params: str) -> Result:
    """An encounter of each region of driver, X and Y in each recording, and unknown ones."""
    truth, x, y = [], [], []
    for recording in range(n_recordings):
        for number, (driver, by_x, by_y) in enumerate(product([True, False], repeat=3)):
            person = at(0, 10 + 10 * number, track=number + 1, recording=recording)
            truth.append(person._replace(detectability=0.9 if driver else 0.1))
            x += [person._replace(score=1.0)] if by_x else []
            y += [person._replace(score=1.0)] if by_y else []
        truth += [at(0, 95, track=9 + i, recording=recording) for i in range(unknown)]
    return result_of(make_dataset(truth, x, y, places=[Place(range(3))] * n_recordings), **params)


def with_estimate(result: Result, record: EstimateRecord) -> Result:
    return replace(result, dataset=replace(result.dataset, of_subjects={"driver": record}))


def test_the_alerts_of_each_system_are_counted_in_the_scorecard():
    rows = {row.key: (row.x, row.y) for row in score_rows(eight())}
    assert rows["useful_alerts"] == (2, 2)
    assert rows["unprotected"] == (2, 2)
    assert rows["redundant_alerts"] == (2, 2)


def test_alerts_are_counted_by_recording():
    table = recordings_table(eight(3))
    assert table["useful_alerts_x"].tolist() == [2, 2, 2]
    assert table["redundant_alerts_y"].tolist() == [2, 2, 2]


def test_of_recordings_of_which_nothing_is_known_the_alerts_are_undefined():
    counts = ["useful_alerts_x", "unprotected_y", "redundant_alerts_x", "in_time_alone_y"]
    table = recordings_table(urgent())
    assert table["driver_known"].tolist() == [1, 1, 1, 0]
    assert table[counts].isna().to_numpy().tolist() == [[False] * 4] * 3 + [[True] * 4]
    assert table["unprotected_x"].tolist()[:3] == [1, 1, 0]
    nobody_urgent = recordings_table(eight(2))
    assert nobody_urgent["driver_known"].tolist() == [8, 8]
    assert nobody_urgent[counts].isna().any().tolist() == [False] * 3 + [True]
    bare = recordings_table(result_of(make_dataset([at(0, 50, track=1)])))
    assert "driver_known" not in bare
    assert "useful_alerts_x" not in bare


def only_of(key: str, notes: Iterable[Note]) -> Note:
    """The only note of a key."""
    (note,) = (note for note in notes if note.key == key)
    return note


def keys_of(notes: Iterable[Note]) -> list[str]:
    return [note.key for note in notes]


def words_of(result: Result, notes: Iterable[Note]) -> str:
    return " ".join(say(note, result.objects) for note in notes)


def test_what_is_known_of_the_driver_in_words():
    """The golden text, of the ground truth's own values and of estimates."""
    result = eight()
    assert words_of(result, driver_notes(result)) == (
        "By the ground truth, the driver sees 4 of 8 encounters unaided. Of the 4 not seen, X "
        "detects 2 and Y 2 (X alone 1, Y alone 1, neither 1). Detectability is given by the ground "
        "truth. Seen means that at least 50 % of drivers would see the pedestrian. Detectability "
        "is known for 8 of 9 pedestrian boxes; 1 encounter with unknown detectability is not "
        "counted here."
    )
    assert words_of(result, driver_notes(result)) == dict(verdict(result).topics)["The driver"]
    simulated = with_estimate(eight(unknown=0), EstimateRecord("m", "ab12", "all", 12))
    assert words_of(simulated, driver_notes(simulated)) == (
        "Nothing is claimed about whom the driver sees: the estimator learnt from simulated "
        "subjects only, not from people. By the estimates (learnt from simulated subjects), the "
        "driver "
        "sees 4 of 8 encounters unaided. Of the 4 not seen, X detects 2 and Y 2 (X alone 1, Y "
        "alone 1, neither 1). Detectability is estimated by the estimator m (12 subjects, "
        "fingerprint ab12), learnt from simulated subjects. Seen means that at least 50 % of "
        "drivers would see the pedestrian."
    )


def test_estimates_of_simulated_subjects_alone_are_no_ground_for_a_claim():
    result = with_estimate(eight(unknown=0), EstimateRecord("m", "ab12", "all", 12))
    assert no_claim(result) == (Note("driver.no_claim", why=Note("driver.simulated_subjects")),)
    assert not no_claim(with_estimate(result, EstimateRecord("m", "ab12", "some", 12)))
    plain = with_estimate(eight(unknown=0), EstimateRecord())
    assert words_of(plain, source(plain)).startswith("Detectability is estimated. Seen means")


def test_what_is_estimated_and_what_the_truth_states_are_told_apart():
    result = eight(unknown=0)
    (name,) = result.dataset.recordings["name"]
    own, other = frozenset([name]), frozenset(["elsewhere"])
    record = EstimateRecord("m", "", "some", 12)
    both = with_estimate(result, replace(record, estimated_in=own, stated_in=own))
    stated = with_estimate(result, replace(record, estimated_in=other, stated_in=own))
    estimated = with_estimate(result, replace(record, estimated_in=own, stated_in=other))
    for each, kind in ((both, "both"), (stated, "truth"), (estimated, "estimates")):
        assert seen_unaided(each)["by"]["origin"] == source(each)[0]["origin"] == kind
    by = seen_unaided(both)["by"]
    assert (by["n_estimated"], by["n_stated"]) == (1, 1)
    assert "caution" in seen_unaided(estimated)["by"].fields
    assert "caution" not in seen_unaided(stated)["by"].fields


def test_the_section_has_the_regions_and_the_unknown_only_where_there_are_some():
    for unknown, n in ((1, 9), (0, 8)):
        result = eight(unknown=unknown)
        regions = driver_section(result).blocks[1]
        assert [row[1] for row in regions.rows] == ["1"] * n
        assert f"\n  {regions.title}:\n" in render_scorecard(result)


def test_where_nothing_is_known_nothing_is_said():
    result = result_of(make_dataset([at(0, 50, track=1)]))
    assert driver_notes(result) == ()
    assert "driver" not in render_scorecard(result)
    assert "driver" not in str(summary(result))
    assert not any("driver" in name for name in encounters_table(result))
    assert "detectability" not in encounters_table(result)
    assert "useful_alerts" not in significance_table(result)["figure"].tolist()


def test_weighting_is_said_and_of_how_many_boxes_it_is_not():
    assert weighting(eight()) == ()
    weighted = eight(driver_weighting="on")
    assert weighting(weighted) == (Note("driver.weighting", n_unknown=1),)
    assert weighting(eight(unknown=0, driver_weighting="on")) == (
        Note("driver.weighting", n_unknown=0),
    )
    assert "weighted by (1 - detectability)" in render_scorecard(weighted)
    (point,) = [point for point in verdict(weighted).points if point.topic == "Weighting"]
    assert (point.notes, point.is_warning) == (weighting(weighted), True)
    simulated = with_estimate(weighted, EstimateRecord("m", "", "all", 3))
    why = Note("driver.simulated_subjects")
    assert weighting_notes(simulated)[1] == Note("driver.no_claim_of_weighted", why=why)
    bare = result_of(make_dataset([at(0, 50, track=1)]), driver_weighting="on")
    assert weighting(bare) == (Note("driver.no_weighting"),)


def test_the_table_of_regions_has_a_row_for_each_with_words():
    table = driver_venn_table(eight()).set_index("region")
    assert table["encounters"].tolist() == [1] * 9
    assert table.loc[DriverRegion.Y, "meaning"] == (
        "Neither the driver nor X, but Y: only Y can warn."
    )
    # Y alone stands at 70 of 100 px, k = 1, for 0.1 s
    assert table.loc[DriverRegion.Y, "severity_x"] == pytest.approx(0.1 * 30 / 50)
    assert table.loc[DriverRegion.Y, "severity_y"] == 0


def urgent(**params: float) -> Result:
    """Four who are driven up to: seen by nobody, by Y alone, by the driver too, one unknown."""
    late, all_ = range(30, 40), range(40)
    truth, x, y = [], [], []
    for recording, (seen, by_y) in enumerate([(0.1, late), (0.1, all_), (0.9, all_), (NAN, all_)]):
        boxes = approach(range(40), 5, recording=recording)
        truth += [b._replace(detectability=seen) for b in boxes]
        x += only(boxes, late)
        y += only(boxes, by_y)
    dataset = make_dataset(truth, x, y, places=[Place(range(40))] * 4)
    return result_of(dataset, proximity="height", **params)


def test_neither_the_driver_nor_x_but_y_is_counted_listed_and_said():
    result = urgent()
    rows = {row.key: (row.x, row.y) for row in score_rows(result)}
    assert rows["in_time_alone"] == (0, 1)
    saved = saved_encounters(result)
    assert saved[["recording", "system", "impact_kmh_y"]].to_numpy().tolist() == [["r1", "y", 0.0]]
    in_time = Note("driver.in_time", n=3, driver=1, both=0, x=0, y=1, nobody=1)
    assert in_time in driver_notes(result)
    assert encounters_table(result)["driver_in_time"].tolist()[:3] == [False, False, True]
    assert encounters_table(result)["driver_in_time"].isna().tolist() == [False] * 3 + [True]


def test_the_section_of_the_report_lists_regions_and_the_saved():
    section = driver_section(urgent())
    _, regions, saved = section.blocks
    assert len(regions.rows) == 9
    assert saved.rows[0][:3] == ("r1", "1", "Y")
    assert len(driver_section(eight(unknown=0)).blocks) == 2


def test_the_course_of_an_encounter_is_given_from_frame_to_frame():
    truth = [
        at(f, 50, h=h, track=1, detectability=d)
        for f, (h, d) in enumerate([(4, 0.1), (4, NAN), (40, 0.3), (40, 0.8)])
    ]
    course = detectability_course(result_of(make_dataset(truth), proximity="height"), 0)
    assert course["detectability"].tolist() == pytest.approx([0.1, NAN, 0.3, 0.8], nan_ok=True)
    assert course["is_up_to_relevant"].tolist() == [True, True, True, False]


def test_features_are_those_of_the_frames_of_the_course():
    truth = [
        box
        for f in range(3)
        for box in (
            at(f, 20, track=1, ignore=True),
            at(f, 50, track=2, detectability=0.3),
            at(f, 80, track=3, detectability=0.4),
        )
    ]
    result = result_of(make_dataset(truth))
    course = detectability_course(result, result.encounters.track.tolist().index(2))
    boxes = result.dataset.boxes.iloc[: len(truth)]
    people = boxes[~boxes["ignore"]].reset_index(drop=True)
    features = people[["x", "y", "w", "h"]].assign(
        frame=people["frame_index"], width_px=np.arange(6.0)
    )
    own = features_of_course(result, course, features)
    assert own["width_px"].tolist() == (
        [0.0, 2.0, 4.0] if course["truth_row"][0] == 1 else [1, 3, 5]
    )
    assert features_of_course(result, course, features.iloc[1:]) is None
    assert features_of_course(result, course, features.assign(x=-5.0)) is None


def test_features_are_found_in_a_later_recording_with_gaps_between_its_frames():
    frames = [600, 603, 604, 610]
    truth = [
        box
        for f in frames
        for box in (
            at(f, 20, track=1, ignore=True, recording=1),
            at(f, 80, track=3, detectability=0.4, recording=1),
        )
    ]
    earlier = [at(f, 50, track=2, detectability=0.3) for f in range(3)]
    result = result_of(
        make_dataset([*earlier, *truth], places=[Place(range(3)), Place(frames, fps=20.0)])
    )
    course = detectability_course(result, result.encounters.track.tolist().index(3))
    assert course["row"].tolist() == [3, 4, 5, 6]
    assert course["time_s"].tolist() == pytest.approx([0, 0.15, 0.2, 0.5])
    boxes = result.dataset.boxes.iloc[3 : 3 + len(truth)]
    features = boxes.loc[~boxes["ignore"], ["x", "y", "w", "h"]].assign(
        frame=frames, width_px=np.arange(4.0)
    )
    own = features_of_course(result, course, features)
    assert own["width_px"].tolist() == [0, 1, 2, 3]
    assert own["frame"].tolist() == frames
    late = features.assign(frame=np.array(frames) + 1)
    assert features_of_course(result, course, late) is None


def test_a_rule_of_the_gate_is_judged_and_undefined_where_nothing_is_known():
    rules = [parse_rule("unprotected_y <= 2"), parse_rule("driver_venn.nobody == 1")]
    outcomes, _ = run_gate(rules, eight(), (), strict=False)
    assert [outcome.is_passed for outcome in outcomes[:2]] == [True, True]
    known = f"By the ground truth, it is known for 8 of 9 encounters {WHETHER}"
    assert [outcome.details for outcome in outcomes] == [(known,), (known,), ()]
    (failed, *_), _ = run_gate([parse_rule("unprotected_y == 0")], eight(), (), strict=False)
    assert failed.details == (known, "r0, track 6, frame 0", "r0, track 8, frame 0")
    (failed, *_), _ = run_gate([parse_rule("driver_venn.y == 0")], eight(), (), strict=False)
    assert failed.details == (known, "r0, track 7, frame 0")
    bare = result_of(make_dataset([at(0, 50, track=1)]))
    outcomes, measures = run_gate(rules, bare, (), strict=False)
    assert [outcome.is_passed for outcome in outcomes[:2]] == [False, False]
    assert [outcome.details for outcome in outcomes] == [()] * 3
    assert math.isnan(measures["unprotected_y"])
    assert math.isnan(measures["driver_venn.nobody"])


def test_below_a_rule_on_urgent_encounters_the_gate_says_of_how_many_of_these_it_is_known():
    ends = ["_x", "_y", "_difference"]
    names = [*(f"in_time_alone{end}" for end in ends), "fusion.x_or_y.in_time_alone"]
    names += ["driver.urgent", "driver.in_time", "unprotected_x"]
    rules = [parse_rule(f"{name} >= -9") for name in names]
    outcomes, _ = run_gate(rules, urgent(), (), strict=False)
    known = [outcome.details[0].partition(" whether")[0] for outcome in outcomes[:7]]
    head = "By the ground truth, it is known for 3 of 4"
    assert known == [f"{head} urgent encounters"] * 6 + [f"{head} encounters"]


def test_the_gate_says_that_what_is_known_of_the_driver_was_learnt_from_simulated_subjects():
    result = with_estimate(eight(), EstimateRecord("m", "ab12", "all", 12))
    names = ["driver_venn.unknown", "useful_alerts_worse_x", "fusion.x_or_y.useful_alerts"]
    rules = [parse_rule(f"{name} < 1 or undefined") for name in (*names, "encounters")]
    outcomes, _ = run_gate(rules, result, (), strict=False)
    known = (
        "By the estimates (learnt from simulated subjects), it is known for 8 of 9 encounters "
        f"{WHETHER}"
    )
    assert [outcome.details[:1] == (known,) for outcome in outcomes] == [*[True] * 3, False, False]


def test_every_name_of_a_rule_has_a_value_with_and_without_a_driver():
    for result in (eight(alerts="policy"), result_of(make_dataset([at(0, 50, track=1)]))):
        measures = gate_measures(result, (), result.dataset.settings.protocol, measure_names())
        assert set(measure_names()) <= set(measures)
        listed = listed_names(result, measures)
        assert (listed == sorted(measures)) is driver_in(result).has_any
        assert ("useful_alerts_worse_y" in listed) is driver_in(result).has_any


def test_useful_alerts_are_tested_by_mcnemar_and_by_recordings():
    table = significance_table(eight(8)).set_index("figure")
    row = table.loc["useful_alerts"]
    assert (row["x"], row["y"], row["n"]) == (0.5, 0.5, 32)
    by_unit = table.loc["useful_alerts_by_unit"]
    assert (by_unit["x"], by_unit["n"], by_unit["unit"]) == (0.5, 8, "recordings")


def test_a_share_of_estimates_that_say_little_is_said_with_the_features():
    result = eight(unknown=0)
    boxes = result.dataset.boxes
    n = int(boxes["detectability"].notna().sum())
    counts = {"Height": 5, "Edge contrast": 3, "Width": 2, "Lab distance": 1, "Luma": 1}
    record = EstimateRecord("m", n_estimates=100, n_light_unknown=6, outside=counts)

    def basis(record: EstimateRecord, n_outside: int) -> tuple[Note, ...]:
        marked = boxes.assign(is_outside=np.arange(len(boxes)) < n_outside)
        dataset = replace(result.dataset, boxes=marked)
        return driver_notes(with_estimate(compare(dataset, Params(proximity="none")), record))

    outside = {"n": 1, "n_known": n, "n_deciding": 1, "n_encounters": 8}
    named = "Height, Edge contrast, Width and 2 more"
    assert Note("driver.outside", **outside, features=named) in basis(record, 1)
    assert Note("driver.light_unknown", share=0.06) in basis(record, 1)
    (name,) = result.dataset.recordings["name"]
    stated = basis(replace(record, stated_in=frozenset([name])), 1)
    assert "driver.light_unknown" not in keys_of(stated)
    few = basis(replace(record, n_light_unknown=5), 0)
    assert not {"driver.light_unknown", "driver.outside"} & {*keys_of(few)}
    assert Note("driver.outside", **outside) in basis(replace(record, outside={}), 1)


def test_where_boxes_are_outside_the_training_but_no_encounter_is_that_is_said():
    places = {0: 0.4, 1: 0.2}  # the first decides, the second is outside the range
    truth = [at(f, 50, track=1, detectability=value) for f, value in places.items()]
    result = result_of(make_dataset(truth))
    boxes = result.dataset.boxes
    outside = boxes.assign(is_outside=(boxes["detectability"] == 0.2).to_numpy())
    notes = driver_notes(compare(replace(result.dataset, boxes=outside), result.params))
    assert Note("driver.outside", n=1, n_known=2, n_deciding=0, n_encounters=1) in notes


def test_encounters_whose_largest_value_is_within_its_sd_of_the_threshold_are_open():
    shares = (0.5, 0.55, 0.45, 0.8, 0.2)
    truth = [at(0, 50, track=i, detectability=share) for i, share in enumerate(shares)]
    bare = result_of(make_dataset(truth))
    assert "driver.open" not in keys_of(driver_notes(bare))
    boxes = bare.dataset.boxes.assign(detectability_sd=0.1)
    result = compare(replace(bare.dataset, boxes=boxes), bare.params)
    of = {"n": 3, "n_known": 5, "is_least": False, "n_open_unseen": 1, "n_unseen": 2}
    assert Note("driver.open", **of, threshold=0.5) in driver_notes(result)
    assert encounters_table(result)["within_sd"].tolist() == [1, 1, 1, 0, 0]
    assert summary(result)["driver"]["within_sd"] == 3


def test_where_every_encounter_is_open_nothing_is_claimed_of_the_driver():
    truth = [at(0, 50, track=i, detectability=0.55) for i in range(2)]
    bare = result_of(make_dataset(truth))
    assert not no_claim(bare)
    boxes = bare.dataset.boxes.assign(detectability_sd=[0.1, 0.1])
    result = compare(replace(bare.dataset, boxes=boxes), bare.params)
    why = Note("driver.all_open", n=2, is_of_unseen=False, threshold=0.5)
    assert no_claim(result) == (Note("driver.no_claim", why=why),)
    assert not seen_unaided(result)["is_redundant"]
    assert "driver.open" not in keys_of(driver_notes(result))  # said before
    one_known = compare(replace(bare.dataset, boxes=boxes.assign(detectability_sd=[0.1, 0.01])))
    assert not no_claim(one_known)


def test_of_an_estimator_that_learned_nothing_nothing_is_claimed():
    result = with_estimate(eight(unknown=0), EstimateRecord("m", "", "no", 3, of_no_use=True))
    assert no_claim(result) == (Note("driver.no_claim", why=Note("driver.useless")),)
    assert "caution" in seen_unaided(result)["by"].fields
    seen = make_dataset([at(0, 50, track=1, detectability=0.9)])
    useless = with_estimate(result_of(seen), result.dataset.of("driver"))
    assert not seen_unaided(useless)["is_redundant"]
    assert seen_unaided(useless)["n_seen"] == 1
    (name,) = result.dataset.recordings["name"]
    stated = EstimateRecord("m", of_no_use=True, stated_in=frozenset([name]))
    assert not no_claim(with_estimate(result, stated))


def test_where_half_is_decided_outside_of_the_training_nothing_is_claimed_nor_passed():
    bare = eight(unknown=0)

    def decided(n_outside: int) -> Result:
        is_outside = np.arange(len(bare.dataset.boxes)) < n_outside
        boxes = bare.dataset.boxes.assign(is_outside=is_outside)
        result = compare(replace(bare.dataset, boxes=boxes), bare.params)
        return with_estimate(result, EstimateRecord("m", "", "no", 12))

    few, many = decided(3), decided(4)
    assert not no_claim(few)
    why = Note("driver.out_of_range", n=4, n_known=8)
    assert no_claim(many) == (Note("driver.no_claim", why=why),)
    rules = [parse_rule("unprotected_x <= 9"), parse_rule("driver_venn.unknown <= 9")]
    passed = [
        [outcome.is_passed for outcome in run_gate(rules, result, (), strict=False)[0][:2]]
        for result in (few, many)
    ]
    assert passed == [[True, True], [False, True]]
    better = {
        result: {row.key: row._replace(x=1, y=2).winner for row in score_rows(result)}
        for result in (few, many)
    }
    assert better[few]["useful_alerts"] == "y"
    assert better[many]["useful_alerts"] == ""
    assert better[many]["mean_similarity"] == "y"


def test_of_what_is_weighted_by_simulated_subjects_no_value_is_the_better_one():
    plain, result = eight(unknown=0), eight(unknown=0, driver_weighting="on")
    rows = zip(score_rows(plain), score_rows(result), strict=True)
    moved = {
        row.key
        for row, other in rows
        if not np.array_equal((row.x, row.y), (other.x, other.y), equal_nan=True)
    }
    weighted = {measure.key for measure in MEASURES if measure.depends_on("driver_weighting")}
    assert {"mean_similarity", "severity_s_per_encounter"} <= moved <= weighted
    simulated = with_estimate(result, EstimateRecord("m", "", "all", 3))
    marked = {row.key for row in score_rows(simulated) if row._replace(x=1, y=2).winner}
    assert marked.isdisjoint(weighted | {"useful_alerts", "unprotected"})
    assert "encounters_detected" in marked
    worst = {tile.key: tile.better for tile in tiles(simulated, None, None)}
    assert worst["worst_severity_s"] == ""


def test_whom_the_driver_sees_for_a_few_frames_only_is_counted():
    far = [at(f, 50, h=4, track=1, detectability=0.1 + 0.5 * (f == 3)) for f in range(6)]
    truth = [*far, at(6, 50, h=40, track=1, detectability=0.2), at(6, 20, detectability=0.9)]
    result = result_of(make_dataset(truth), proximity="height")
    assert Note("driver.seldom", n=1, n_seen=2, share=0.5) in driver_notes(result)
    assert summary(result)["driver"]["seldom"] == 1
    often = result_of(make_dataset([b._replace(detectability=0.9) for b in truth]))
    assert "driver.seldom" not in keys_of(driver_notes(often))


def test_who_is_seen_too_late_to_stop_is_said_and_no_alert_about_him_is_called_redundant():
    # urgent from frame 29 on; near enough to count only when h is 30 px, in frame 34
    truth = [b._replace(detectability=float(b.frame >= 33)) for b in approach(range(40), 5)]
    sides = approach(range(40), 5), only(approach(range(40), 5), range(36, 40))
    result = result_of(make_dataset(truth, *sides), proximity="height", midpoint=30.0)
    notes = driver_notes(result)
    assert not only_of("driver.seen_unaided", notes)["is_redundant"]
    assert Note("driver.in_time", n=1, driver=0, both=0, x=1, y=0, nobody=0) in notes
    assert Note("driver.too_late", n=1) in notes
    assert summary(result)["driver"]["too_late"] == 1


def test_of_a_pedestrian_who_is_not_seen_any_estimate_outside_the_training_decides():
    truth = [at(f, 50, h=4 + 36 * f, track=1, detectability=(0.1, 0.3)[f]) for f in range(2)]
    bare = result_of(make_dataset(truth), proximity="height")
    boxes = bare.dataset.boxes.assign(is_outside=[True, False])
    for threshold, n in ((0.5, 1), (0.2, 0)):
        result = compare(replace(bare.dataset, boxes=boxes), bare.params)
        result = compare(result.dataset, replace(bare.params, driver_threshold=threshold))
        of_all = only_of("driver.outside", driver_notes(result))
        assert (of_all["n_deciding"], of_all["n_encounters"]) == (n, 1)
        assert encounters_table(result)["outside_training"].tolist() == [n]


def test_how_many_encounters_estimates_for_adapted_eyes_decide_is_said():
    bare = with_estimate(eight(unknown=0), EstimateRecord("m"))
    boxes = bare.dataset.boxes
    marked = boxes.assign(is_adapted=(boxes["detectability"] == 0.1).to_numpy())
    result = compare(replace(bare.dataset, boxes=marked), bare.params)
    assert Note("driver.adapted", n=4, n_known=8) in driver_notes(result)
    assert encounters_table(result)["adapted_eyes"].tolist() == [0] * 4 + [1] * 4
    assert summary(result)["driver"]["adapted"] == 4
    assert "driver.adapted" not in keys_of(driver_notes(bare))


def test_rules_are_undefined_by_an_estimator_that_learned_nothing_but_for_those_on_what_is_known():
    result = with_estimate(eight(8), EstimateRecord("m", of_no_use=True))
    names = ["unprotected_x", "driver_venn.nobody", "driver_venn.unknown", "encounters"]

    def undefined(result: Result) -> list[bool]:
        values = gate_measures(result, (), result.dataset.settings.protocol, names)
        return [math.isnan(values[name]) for name in names]

    assert undefined(eight(8)) == [False] * 4
    assert undefined(result) == [True, True, False, False]


@pytest.mark.parametrize(
    "record", [EstimateRecord("m", of_no_use=True), EstimateRecord("m", simulated="all")]
)
def test_no_rule_rests_on_alerts_or_severities_by_a_driver_of_whom_nothing_is_claimed(record):
    names = ["alerts_redundant_x", "alerts_needed_y", "alerts_unwanted_x", "alerts_false_x"]
    names += ["fusion.x_or_y.alerts_redundant", "severity_s_x"]
    rules = [parse_rule(f"{name} >= 0") for name in names]
    of = {"alerts": "policy", "driver_weighting": "on"}
    stated, estimated = eight(8, **of), with_estimate(eight(8, **of), record)
    for result, passes in ((stated, [True] * 6), (estimated, [False] * 3 + [True] + [False] * 2)):
        outcomes, _ = run_gate(rules, result, (), strict=False)
        assert [outcome.is_passed for outcome in outcomes[:6]] == passes
    assert outcomes[0].details[1].startswith("Nothing is claimed about whom the driver sees: ")
    assert outcomes[5].details[0].startswith("Nothing is claimed about weighted measures: ")
    rows = {row.key: row for row in score_rows(estimated)}
    assert rows["alerts_redundant"].is_doubtful
    assert rows["severity_s"].is_doubtful


def test_where_nobody_is_urgent_it_is_undefined_who_is_in_time_or_too_late():
    of_driver = summary(eight())["driver"]
    assert (of_driver["in_time"], of_driver["too_late"]) == (None, None)
    assert (summary(urgent())["driver"]["in_time"], summary(urgent())["driver"]["too_late"]) == (
        1,
        0,
    )


def test_below_a_rule_of_the_gate_stands_why_nothing_is_claimed_and_what_is_open():
    bare = eight(unknown=0)
    rules = [parse_rule("unprotected_x <= 9")]

    def details(sd: float) -> tuple[str, ...]:
        boxes = bare.dataset.boxes.assign(detectability_sd=sd)
        (outcome, *_), _ = run_gate(
            rules, compare(replace(bare.dataset, boxes=boxes), bare.params), (), strict=False
        )
        return outcome.details

    head = f"By the ground truth, it is known for 8 of 8 encounters {WHETHER}"
    assert details(0.1) == (head,)
    known, doubt, *_ = details(0.4)
    assert (
        known == f"{head}; it is open in 8 of the 8, within one standard deviation of the threshold"
    )
    assert doubt.startswith("Nothing is claimed about whom the driver sees: in all 8 encounters")


def test_the_driver_stays_a_person_where_the_objects_are_others():
    met = urgent()
    settings = replace(met.dataset.settings, objects=objects_from("cyclist"))
    result = compare(replace(met.dataset, settings=settings), met.params)
    regions = map(result.objects.say, DRIVER_REGION_TEXT.values())
    text = " ".join([words_of(result, driver_notes(result)), *regions])
    assert not re.search(r"\b(it needs|warn it|its confirmation|nothing|it is taken)\b", text)
    assert "at least 50 % of drivers would see the cyclist" in text
    assert "and neither in 1" in text


def test_without_a_standard_deviation_it_is_not_known_who_is_near_the_threshold():
    truth = [at(0, 50, track=i, detectability=0.5) for i in range(2)]
    bare = result_of(make_dataset(truth))
    assert encounters_table(bare)["within_sd"].isna().all()
    assert summary(bare)["driver"]["within_sd"] is None
    boxes = bare.dataset.boxes.assign(detectability_sd=[0.1, np.nan])
    result = compare(replace(bare.dataset, boxes=boxes), bare.params)
    assert encounters_table(result)["within_sd"].isna().tolist() == [False, True]
    assert only_of("driver.open", driver_notes(result))["is_least"]


def test_detectability_of_none_of_the_frames_that_decide_is_said():
    near = [at(f, 50, track=1, detectability=value) for f, value in ((0, NAN), (1, 0.9))]
    result = result_of(make_dataset(near))
    assert not driver_in(result).has_any
    assert driver_notes(result) == (Note("driver.nothing_known"),)


def test_if_he_sees_everybody_shares_of_the_others_are_undefined_not_an_error():
    truth = [at(0, 50, track=1, detectability=1.0)]
    result = result_of(make_dataset(truth, [at(0, 50, score=1.0)]))
    assert seen_unaided(result)["is_redundant"]
    table = significance_table(result).set_index("figure")
    assert np.isnan(table.loc["useful_alerts", "x"])


def test_estimates_outside_the_training_are_counted():
    result = eight(unknown=0)
    boxes = result.dataset.boxes.assign(is_outside=np.arange(len(result.dataset.boxes)) < 3)
    outside = compare(replace(result.dataset, boxes=boxes), Params(proximity="none"))
    of_all = only_of("driver.outside", driver_notes(outside))
    assert (of_all["n_deciding"], of_all["n_encounters"]) == (3, 8)
    assert encounters_table(outside)["outside_training"].sum() == 3
