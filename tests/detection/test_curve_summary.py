"""Figures of a curve in one place."""

from dataclasses import replace

import numpy as np
import pytest
from curve_scenes import curve_of, random_dataset

from nvcore.metrics.detection.curve_summary import summarise_curve
from nvcore.metrics.detection.curves import detection_curve
from nvcore.settings.params import Params


def test_figures_by_hand():
    summary = summarise_curve(curve_of([1, 2], [0, 2], n_truth=2, n_images=100), 1.0)
    # recall 0.5 at precision 1, then recall 1 at precision 0.5
    assert summary.average_precision == pytest.approx(0.5 * 1 + 0.5 * 0.5)
    assert summary.average_precision_coco == pytest.approx((51 * 1 + 50 * 0.5) / 101)
    assert (summary.best_f1, summary.best_f1_threshold) == (pytest.approx(2 / 3), 1.0)
    assert (summary.recall, summary.precision, summary.fppi) == (0.5, 1, 0)
    assert summary.log_average_miss_rate == 0  # nothing is missed at FPPI 0.02
    assert summary.why_undefined is None


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        (curve_of([0], [3], n_truth=0), "no box of the truth"),
        (curve_of([1], [3], n_truth=2, is_ranked=False), "no score"),
    ],
)
def test_undefined_figures_are_nan_with_the_reason(curve, words):
    summary = summarise_curve(curve, None)
    assert np.isnan(summary.average_precision)
    assert np.isnan(summary.log_average_miss_rate)
    assert summary.why_undefined is not None
    assert words in summary.why_undefined


def test_a_log_average_of_0_says_at_how_many_references_nobody_is_missed():
    summary = summarise_curve(curve_of([1, 2], [0, 2], n_truth=2, n_images=100), None)
    assert summary.n_zero_references == 7  # from 10^-1.5 = 0.032 on; FPPI 0.02 is below that
    assert summary.notes[0].startswith("0 at 7 of 9 references")
    assert summary.notes[1].startswith("the curve ends at 0.02 false positives per image")
    whole = summarise_curve(curve_of([1], [100], n_truth=2, n_images=100), None)
    assert whole.n_zero_references == 0


@pytest.mark.parametrize(("threshold", "n"), [(None, 4), (0.5, 3), (0.51, 2), (0.9, 1)])
def test_absorbed_detections_are_counted_at_the_threshold(threshold, n):
    curve = replace(curve_of([1], [3], n_truth=2), absorbed_score=np.array([0.8, 0.5, np.nan, 0.1]))
    assert summarise_curve(curve, threshold).n_absorbed == n


@pytest.mark.parametrize("share_scored", [1.0, 0.6, 0.0])
def test_every_detection_is_right_wrong_or_absorbed(share_scored):
    dataset = random_dataset(2, share_scored=share_scored)
    curve = detection_curve(dataset, "x", Params())
    summary = summarise_curve(curve, None)
    assert summary.n_absorbed > 0
    n = int(curve.tp[-1] + curve.fp[-1]) + summary.n_absorbed
    assert n == len(dataset.system("x"))
