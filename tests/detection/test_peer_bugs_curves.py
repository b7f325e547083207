"""Mistakes of other evaluation tools in curves that must not happen here.

The numbers are those of the project's list of peers' bugs, section "Correctness bugs of metrics",
as in test_peer_bugs.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from builders import Box, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.detection.average_precision import average_precision, average_precision_coco, pr_auc
from nvcore.detection.curves import DetectionCurve, detection_curve
from nvcore.detection.miss_rate import log_average_miss_rate, miss_rate_at
from nvcore.params import Params


def curve(dataset: Dataset, system: str = "x") -> DetectionCurve:
    return detection_curve(dataset, system, Params())


def people(n: int) -> list[Box]:
    return [at(f, 50, track=f) for f in range(n)]


def found(*frames: int, centre: float = 50, score: float = 0.9) -> list[Box]:
    return [at(f, centre, score=score) for f in frames]


def test_pedestrians_in_frames_without_detections_are_missed() -> None:
    # 29: a detector silent on half of 200 frames had recall 1.0 and miss rate 0
    one = curve(make_dataset(people(200), found(*range(0, 200, 2))))
    assert one.recall.tolist() == [0.5]
    assert log_average_miss_rate(one) == pytest.approx(0.5)


def test_false_positives_in_frames_without_pedestrians_count() -> None:
    # 30: they were dropped
    one = curve(make_dataset([at(0, 50)], found(*range(5))))
    assert one.precision.tolist() == [1 / 5]
    assert one.fppi.tolist() == [4 / 5]
    assert average_precision_coco(one) == pytest.approx(1 / 5)


@pytest.mark.parametrize("empty", [0, 1, 2])
def test_the_place_of_an_empty_frame_does_not_matter(empty: int) -> None:
    # 30: the result depended on the order of empty pictures
    full = [f for f in range(3) if f != empty]
    one = curve(make_dataset([at(f, 50) for f in full], found(full[0]), n_frames=3))
    assert (one.n_truth, one.n_images, one.tp.tolist()) == (2, 3, [1])
    assert average_precision(one) == 0.5


@pytest.mark.parametrize("n_frames", [10, 50, 99])
def test_short_recordings_whose_best_score_is_wrong_find_nobody_at_low_fppi(n_frames: int) -> None:
    # 31: index -1 read the end of the curve, so recall 1.0 was reported at every FPPI from 0.01
    wrong = [at(0, 10, score=1.0)]
    one = curve(make_dataset(people(n_frames), [*wrong, *found(*range(n_frames))]))
    below = 0.999 / n_frames
    assert miss_rate_at(one, [0.01, below]).tolist() == [1.0, 1.0]
    assert miss_rate_at(one, 1 / n_frames).item() == 0.0


def test_current_numpy_computes_the_miss_rate() -> None:
    # 32: the published code calls what numpy no longer has
    one = curve(make_dataset(people(4), found(0, 1)))
    assert log_average_miss_rate(one) == pytest.approx(0.5)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_detections_are_taken_by_score_not_by_file_order(order: list[int]) -> None:
    # 33: the same two boxes gave 1.0 or 0.5 when exchanged in the file
    boxes = [Box(0, 0, 0, 10, 10, score=0.9), Box(0, 3, 0, 10, 10, score=0.2)]
    one = curve(make_dataset([(0, 0, 0, 10, 10, 1)], [boxes[i] for i in order]))
    assert average_precision(one) == 1.0
    assert average_precision_coco(one) == pytest.approx(1.0)


def test_misses_are_part_of_the_curve() -> None:
    # 33: the precision-recall curve forgot them
    one = curve(make_dataset(people(4), found(0)))
    assert average_precision(one) == 0.25
    assert pr_auc(one) == 0.25


def test_track_0_matched_by_row_0_is_found() -> None:
    # 34: id 0 meant "unmatched", and a perfect detection had AP 0
    one = curve(make_dataset([at(0, 50, track=0)], found(0)))
    assert average_precision_coco(one) == pytest.approx(1.0)


def test_an_ignored_pedestrian_is_no_miss() -> None:
    # 35: ignore was overwritten by iscrowd, and AP was 0.505
    truth = [at(0, 20), at(0, 70, ignore=True)]
    one = curve(make_dataset(truth, found(0, centre=20)))
    assert one.n_truth == 1
    assert average_precision_coco(one) == pytest.approx(1.0)


def test_a_detected_ignored_pedestrian_is_no_false_positive() -> None:
    # 33, 35
    truth = [at(0, 20), at(0, 70, ignore=True)]
    boxes = [*found(0, centre=70, score=1.0), *found(0, centre=20)]
    assert average_precision(curve(make_dataset(truth, boxes))) == 1.0


def test_an_empty_list_of_results_has_figures() -> None:
    # 36: it crashed
    one = curve(make_dataset(people(3)))
    assert [area(one) for area in (average_precision, average_precision_coco, pr_auc)] == [0, 0, 0]
    assert log_average_miss_rate(one) == 1.0


def test_the_number_of_pedestrians_does_not_depend_on_the_system() -> None:
    # 37: crowds that one system matched several times were counted for it
    truth = [*people(4), *(Box(f, 60, 0, 40, 40, ignore=True) for f in range(4))]
    many = [Box(f, 60 + 8 * i, 5, 10, 10, score=0.5) for f in range(4) for i in range(4)]
    dataset = make_dataset(truth, found(*range(4)), many)
    assert [curve(dataset, name).n_truth for name in "xy"] == [4, 4]
    assert len(curve(dataset, "y")) == 0  # all on the regions


def test_without_pedestrians_ap_is_undefined_not_1_or_minus_1() -> None:
    # 38
    one = curve(make_dataset([], found(0, 1)))
    figures = [average_precision(one), average_precision_coco(one), pr_auc(one),
               log_average_miss_rate(one)]  # fmt: skip
    assert np.isnan(figures).all()


def test_the_truth_as_a_system_is_perfect() -> None:
    # 44: the oracle test failed
    truth = [*people(5), *(Box(f, 3, 5, 8, 20) for f in range(5))]
    one = curve(make_dataset(truth, [box._replace(score=0.5) for box in truth]))
    assert average_precision(one) == average_precision_coco(one) == pr_auc(one) == 1.0
    assert log_average_miss_rate(one) == 0.0
    assert one.f1.tolist() == [1.0]
