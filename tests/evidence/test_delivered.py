"""Delivered products: thresholds stay, the better one has not clearly more false alarms."""

from __future__ import annotations

from dataclasses import replace
from math import exp

import numpy as np
import pytest
from builders import Box, Place, at, make_dataset
from drives import detector

from nvcore.comparison.compare import Result, compare
from nvcore.evidence.claims import Basis, alarm_ratio_limit
from nvcore.evidence.operating_points import are_unequal, at_operating_point
from nvcore.evidence.pairwise import pairwise_table
from nvcore.evidence.planning import plan_recordings
from nvcore.evidence.table import judge_both
from nvcore.evidence.units import find_units
from nvcore.report.verdict import HOW_SURE, Verdict, verdict

N = 12


def delivered(x: list[Box], y: list[Box], *, is_delivered: bool = True) -> Result:
    """Four pedestrians in 20 frames of 12 recordings."""
    truth = [
        at(frame, centre, track=centre, recording=number)
        for number in range(N)
        for frame in range(20)
        for centre in (20, 40, 60, 80)
    ]
    dataset = make_dataset(truth, x, y, places=[Place(range(20))] * N)
    point = "delivered" if is_delivered else "as-set"
    return compare(dataset.with_settings(replace(dataset.settings, operating_point=point)))


def judged(result: Result) -> Verdict:
    evidence, companions = judge_both(result, has_intervals=False)
    return verdict(result, evidence=evidence, companions=companions)


def without_alarms(boxes: list[Box], every: int) -> list[Box]:
    """Keep one false alarm in `every`, which lie at the left."""
    alarms = [box for box in boxes if box.x < 10]
    return [box for box in boxes if box.x >= 10] + alarms[::every]


GOOD, BAD = detector(1, share=0.95), detector(2, share=0.5)


def test_a_better_system_with_fewer_false_alarms_is_claimed_as_delivered():
    result = delivered(without_alarms(GOOD, 2), BAD)
    conclusion = judged(result)
    assert conclusion.basis is Basis.AS_SET
    assert {claim.winner for claim in conclusion.claims} == {"x"}
    headline = conclusion.say(conclusion.headline)
    assert headline.startswith("With the delivered thresholds, X is better")
    assert "the thresholds stay" in conclusion.sentences[1]
    assert not are_unequal(result)
    assert at_operating_point(result, "equal-alarms") is result
    assert judged(delivered(without_alarms(GOOD, 2), BAD, is_delivered=False)).basis != Basis.AS_SET


def test_a_better_system_with_clearly_more_false_alarms_is_not():
    conclusion = judged(delivered(GOOD, without_alarms(BAD, 3)))
    assert not conclusion.claims
    assert "may have more than 1.25 times the other's false alarms" in " ".join(
        conclusion.sentences
    )
    assert dict(conclusion.topics)[HOW_SURE].endswith(
        "of 100 that X typically misses fewer encounters (no claim), but it may have more than "
        "1.25 times the false alarms."
    )


def test_one_detector_at_two_thresholds_is_no_better_one():
    assert not judged(delivered(detector(1), detector(1, cut=0.5))).claims


def test_pairs_and_plans_follow():
    result = delivered(GOOD, without_alarms(BAD, 3))
    (pair,) = pairwise_table(result.dataset).to_dict("records")
    assert pair["higher_similarity"] == ""
    assert "1.25 times" in pair["withheld"]
    assert not plan_recordings(delivered(GOOD, GOOD[::2])).has_equal_alarms


@pytest.mark.parametrize(
    ("own", "other"), [([3, 1, 2, 2], [2, 2, 4, 4]), ([9, 0, 0, 3], [2, 2, 2, 2])]
)
def test_the_limit_of_the_ratio_is_that_of_its_logarithm(own: list[int], other: list[int]):
    x = [at(f, 5, recording=r) for r, n in enumerate(own) for f in range(n)]
    y = [at(f, 5, recording=r) for r, n in enumerate(other) for f in range(n)]
    result = compare(make_dataset([], x, y, places=[Place(range(20))] * 8))
    own, other = ([*of, 0, 0, 0, 0] for of in (own, other))
    parts = [a / sum(own) - b / sum(other) for a, b in zip(own, other, strict=True)]
    error = (8 / 7 * sum(part**2 for part in parts)) ** 0.5
    ratio = sum(own) / sum(other)
    found = alarm_ratio_limit(result, find_units(result), "x")
    assert found == pytest.approx(ratio * exp(2.3646242515927844 * error))  # t(7), 97.5 %


@pytest.mark.parametrize(("x", "y", "limit"), [(0, 7, np.inf), (8, 0, np.inf), (0, 8, 0.0)])
def test_few_false_alarms_of_the_other_give_no_limit(x: int, y: int, limit: float):
    places = [Place(range(20))] * 8
    boxes = ([at(f, 5) for f in range(n)] for n in (x, y))
    result = compare(make_dataset([at(0, 50, track=1)], *boxes, places=places))
    assert alarm_ratio_limit(result, find_units(result), "x") == limit


def test_no_comparison_at_equal_false_alarms_is_made(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("nvcore.evidence.companions.find_equal_alarms", None)  # not called
    assert judge_both(delivered(GOOD, BAD), has_intervals=False)[1].equal is None
