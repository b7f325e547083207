"""Detection curves: counted by hand, against plain loops, and their empty cases."""

from __future__ import annotations

import math

import numpy as np
import pytest
from builders import Box, at, make_dataset
from curve_scenes import curve_of, random_boxes, random_dataset
from oracle import match as match_by_oracle

from nvcore.common.errors import ParameterError
from nvcore.metrics.detection.curves import (
    CURVE_COLUMNS,
    curve_table,
    detection_curve,
    detection_outcomes,
)
from nvcore.metrics.detection.operating_point import operating_point
from nvcore.settings.params import Params


def small():
    """Three pedestrians in four frames; scores .9 (hit), .8 (wrong), .7 twice (hit, wrong)."""
    truth = [at(f, 50) for f in range(3)]
    x = [
        at(0, 50, score=0.9), at(0, 10, score=0.8), at(1, 50, score=0.7), at(3, 50, score=0.7),
    ]  # fmt: skip
    return make_dataset(truth, x, n_frames=4)


def test_points_counted_by_hand():
    curve = detection_curve(small(), "x", Params())
    assert curve.threshold.tolist() == [0.9, 0.8, 0.7]
    assert curve.tp.tolist() == [1, 1, 2]
    assert curve.fp.tolist() == [0, 1, 2]
    assert (curve.n_truth, curve.n_images, curve.is_ranked) == (3, 4, True)
    assert curve.recall == pytest.approx([1 / 3, 1 / 3, 2 / 3])
    assert curve.miss_rate == pytest.approx([2 / 3, 2 / 3, 1 / 3])
    assert curve.precision == pytest.approx([1, 1 / 2, 1 / 2])
    assert curve.f1 == pytest.approx([2 / 4, 2 / 5, 4 / 7])
    assert curve.fppi == pytest.approx([0, 1 / 4, 1 / 2])
    assert curve.fppw(50) == pytest.approx([0, 1 / 200, 1 / 100])


def test_the_table_has_the_roc_over_images_and_over_windows():
    table = curve_table(detection_curve(small(), "x", Params()), windows_per_image=50)
    assert tuple(table) == CURVE_COLUMNS
    assert table["fn"].tolist() == [2, 2, 1]
    roc = table[["fppi", "fppw", "recall"]].to_numpy()
    assert roc[-1] == pytest.approx([1 / 2, 1 / 100, 2 / 3])
    assert curve_table(curve_of([1], [1], n_truth=2))["fppw"].isna().all()


@pytest.mark.parametrize("n_windows", [0, -1, math.nan, math.inf])
def test_windows_per_image_must_be_positive(n_windows):
    with pytest.raises(ParameterError, match="expected a positive number"):
        curve_of([1], [1], n_truth=2).fppw(n_windows)


@pytest.mark.parametrize(
    ("threshold", "expected"),
    [(None, (0.7, 2, 2, 1)), (0.1, (0.7, 2, 2, 1)), (0.75, (0.8, 1, 1, 2)),
     (0.8, (0.8, 1, 1, 2)), (0.9, (0.9, 1, 0, 2)), (0.95, (0.95, 0, 0, 3))],
)  # fmt: skip
def test_the_operating_point_is_that_of_the_lowest_score_that_passes(threshold, expected):
    point = detection_curve(small(), "x", Params()).at(threshold)
    assert (point.threshold, point.tp, point.fp, point.fn) == expected
    assert point.miss_rate == pytest.approx(expected[3] / 3)
    assert math.isnan(point.precision) == (point.tp + point.fp == 0)
    assert (point.f1, point.fppi) == (2 * point.tp / (point.tp + point.fp + 3), point.fp / 4)


