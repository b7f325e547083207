from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from builders import Box, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics.matching import Matches, count_per_frame, match_system
from nvcore.params import Params


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


def test_an_ignored_pedestrian_is_never_matched() -> None:
    dataset = make_dataset([Box(0, 0, 0, 10, 10, 1, ignore=True)], [(0, 0, 0, 10, 10)])
    result = matches(dataset)
    assert result.is_matched.tolist() == [False]
    assert result.is_counted.tolist() == [False]
    assert result.is_false_alarm.tolist() == [False]


def test_a_match_goes_before_absorption() -> None:
    truth = [Box(0, 0, 0, 10, 10, 1), Box(0, 0, 0, 50, 50, ignore=True)]
    result = matches(make_dataset(truth, [(0, 0, 0, 10, 10)]))
    assert result.is_matched.tolist() == [True, False]


def test_one_ignore_region_absorbs_any_number_of_detections() -> None:
    dataset = make_dataset([Box(0, 0, 0, 50, 50, ignore=True)], [(0, i, 0, 9, 9) for i in range(6)])
    assert not matches(dataset).is_counted.any()


def test_the_parts_on_two_ignore_regions_are_not_added_up() -> None:
    truth = [Box(0, 0, 0, 10, 10, ignore=True), Box(0, 16, 0, 10, 10, ignore=True)]
    dataset = make_dataset(truth, [(0, 6, 0, 14, 10)])  # 4/14 on the one, 4/14 on the other
    assert matches(dataset).is_false_alarm.tolist() == [True]


@pytest.mark.parametrize(("apart", "is_matched"), [(5, True), (5.5, False)])
def test_half_the_pedestrians_width_is_always_allowed_laterally(
    apart: float, is_matched: bool
) -> None:
    dataset = make_dataset([at(0, 50, w=10)], [at(0, 50 + apart, h=5, foot=7)])
    assert matches(dataset, match="lateral").is_matched.tolist() == [is_matched]


@pytest.mark.parametrize(("apart", "is_matched"), [(8, True), (8.5, False)])
def test_the_lateral_tolerance_is_a_share_of_the_width(apart: float, is_matched: bool) -> None:
    dataset = make_dataset([at(0, 50)], [at(0, 50 + apart)])
    result = matches(dataset, match="lateral", lateral_tolerance=0.08)
    assert result.is_matched.tolist() == [is_matched]


def test_ignore_regions_absorb_after_lateral_matching_too() -> None:
    dataset = make_dataset([at(0, 50), at(0, 90, w=20, ignore=True)], [at(0, 50), at(0, 90)])
    result = matches(dataset, match="lateral")
    assert result.is_counted.tolist() == [True, False]


def test_frames_do_not_see_each_others_boxes() -> None:
    dataset = make_dataset([(0, 0, 0, 10, 10, 1)], [(1, 0, 0, 10, 10)])
    assert not matches(dataset).is_matched.any()


def test_without_truth_every_detection_is_a_false_alarm() -> None:
    result = matches(make_dataset(x=[(0, 0, 0, 5, 5), (3, 0, 0, 5, 5)]))
    assert result.is_false_alarm.all()
    assert result.truth_det.size == 0


def test_without_detections_nothing_is_matched() -> None:
    result = matches(make_dataset([(0, 0, 0, 5, 5, 1)]))
    assert result.state.size == 0
    assert result.truth_det.tolist() == [-1]


def test_a_dataset_without_frames_has_no_matches() -> None:
    result = matches(make_dataset())
    assert result.state.size == result.truth_det.size == 0


def test_members_are_counted_in_every_frame() -> None:
    truth = make_dataset([(0, 0, 0, 5, 5, 1), (0, 9, 0, 5, 5, 2), (2, 0, 0, 5, 5, 1)]).truth
    assert count_per_frame(truth, np.array([True, True, True])).tolist() == [2, 0, 1]
    assert count_per_frame(truth, np.array([True, False, False])).tolist() == [1, 0, 0]
