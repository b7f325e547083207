"""Figures of a curve in one place."""

from dataclasses import fields

import numpy as np
import pytest
from curve_scenes import curve_of

from nvcore.curve_summary import SUMMARY_ROWS, CurveSummary, summarise_curve


def test_figures_by_hand():
    found = summarise_curve(curve_of([1, 2], [0, 2], n_truth=2, n_images=100), 1.0)
    # recall 0.5 at precision 1, then recall 1 at precision 0.5
    assert found.average_precision == pytest.approx(0.5 * 1 + 0.5 * 0.5)
    assert found.average_precision_coco == pytest.approx((51 * 1 + 50 * 0.5) / 101)
    assert (found.best_f1, found.best_f1_threshold) == (pytest.approx(2 / 3), 1.0)
    assert (found.recall, found.precision, found.fppi) == (0.5, 1, 0)
    assert found.log_average_miss_rate == 0  # nothing is missed at FPPI 0.02
    assert found.why_undefined is None


def test_every_row_is_a_figure():
    names = {field.name for field in fields(CurveSummary)}
    assert {name for name, *_ in SUMMARY_ROWS} < names


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        (curve_of([0], [3], n_truth=0), "no pedestrian"),
        (curve_of([1], [3], n_truth=2, is_ranked=False), "no score"),
    ],
)
def test_undefined_figures_are_nan_with_the_reason(curve, words):
    found = summarise_curve(curve, None)
    assert np.isnan(found.average_precision)
    assert np.isnan(found.log_average_miss_rate)
    assert found.why_undefined is not None
    assert words in found.why_undefined


def test_without_detections_nothing_is_found():
    found = summarise_curve(curve_of([], [], n_truth=3), None)
    assert (found.recall, found.fppi) == (0, 0)
    assert np.isnan(found.best_f1)