@pytest.mark.parametrize("match", ["iou", "lateral"])
@pytest.mark.parametrize("n_scores", [None, 7])
def test_every_point_is_what_plain_loops_find_at_its_threshold(match, n_scores):
    truth, detections, places = random_boxes(3, n_scores=n_scores)
    params = Params(match=match, iou=0.4)
    curve = detection_curve(make_dataset(truth, detections, places=places), "x", params)
    keys = [(r, f) for r, place in enumerate(places) for f in place.frames]
    for i in range(0, len(curve), max(len(curve) // 12, 1)):
        tp = fp = 0
        for r, f in keys:
            G = [b for b in truth if (b.recording, b.frame) == (r, f)]
            D = [b for b in detections if (b.recording, b.frame) == (r, f)]
            pairs, alarms = match_by_oracle(G, D, places[r], params, float(curve.threshold[i]))
            tp, fp = tp + len(pairs), fp + len(alarms)
        assert (curve.tp[i], curve.fp[i]) == (tp, fp)
    assert curve.n_truth == sum(not box.ignore for box in truth)


def test_equal_scores_are_one_point_whatever_their_order_in_the_file():
    truth, detections, places = random_boxes(7, n_scores=5)
    as_read, by_score = (
        detection_curve(make_dataset(truth, boxes, places=places), "x", Params())
        for boxes in (detections, sorted(detections, key=lambda box: (box.frame, box.score)))
    )
    assert len(as_read) == 5
    assert as_read.tp.tolist() == by_score.tp.tolist()
    assert as_read.fp.tolist() == by_score.fp.tolist()


def test_counts_only_grow_with_falling_threshold():
    curve = detection_curve(random_dataset(11), "x", Params())
    assert (np.diff(curve.threshold) < 0).all()
    assert (np.diff(curve.tp) >= 0).all()
    assert (np.diff(curve.fp) >= 0).all()
    assert (np.diff(curve.tp + curve.fp) >= 1).all()


def test_a_system_without_scores_is_one_point():
    curve = detection_curve(random_dataset(2, share_scored=0.0), "x", Params())
    assert curve.threshold.tolist() == [math.inf]
    assert not curve.is_ranked
    assert curve.why_undefined == "detections have no score: there are points, but no curve"
    assert curve.at(None) == curve.at(0.5)
    assert curve.at(None).tp == curve.tp[0] > 0


def test_a_system_with_and_without_scores_is_matched_anew_at_each_point():
    truth, detections, places = random_boxes(4, share_scored=0.6, n_frames=30)
    dataset = make_dataset(truth, detections, places=places)
    curve = detection_curve(dataset, "x", Params())
    assert len(curve) == 25
    assert curve.threshold[0] == math.inf
    assert not curve.is_ranked
    for threshold, fp in zip(curve.threshold, curve.fp, strict=True):
        at_it = operating_point(dataset, "x", Params(), threshold=float(threshold))
        assert fp == at_it.n_false_alarms


def test_a_constant_score_is_one_point_and_no_curve():
    boxes = [at(f, 50, score=1) for f in range(3)]
    curve = detection_curve(make_dataset([at(f, 50) for f in range(4)], boxes), "x", Params())
    assert (curve.threshold.tolist(), curve.tp.tolist()) == ([1], [3])
    assert curve.why_undefined == "no scores differ: there is a point, but no curve"
    alone = detection_curve(make_dataset([at(0, 50)], boxes[:1]), "x", Params())
    assert alone.why_undefined is None  # one detection is in order


def test_few_mixed_scores_are_all_points():
    boxes = [at(0, 50, score=0.9), at(1, 50), at(2, 50, score=0.3)]
    curve = detection_curve(make_dataset([at(f, 50) for f in range(3)], boxes), "x", Params())
    assert curve.threshold.tolist() == [math.inf, 0.9, 0.3]
    assert curve.tp.tolist() == [1, 2, 3]


def test_without_detections_there_is_no_point_but_an_operating_point():
    curve = detection_curve(make_dataset([at(0, 50)]), "x", Params())
    assert len(curve) == 0
    assert curve.why_undefined is None
    assert (curve.at(None).tp, curve.at(None).fn, curve.at(0.5).recall) == (0, 1, 0.0)
    assert list(curve_table(curve)) == list(CURVE_COLUMNS)


def test_without_pedestrians_recall_and_f1_are_undefined():
    curve = detection_curve(make_dataset([], [at(0, 50, score=0.5)]), "x", Params())
    assert curve.why_undefined == "no box of the truth counts under this protocol"
    assert np.isnan([*curve.recall, *curve.miss_rate, *curve.f1]).all()
    assert curve.precision.tolist() == [0]
    assert curve.fppi.tolist() == [1]


def test_a_mask_of_recordings_leaves_out_their_frames_truth_and_detections():
    dataset = random_dataset(9)
    whole = detection_outcomes(dataset, "x", Params())
    for i in (0, 1):
        chosen = np.arange(2) == i
        curve = detection_curve(dataset, "x", Params(), recordings=chosen)
        assert curve.n_truth == whole.n_truth[i]
        assert curve.n_images == whole.n_images[i] == 20
        is_here = whole.recording == i
        assert curve.tp[-1] == np.count_nonzero(whole.is_match & is_here)
        assert curve.fp[-1] == np.count_nonzero(~whole.is_match & is_here)


def test_infinite_scores_are_scores():
    boxes = [Box(0, 0, 0, 10, 10, score=s) for s in (math.inf, math.inf, -math.inf)]
    curve = detection_curve(make_dataset([(0, 0, 0, 10, 10)], boxes), "x", Params())
    assert curve.threshold.tolist() == [math.inf, -math.inf]
    assert (curve.tp.tolist(), curve.fp.tolist()) == ([1, 1], [1, 2])
