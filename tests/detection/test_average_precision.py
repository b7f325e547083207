"""Areas under the precision-recall curve: published examples, another program, invariants."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from builders import Box, make_dataset
from curve_scenes import curve_of, random_boxes
from faster_coco_eval import COCO, COCOeval_faster

from nvcore.metrics.detection.average_precision import (
    average_precision,
    average_precision_coco,
    pr_auc,
)
from nvcore.metrics.detection.curves import DetectionCurve, detection_curve
from nvcore.settings.params import Params

AREAS = (average_precision, average_precision_coco, pr_auc)


def coco_ap(
    truth: list[Box], found: list[Box], n_frames: int, iou: float, *, most: int = 100
) -> float:
    """AP of faster-coco-eval: 101 recalls, `most` detections a picture at the most."""
    document: dict[str, Any] = {
        "images": [{"id": f + 1} for f in range(n_frames)],
        "categories": [{"id": 1, "name": "person"}],
        "annotations": [
            {"id": i + 1, "image_id": b.frame + 1, "category_id": 1, "bbox": [b.x, b.y, b.w, b.h],
             "area": b.w * b.h, "iscrowd": int(b.ignore)}
            for i, b in enumerate(truth)
        ],
    }  # fmt: skip
    results = [
        {"image_id": b.frame + 1, "category_id": 1, "bbox": [b.x, b.y, b.w, b.h], "score": b.score}
        for b in found
    ]
    ours = COCO(document)
    evaluation = COCOeval_faster(
        ours, ours.loadRes(results), "bbox", print_function=lambda *_: None
    )
    evaluation.params.iouThrs = np.array([iou])
    evaluation.params.maxDets = [1, 10, most]
    evaluation.evaluate()
    evaluation.accumulate()
    return float(evaluation.eval["precision"][0, :, 0, 0, -1].mean())


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("iou", [0.3, 0.5, 0.75])
def test_ap_agrees_with_another_program(seed, iou):
    truth, detections, places = random_boxes(seed, n_frames=80)
    if iou != 0.5:  # regions absorb from a share of 0.5 on; COCO's absorb from the IoU on
        truth = [box for box in truth if not box.ignore]
    dataset = make_dataset(truth, detections, places=places)
    ours = average_precision_coco(detection_curve(dataset, "x", Params(iou=iou)))
    assert ours == pytest.approx(coco_ap(truth, detections, 80, iou), abs=1e-6)
    assert 0.02 < ours < 0.9  # not an empty agreement


@pytest.mark.parametrize("n_truth", [100, 57, 29, 7])
def test_ap_agrees_where_recalls_fall_on_the_101_points(n_truth):
    # every recall i / n that COCO compares with its own i * 0.01
    truth = [Box(f, 10, 10, 20, 40) for f in range(n_truth)]
    rng = np.random.default_rng(n_truth)
    detections = [Box(f, 10, 10, 20, 40, score=1 - f / n_truth) for f in range(n_truth)]
    detections += [Box(f, 60, 10, 20, 40, score=float(rng.random())) for f in range(n_truth)]
    ours = average_precision_coco(detection_curve(make_dataset(truth, detections), "x", Params()))
    assert ours == pytest.approx(coco_ap(truth, detections, n_truth, 0.5), abs=1e-6)


def test_ap_counts_every_detection_of_a_picture():
    truth = [Box(0, 10, 5 * i, 20, 40) for i in range(30)]
    rng = np.random.default_rng(5)
    detections = [Box(0, 10, 5 * i, 20, 40, score=float(rng.random())) for i in range(30)]
    detections += [Box(0, 100 + i, 300, 20, 40, score=float(rng.random())) for i in range(170)]
    ours = average_precision_coco(detection_curve(make_dataset(truth, detections), "x", Params()))
    assert ours == pytest.approx(coco_ap(truth, detections, 1, 0.5, most=200), abs=1e-6)
    assert ours > coco_ap(truth, detections, 1, 0.5) + 0.01  # with COCO's own limit of 100


def test_average_precision_counted_by_hand():
    # found: right, wrong, right, right, of 4; precision 1, 1/2, 2/3, 3/4, envelope 1, 3/4 x 3
    curve = curve_of([1, 1, 2, 3], [0, 1, 1, 1], n_truth=4)
    assert average_precision(curve) == pytest.approx((1 + 3 / 4 + 3 / 4) / 4)
    # recalls 0..0.25: 26 points at 1; 0.26..0.75: 50 at 3/4; none beyond
    assert average_precision_coco(curve) == pytest.approx((26 + 50 * 0.75) / 101)


def test_the_area_of_the_worked_example_of_davis_and_goadrich():
    # ICML 2006, section 3: A has 5 true and 5 false positives, B 10 and 30, of 20 positives
    p = [0.5] * 6 + [6 / 16, 7 / 22, 8 / 28, 9 / 34, 10 / 40]
    expected = sum((a + b) / 2 for a, b in pairwise(p)) / 20
    assert pr_auc(curve_of([5, 10], [5, 30], n_truth=20)) == pytest.approx(expected)
    # a straight line from A to B would promise more
    assert expected < (0.25 * 0.5) + 0.25 * (0.5 + 0.25) / 2


def auc_by_loops(curve: DetectionCurve) -> float:
    """One true positive after the other, along the segments between the points."""
    area, tp0, fp0 = 0.0, 0, 0
    for tp1, fp1 in zip(curve.tp.tolist(), curve.fp.tolist(), strict=True):
        for i in range(tp1 - tp0):
            skew = (fp1 - fp0) / (tp1 - tp0)
            ends = [(tp0 + j, fp0 + j * skew) for j in (i, i + 1)]
            right = ends[1][0] / sum(ends[1])
            left = ends[0][0] / sum(ends[0]) if sum(ends[0]) else right
            area += (left + right) / 2
        tp0, fp0 = tp1, fp1
    return area / curve.n_truth


@pytest.mark.parametrize("seed", range(5))
def test_the_area_is_that_of_plain_loops(seed):
    rng = np.random.default_rng(seed)
    steps = rng.integers(0, 6, (2, 30))
    tp, fp = np.cumsum(steps, axis=1).tolist()
    curve = curve_of(tp, fp, n_truth=tp[-1] + 5)
    assert pr_auc(curve) == pytest.approx(auc_by_loops(curve), rel=1e-12)


@pytest.mark.parametrize(
    ("tp", "fp", "area"), [([1, 2, 3], [0, 0, 0], 1), ([0, 0], [1, 2], 0), ([], [], 0)]
)
def test_perfect_detectors_have_an_area_of_1_and_false_positives_or_nothing_none(tp, fp, area):
    assert [measure(curve_of(tp, fp, n_truth=3)) for measure in AREAS] == pytest.approx([area] * 3)


@pytest.mark.parametrize(
    "undefined", [curve_of([0], [4], n_truth=0), curve_of([3], [1], n_truth=4, is_ranked=False)]
)
def test_without_pedestrians_or_scores_areas_are_undefined(undefined):
    assert all(math.isnan(area(undefined)) for area in AREAS)


def test_a_false_positive_never_enlarges_an_area():
    for area in AREAS:
        without = area(curve_of([1, 2, 3], [0, 1, 1], n_truth=4))
        assert area(curve_of([1, 2, 3], [0, 2, 2], n_truth=4)) < without
