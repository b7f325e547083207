"""Log-average miss rate: by hand, at its ends, and where other programs go wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest
from curve_scenes import curve_of, random_dataset

from nvcore.common.errors import ParameterError
from nvcore.metrics.detection.curves import detection_curve
from nvcore.metrics.detection.miss_rate import (
    FPPI_REFERENCES,
    ROUNDED_REFERENCES,
    explain_few,
    explain_range,
    explain_zero,
    log_average_miss_rate,
    miss_rate_at,
)
from nvcore.settings.objects import PEDESTRIAN
from nvcore.settings.params import Params


def test_the_nine_references_are_even_in_logarithm():
    assert FPPI_REFERENCES.round(4).tolist() == ROUNDED_REFERENCES.tolist()
    assert (FPPI_REFERENCES[0], FPPI_REFERENCES[4], FPPI_REFERENCES[8]) == (0.01, 0.1, 1.0)


def test_the_miss_rate_is_read_at_the_last_point_with_at_most_so_many():
    # 100 images: 0, 1, 1, 5 false positives
    curve = curve_of([1, 2, 3, 4], [0, 1, 1, 5], n_truth=10)
    at = miss_rate_at(curve, np.array([0.0, 0.009, 0.01, 0.049, 0.05, 1.0]))
    assert at == pytest.approx([0.9, 0.9, 0.7, 0.7, 0.6, 0.6])


def test_before_the_first_point_everybody_is_missed():
    assert miss_rate_at(curve_of([5], [10], n_truth=10), 0.05).item() == 1.0
    assert miss_rate_at(curve_of([], [], n_truth=10), 0.05).item() == 1.0


@pytest.mark.parametrize(
    ("curve", "expected"),
    [
        # 1 up to 0.0562 (four references), 0.5 from 0.1 on (five)
        (curve_of([5], [10], n_truth=10), 0.5 ** (5 / 9)),
        (curve_of([3], [0], n_truth=3), 0.0),  # warnings are errors in these tests
        (curve_of([1, 3], [0, 50], n_truth=3), 0.0),  # a geometric mean with a zero is zero
        (curve_of([], [], n_truth=3), 1.0),
    ],
)
def test_the_log_average_by_hand(curve, expected):
    assert log_average_miss_rate(curve) == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(3))
def test_the_log_average_is_that_of_plain_loops(seed):
    curve = detection_curve(random_dataset(seed, n_frames=300), "x", Params(iou=0.6))
    logs = []
    for exponent in range(-8, 1):
        rate = 1.0
        for tp, fp in zip(curve.tp.tolist(), curve.fp.tolist(), strict=True):
            if fp / curve.n_images <= 10 ** (exponent / 4):
                rate = 1 - tp / curve.n_truth
        logs.append(math.log(rate))
    expected = math.exp(sum(logs) / 9)
    assert 0.05 < expected < 1
    assert log_average_miss_rate(curve) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "undefined", [curve_of([0], [4], n_truth=0), curve_of([3], [1], n_truth=4, is_ranked=False)]
)
def test_without_pedestrians_or_scores_it_is_undefined(undefined):
    assert math.isnan(log_average_miss_rate(undefined))
    assert np.isnan(miss_rate_at(undefined, [0.01, 1.0])).all()


def test_references_must_be_positive():
    for wrong in ([], [0.0, 1.0]):
        with pytest.raises(ParameterError, match="references: expected positive numbers"):
            log_average_miss_rate(curve_of([1], [1], n_truth=2), references=np.array(wrong))


def test_the_rounded_references_can_lie_on_the_other_side_of_a_false_positive():
    # 46 of 1455 images: 0.031615, between 0.0316 and 10^-1.5
    curve = curve_of([1, 9], [0, 46], n_truth=10, n_images=1455)
    exact, rounded = (miss_rate_at(curve, refs[2]).item()
                      for refs in (FPPI_REFERENCES, ROUNDED_REFERENCES))  # fmt: skip
    assert (exact, rounded) == pytest.approx((0.1, 0.9))


def test_a_zero_is_explained_with_how_many_references_make_it():
    # nobody is missed from 0.5 false positives per image on: at 10^-0.25 and at 1
    rates = miss_rate_at(curve_of([1, 3], [0, 50], n_truth=3), FPPI_REFERENCES)
    assert explain_zero(rates) == (
        "0 at 2 of 9 references: the geometric mean is 0 though at the others up to 66.7 % are "
        "missed"
    )
    assert explain_zero(np.zeros(9)) == "nothing is missed at any of the 9 references"
    assert explain_zero(np.full(9, 0.1)) == ""
    assert explain_zero(np.full(9, np.nan)) == ""


def explained(curve):
    return explain_range(curve, miss_rate_at(curve, FPPI_REFERENCES))


def test_it_is_said_what_counts_where_a_curve_does_not_reach_the_references():
    assert explained(curve_of([1, 2], [5, 47], n_truth=4)) == (
        "the curve begins at 0.05 false positives per image: at fewer its miss rate counts as "
        "100 %",
        "the curve ends at 0.47 false positives per image: from there to 1 its last miss rate "
        "counts, 50.0 %",
    )
    assert explained(curve_of([1, 2], [1, 100], n_truth=4)) == ()
    assert explained(curve_of([3], [0], n_truth=4)) == (
        "there is no false positive: at every reference the last miss rate counts, 25.0 %",
    )


def test_nothing_is_said_of_the_ends_of_a_curve_that_is_0_or_none():
    assert explained(curve_of([4], [0], n_truth=4)) == ()
    assert explained(curve_of([], [], n_truth=4)) == ()
    assert explained(curve_of([1], [1], n_truth=4, is_ranked=False)) == ()


@pytest.mark.parametrize(("n_truth", "is_few"), [(0, False), (1, True), (99, True), (100, False)])
def test_few_pedestrians_are_told_with_the_weight_of_each(n_truth, is_few):
    assert bool(explain_few(n_truth, PEDESTRIAN)) is is_few
    assert explain_few(23, PEDESTRIAN) == (
        "few pedestrians: 23, a single miss changes the miss rate by 4.3 percentage points"
    )
