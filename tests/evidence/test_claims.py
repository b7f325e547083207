"""What a comparison may claim: by recordings, at equal false alarms, paired strictly."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from builders import NAN, Box, Place, at, make_dataset, result_of
from drives import detector, turned_by_strict_pairing

from nvcore.comparison.compare import Result, compare
from nvcore.dataset import Dataset
from nvcore.evidence.claims import Basis, Support, find_claims, values_of
from nvcore.evidence.companions import UNSURE, find_companions, least_of, shifts_at_equal_alarms
from nvcore.evidence.measures import significance_table
from nvcore.evidence.operating_points import (
    are_unequal,
    at_operating_point,
    can_be_equal,
    count_alarms,
    equal_setting,
    find_equal_alarms,
    which_moves,
)
from nvcore.evidence.pairwise import CLAIMED, pairwise_table
from nvcore.evidence.pairwise import _claims as claims_of_pair
from nvcore.evidence.subgroups.table import subgroup_table
from nvcore.evidence.table import evidence_table, judge_both
from nvcore.evidence.units import find_units
from nvcore.notes import Note
from nvcore.report.gate.measures import gate_measures
from nvcore.report.verdict import verdict
from nvcore.settings.params import Params
from nvcore.settings.protocols import PROTOCOLS
from nvcore.subjects.driver.inputs.record import EstimateRecord


def scene(x: list[Box], y: list[Box], n: int = 12, **params: float) -> Result:
    truth = [
        at(frame, centre, track=centre, recording=number)
        for number in range(n)
        for frame in range(20)
        for centre in (20, 40, 60, 80)
    ]
    return result_of(make_dataset(truth, x, y, places=[Place(range(20))] * n), **params)


def support_of(result: Result) -> Support:
    evidence = evidence_table(result, has_intervals=False)
    return find_claims(result, evidence, find_companions(result, evidence))


@pytest.mark.parametrize("cut", [0.05, 0.2, 0.5])
@pytest.mark.parametrize("has_scores", [True, False])
def test_one_detector_at_two_thresholds_is_no_two_systems(cut: float, has_scores: bool):
    whole, strict = (detector(1, cut=at_least, has_scores=has_scores) for at_least in (0.0, cut))
    result = scene(whole, strict)
    by_unit = significance_table(result).set_index("figure")["p_corrected"]
    assert by_unit["mean_similarity"] <= 0.05  # as set it would be a difference
    assert not support_of(result).claims


@pytest.mark.parametrize("cut", [0.05, 0.2, 0.5])
def test_one_detector_with_two_thresholds_of_its_scores_is_no_two_systems(cut: float):
    boxes = detector(1)
    assert not support_of(scene(boxes, boxes, threshold_y=cut)).claims
    assert not support_of(scene(boxes, boxes, threshold_x=cut)).claims


def test_a_better_system_is_claimed_as_set_and_at_unequal_thresholds():
    good, bad = detector(1, share=0.95), detector(2, share=0.6)
    as_set = support_of(scene(good, bad))
    assert as_set.basis is Basis.AS_SET
    assert {"mean_similarity", "log_average_miss_rate"} <= {claim.key for claim in as_set.claims}
    assert {claim.n for claim in as_set.claims} == {12}
    # the better one at a strict threshold: as set, it detects less
    result = scene(good, bad, threshold_x=0.7)
    assert result.boxes.x_only < result.boxes.y_only
    support = support_of(result)
    assert support.basis is Basis.EQUAL_ALARMS
    assert {claim.winner for claim in (*as_set.claims, *support.claims)} == {"x"}


def test_few_false_alarms_do_not_set_two_systems_alike():
    good, bad = detector(1, share=0.95), detector(2, share=0.6)
    # of the alarms of the worse one, those of a single recording and a few others are left
    few = [box for box in bad if box.x > 10 or (box.recording == 0 and box.score > 0.2)]
    result = scene(good, few)
    assert are_unequal(result)
    evidence, companions = judge_both(result)
    assert not find_claims(result, evidence, companions).claims
    at_equal = companions.evidence.set_index("figure")
    row = at_equal.loc["mean_similarity"]
    undefined = ["p", "p_corrected", "low", "high", "least_p", "effect"]
    assert row[undefined].isna().all()
    assert row["method"] == ""
    assert UNSURE in row["note"]
    assert np.isfinite(row["difference"])
    assert np.isfinite(at_equal.loc["log_average_miss_rate", "p"])  # it is of all thresholds


def test_pairs_are_told_apart_at_equal_false_alarms_after_correction_over_pairs():
    result = scene(detector(1, share=0.95), detector(2, share=0.6))
    as_set = evidence_table(result).set_index("figure", drop=False).loc[[*CLAIMED]]
    as_set = as_set.assign(p_corrected=0.001)
    companions = find_companions(result, as_set, primary="")
    assert companions.evidence is not None
    sure, unsure = (
        claims_of_pair(result, as_set, companions, np.full(len(CLAIMED), p)) for p in (0.05, 0.051)
    )
    assert sure["higher_similarity"] == "x"
    assert "higher_similarity" not in unsure


def test_a_better_system_at_a_threshold_of_its_own_is_claimed_by_its_pair():
    good, bad = detector(1, share=0.95), detector(2, share=0.4)
    dataset = scene(good, bad).dataset
    (alike,) = pairwise_table(dataset).to_dict("records")
    (apart,) = pairwise_table(dataset, thresholds={"x": 0.7}).to_dict("records")
    assert (alike["is_unequal"], apart["is_unequal"]) == (False, True)
    assert apart["similarity_x"] < alike["similarity_x"]
    assert alike["higher_similarity"] == apart["higher_similarity"] == "x"


def test_the_system_with_more_false_alarms_is_moved_or_the_only_one_with_scores():
    few, many = detector(1, cut=0.5), detector(2)
    assert which_moves(scene(few, many)) == "y"
    assert which_moves(scene(many, few)) == "x"
    plain = [box._replace(score=NAN) for box in many]
    assert which_moves(scene(few, plain)) == "x"
    assert which_moves(scene(plain, plain)) == ""
    constant = [box._replace(score=1) for box in many]
    assert which_moves(scene(few, constant)) == "x"
    assert which_moves(scene(constant, constant)) == ""


@pytest.mark.parametrize("score", [1.0, 0.8])
def test_a_threshold_that_leaves_no_detection_sets_nothing_alike(score: float):
    """Y scores its alarms 1, and its matches alike or lower; X has no alarm."""
    x = [at(frame, 20, score=frame / 20) for frame in range(20)]
    y = [*(box._replace(score=score) for box in x), *(at(f, 5, score=1) for f in range(9))]
    result = scene(x, y, n=1)
    assert (find_equal_alarms(result), at_operating_point(result, "equal-alarms")) == (None, result)
    key = "verdict.no_scores" if score == 1 else "verdict.no_threshold"
    x_bare = [box._replace(score=NAN) for box in x]
    result = scene(x_bare, y, n=1)
    companions = find_companions(result, evidence_table(result, has_intervals=False))
    assert verdict(result, companions=companions).headline.key == key


def test_the_system_that_moves_has_as_many_false_alarms_as_the_other():
    result = scene(detector(1, cut=0.5), detector(2))
    companions = find_companions(result, evidence_table(result, has_intervals=False))
    equal = companions.equal
    assert equal is not None
    assert equal.as_set is result
    assert equal is find_equal_alarms(result)
    assert equal_setting(equal)["moved"] == "y"
    assert count_alarms(equal.y) == count_alarms(equal.x) == count_alarms(result.x)
    assert at_operating_point(result, "as-set") is result
    assert at_operating_point(result, "equal-alarms") is equal


def test_another_setting_keeps_the_threshold_and_what_does_not_depend_on_it():
    result = scene(detector(1, cut=0.5), detector(2))
    equal = find_equal_alarms(result)
    changed = compare(result.dataset, replace(result.params, alpha=0.9), previous=equal)
    assert changed.y.matches is result.y.matches
    after = find_equal_alarms(changed, equal)
    assert after.y.matches is equal.y.matches
    anew = find_equal_alarms(compare(result.dataset, changed.params))
    assert after.y.threshold == anew.y.threshold
    assert after.y.similarity.tolist() == anew.y.similarity.tolist()


def test_a_comparison_at_equal_false_alarms_ends_with_its_last_use():
    result = scene(detector(1, cut=0.5), detector(2))
    equal = find_equal_alarms(result)
    assert find_equal_alarms(result) is equal
    ended = weakref.ref(equal)
    del equal
    assert ended() is None
    assert can_be_equal(result)
    assert find_equal_alarms(result).as_set is result


def test_claims_are_the_same_as_set_and_shown_at_equal_false_alarms():
    result = scene(detector(1, share=0.95, cut=0.3), detector(2, share=0.6))
    claims = support_of(result).claims
    assert claims
    assert support_of(find_equal_alarms(result)).claims == claims


def test_a_difference_at_equal_false_alarms_allows_for_alarms_that_are_not_equal_elsewhere():
    result = scene(detector(1, cut=0.5), detector(2))
    equal = find_equal_alarms(result)
    shown = evidence_table(equal).set_index("figure")
    plain = significance_table(equal).set_index("figure")
    for key in ("mean_similarity", "severity_s_per_encounter"):
        row = shown.loc[key]
        assert row["difference"] == pytest.approx(np.subtract(*values_of(key, equal)))
        assert row["low"] < row["difference"] < row["high"]
        width = plain.loc[key, "high"] - plain.loc[key, "low"]
        assert row["high"] - row["low"] > width


def test_a_shift_is_the_part_of_a_recording_in_the_ratio_of_alarms_times_a_slope():
    result = scene(detector(1, cut=0.5), detector(2))
    equal = find_equal_alarms(result)
    assert equal is not None
    units = find_units(equal)
    shifts = shifts_at_equal_alarms(equal, units)
    recording = equal.dataset.frame_columns.recording
    x, y = (
        np.bincount(recording, system.false_alarms)[units.recording] for _, system in equal.sides
    )
    shift = shifts["mean_similarity"]
    assert shift[x == y].tolist() == [0] * np.count_nonzero(x == y)
    slope = shift[x != y] / (x - y)[x != y]
    assert slope == pytest.approx(slope[0])
    assert slope[0] > 0  # more alarms of X, at a lower threshold: X has more matches


@pytest.mark.parametrize("cut", [0.0, 0.3])
def test_exchanging_x_and_y_mirrors_claims_p_and_intervals(cut: float):
    good, bad = detector(1, share=0.95, cut=cut), detector(2, share=0.6)
    there, back = (scene(good, bad), scene(bad, good))
    (evidence, companions), (mirrored, others) = (judge_both(result) for result in (there, back))
    tables = [(evidence, mirrored), (companions.evidence, others.evidence)]
    tables.append(tuple(evidence_table(find_equal_alarms(of)) for of in (there, back)))
    for table, other in tables:
        for column in ("p", "p_corrected"):
            assert other[column].tolist() == pytest.approx(
                table[column].tolist(), rel=1e-9, nan_ok=True
            )
        for column, end in (("difference", "difference"), ("low", "high"), ("high", "low")):
            by_unit = slice(1, None)  # McNemar's interval of shares is not an exact mirror
            assert other[column][by_unit].tolist() == pytest.approx(
                (-table[end][by_unit]).tolist(), rel=1e-9, nan_ok=True
            )
    claims = find_claims(there, evidence, companions).claims
    of_others = find_claims(back, mirrored, others).claims
    assert claims
    assert {claim.key: claim.winner for claim in of_others} == dict.fromkeys(
        (claim.key for claim in claims), "y"
    )


def test_thresholds_with_as_many_alarms_have_to_agree_on_the_better_system():
    table = pd.DataFrame(
        {
            "difference": [1.0, 1.0, 1.0], "p": [0.01, 0.02, NAN],
            "p_corrected": [0.02, 0.04, NAN], "low": [0.5, 0.5, NAN], "high": [1.5, 1.5, NAN],
        }
    )  # fmt: skip
    end = table.assign(difference=[0.8, -0.1, 0.9], p=[0.03, 0.01, NAN])
    both = least_of(table, [end])
    assert both["p"].tolist() == pytest.approx([0.03, 1.0, NAN], nan_ok=True)
    assert both["p_corrected"].tolist() == pytest.approx([0.02, 1.0, NAN], nan_ok=True)
    assert both["low"].tolist() == pytest.approx([0.3, -0.6, NAN], nan_ok=True)
    assert both["high"].tolist() == pytest.approx([1.5, 1.5, NAN], nan_ok=True)


def test_a_few_more_false_alarms_are_no_other_operating_point():
    def with_alarms(n_x: int, n_y: int) -> Result:
        x, y = ([at(frame, 5) for frame in range(n)] for n in (n_x, n_y))
        return result_of(make_dataset([], x, y, n_frames=100))

    assert not are_unequal(with_alarms(30, 45))
    assert are_unequal(with_alarms(30, 46))
    assert are_unequal(with_alarms(0, 6))
    assert not are_unequal(with_alarms(5, 0))


def test_nothing_is_claimed_from_fewer_than_six_recordings_nor_before_the_companions():
    good, bad = (detector(seed, share=share, n=5) for seed, share in ((1, 0.95), (2, 0.5)))
    assert not support_of(scene(good, bad, n=5)).claims
    result = scene(detector(1, share=0.95), detector(2, share=0.5))
    support = find_claims(result, evidence_table(result), None)
    assert not support.claims
    assert "mean_similarity" in support.withheld


def test_clustered_encounters_are_no_more_than_their_recordings():
    # X detects all twelve encounters of two recordings, Y those of one; the rest both
    truth, x, y = [], [], []
    for number in range(6):
        for track in range(12):
            for frame in range(2 * track, 2 * track + 2):
                box = at(frame, 50, track=track, recording=number)
                truth.append(box)
                if number != 5:
                    x.append(box._replace(score=0.9))
                if number > 1:
                    y.append(box._replace(score=0.9))
    result = result_of(make_dataset(truth, x, y, places=[Place(range(24))] * 6))
    assert (result.venn.x_only, result.venn.y_only) == (24, 12)
    assert result.mcnemar_p < 0.1  # encounter by encounter it nearly seems to be a difference
    assert not support_of(result).claims


def test_where_strict_pairing_turns_it_round_it_is_no_claim():
    result = result_of(turned_by_strict_pairing())
    strict = compare(result.dataset, Params(proximity="none", pairing="matched"))
    assert result.x.summary.mean < result.y.summary.mean
    assert strict.x.summary.mean > strict.y.summary.mean
    support = support_of(result)
    assert support.withheld["mean_similarity"] == Note("verdict.turned_strictly")
    assert "mean_similarity" not in {claim.key for claim in support.claims}


def test_a_miss_rate_in_doubt_is_withheld_with_the_reason():
    result = scene(detector(1, share=0.95), detector(2, share=0.6))
    evidence = evidence_table(result, has_intervals=False)
    is_miss_rate = evidence["figure"] == "log_average_miss_rate"
    evidence.loc[is_miss_rate, "doubt"] = "the list ends early"
    support = find_claims(result, evidence, find_companions(result, evidence))
    assert support.withheld["log_average_miss_rate"] == Note(
        "verdict.doubted", doubt="the list ends early"
    )
    assert "log_average_miss_rate" not in {claim.key for claim in support.claims}


@pytest.mark.realdata
def test_kaist_a_weak_system_at_a_low_threshold_is_not_preferred(kaist: Dataset):
    params = Params(threshold_x=0.0, threshold_y=0.5)
    result = compare(kaist, params, x="YOLOv3-visible", y="MBNet")
    assert result.venn.x_only > 5 * result.venn.y_only
    evidence = evidence_table(result, PROTOCOLS["kaist-reasonable"], has_intervals=False)
    support = find_claims(result, evidence, find_companions(result, evidence))
    assert support.basis is Basis.EQUAL_ALARMS
    assert {claim.winner for claim in support.claims} == {"y"}
    assert "log_average_miss_rate" in {claim.key for claim in support.claims}


OF_NO_USE = EstimateRecord("m", "ab", "no", 3, of_no_use=True)


def seen_little(detectability: Sequence[float], n: int = 14) -> Dataset:
    """X detects all pedestrians of each recording, Y few boxes of those with odd numbers."""
    truth = [
        at(f, 20 + 20 * i, track=i, recording=recording, detectability=share)
        for recording in range(n)
        for i, share in enumerate(detectability)
        for f in range(4)
    ]
    scores = np.random.default_rng(0).random(len(truth)).tolist()
    x = [box._replace(score=score) for box, score in zip(truth, scores, strict=True)]
    y = [box for box in x if box.track % 2 == 0 or box.score < 0.2]
    return make_dataset(truth, x, y, places=[Place(range(4))] * n)


@pytest.mark.parametrize("kind", ["useless", "open"])
def test_useful_alerts_are_no_claim_where_nothing_is_claimed_of_whom_the_driver_sees(kind: str):
    dataset = seen_little([0.3, 0.3, 0.3])
    assert "useful_alerts_by_unit" in {c.key for c in support_of(result_of(dataset)).claims}
    if kind == "useless":
        names = frozenset(dataset.recordings["name"])
        doubted = replace(dataset, of_subjects={"driver": replace(OF_NO_USE, estimated_in=names)})
    else:
        doubted = replace(dataset, boxes=dataset.boxes.assign(detectability_sd=0.3))
    support = support_of(result_of(doubted))
    keys = {claim.key for claim in support.claims}
    assert "useful_alerts_by_unit" not in keys
    assert "encounters_detected_by_unit" in keys
    why = {"useless": "no better than a constant", "open": "within one standard deviation"}
    assert why[kind] in support.withheld["useful_alerts_by_unit"]["doubt"]


def test_what_is_weighted_by_an_estimator_that_learned_nothing_is_no_claim():
    dataset = replace(seen_little([0.3, 0.3, 0.3]), of_subjects={"driver": OF_NO_USE})
    plain, weighted = (
        support_of(result_of(dataset, driver_weighting=weighting)) for weighting in ("off", "on")
    )
    of_weights = {"mean_similarity", "severity_s_per_encounter"}
    assert of_weights <= {claim.key for claim in plain.claims}
    assert not of_weights & {claim.key for claim in weighted.claims}
    assert of_weights <= set(weighted.withheld)
    for weighting, is_undefined in (("off", False), ("on", True)):
        result = result_of(dataset, driver_weighting=weighting)
        name = "mean_similarity_worse_x"
        worse = gate_measures(result, (), dataset.settings.protocol, [name])[name]
        assert np.isnan(worse) == is_undefined
    groups = subgroup_table(result_of(dataset, driver_weighting="on"))
    doubts = groups[groups["figure"] == "mean_similarity"]["doubt"]
    assert len(doubts)
    assert doubts.str.contains("no better than a constant").all()
    trusted = result_of(seen_little([0.3, 0.3, 0.3]), driver_weighting="on")
    evidence = evidence_table(trusted)
    companions = find_companions(trusted, evidence)
    conclusion = verdict(trusted, evidence=evidence, companions=companions).headline["conclusion"]
    assert conclusion["remarks"] == [Note("driver.weighted_claims")]
