from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import Box, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics.matching import Matches, iou_of_pairs, match_system
from nvcore.settings.params import Params


def matches(dataset: Dataset, *, threshold: float | None = None, **settings: Any) -> Matches:
    return match_system(dataset, "x", threshold, Params(**settings))


def test_an_iou_of_exactly_the_limit_matches() -> None:
    # 10 x 10 and its left half: 50 / 100
    dataset = make_dataset([(0, 0, 0, 10, 10, 1)], [(0, 0, 0, 5, 10)])
    assert matches(dataset).det_truth.tolist() == [0]
    assert matches(dataset, iou=0.501).det_truth.tolist() == [-1]


def test_every_detection_counts_without_a_threshold() -> None:
    dataset = make_dataset(x=[Box(0, 0, 0, 5, 10, score=-1e300), Box(0, 0, 0, 5, 10, score=0)])
    assert matches(dataset).is_counted.tolist() == [True, True]
    assert matches(dataset, threshold=0).is_counted.tolist() == [False, True]


def test_a_detection_without_a_score_passes_every_threshold() -> None:
    dataset = make_dataset(x=[Box(0, 0, 0, 5, 10)])
    assert matches(dataset, threshold=0.99).is_false_alarm.tolist() == [True]


def test_the_parts_on_two_ignore_regions_are_not_added_up() -> None:
    truth = [Box(0, 0, 0, 10, 10, ignore=True), Box(0, 16, 0, 10, 10, ignore=True)]
    dataset = make_dataset(truth, [(0, 6, 0, 14, 10)])  # 4/14 on the one, 4/14 on the other
    assert matches(dataset).is_false_alarm.tolist() == [True]


def test_a_dataset_without_frames_has_no_matches() -> None:
    result = matches(make_dataset())
    assert result.state.size == result.truth_det.size == 0


def test_half_a_detection_on_an_ignore_region_is_absorbed() -> None:
    truth = [Box(0, 0, 0, 50, 50, ignore=True)]
    x = [Box(0, 45, 0, 10, 10), Box(0, 45.1, 0, 10, 10)]
    assert matches(make_dataset(truth, x)).is_false_alarm.tolist() == [False, True]


@pytest.mark.parametrize(
    ("w", "tolerance", "apart", "is_matched"),
    [(10, 0, 5, True), (10, 0, 5.5, False), (2, 0.08, 8, True), (2, 0.08, 8.5, False)],
)
def test_laterally_half_the_pedestrians_width_is_allowed_or_a_share_of_the_picture(
    w: float, tolerance: float, apart: float, is_matched: bool
) -> None:
    dataset = make_dataset([at(0, 50, w=w)], [at(0, 50 + apart, h=5, foot=7)])
    result = matches(dataset, match="lateral", lateral_tolerance=tolerance)
    assert result.is_matched.tolist() == [is_matched]


def test_overlaps_are_broadcast_and_0_without_area() -> None:
    dataset = make_dataset([at(0, 50, w=4), at(0, 0, w=0, h=0)], [at(0, 52, w=4), at(0, 90)])
    x, y, w, h = (values[:, np.newaxis] for values in dataset.truth.xywh)
    overlaps = iou_of_pairs((x, y, w, h), dataset.system("x").xywh)
    np.testing.assert_allclose(overlaps, [[2 / 6, 0], [0, 0]])
    nothing = (np.zeros(1),) * 4
    assert iou_of_pairs(nothing, nothing).tolist() == [0]


def test_with_same_a_pedestrian_is_matched_by_its_own_class_alone() -> None:
    # the best box is of the other class, the looser one of the same: 30 is 0, 50 is 1
    truth = [Box(0, 0, 0, 10, 10, label=0)]
    x = [Box(0, 0, 0, 10, 10, score=0.9, label=1), Box(0, 0, 0, 8, 10, score=0.5, label=0)]
    dataset = make_dataset(truth, x, labels=("30", "50"))
    assert matches(dataset).det_truth.tolist() == [0, -1]
    same = matches(dataset, match_class="same")
    assert same.det_truth.tolist() == [-1, 0]
    assert same.is_false_alarm.tolist() == [True, False]
    laterally = matches(dataset, match_class="same", match="lateral", lateral_tolerance=0.5)
    assert laterally.det_truth.tolist() == [-1, 0]


def test_what_is_not_named_is_matched_by_any_and_names_nothing() -> None:
    truth = [Box(0, 0, 0, 10, 10), Box(0, 50, 0, 10, 10, label=0)]
    x = [Box(0, 0, 0, 10, 10, label=1), Box(0, 50, 0, 10, 10)]
    dataset = make_dataset(truth, x, labels=("30", "50"))
    assert matches(dataset, match_class="same").det_truth.tolist() == [0, -1]
    assert matches(dataset).det_truth.tolist() == [0, 1]
