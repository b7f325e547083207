"""Mistakes of other evaluation tools in curves that must not happen here."""

from __future__ import annotations

import pytest
from builders import Box, at, make_dataset

from nvcore.dataset import Dataset
from nvcore.metrics.detection.average_precision import average_precision, average_precision_coco
from nvcore.metrics.detection.curves import DetectionCurve, detection_curve
from nvcore.metrics.detection.miss_rate import log_average_miss_rate, miss_rate_at
from nvcore.settings.params import Params


def curve(dataset: Dataset, system: str = "x") -> DetectionCurve:
    return detection_curve(dataset, system, Params())


def people(n: int) -> list[Box]:
    return [at(f, 50, track=f) for f in range(n)]


def detections(*frames: int, centre: float = 50, score: float = 0.9) -> list[Box]:
    return [at(f, centre, score=score) for f in frames]


def test_pedestrians_in_frames_without_detections_are_missed() -> None:
    # a detector silent on half of 200 frames had recall 1.0 and miss rate 0
    found = [box._replace(score=1 - box.frame / 1000) for box in detections(*range(0, 200, 2))]
    ours = curve(make_dataset(people(200), found))
    assert ours.recall[-1] == 0.5
    assert log_average_miss_rate(ours) == pytest.approx(0.5)


@pytest.mark.parametrize("empty", [0, 1, 2])
def test_the_place_of_an_empty_frame_does_not_matter(empty: int) -> None:
    # the result depended on the order of empty pictures
    full = [f for f in range(3) if f != empty]
    ours = curve(make_dataset([at(f, 50) for f in full], detections(full[0]), n_frames=3))
    assert (ours.n_truth, ours.n_images, ours.tp.tolist()) == (2, 3, [1])
    assert average_precision(ours) == 0.5


@pytest.mark.parametrize("n_frames", [10, 50, 99])
def test_short_recordings_whose_best_score_is_wrong_find_nobody_at_low_fppi(n_frames: int) -> None:
    # index -1 read the end of the curve, so recall 1.0 was reported at every FPPI from 0.01
    wrong = [at(0, 10, score=1.0)]
    ours = curve(make_dataset(people(n_frames), [*wrong, *detections(*range(n_frames))]))
    below = 0.999 / n_frames
    assert miss_rate_at(ours, [0.01, below]).tolist() == [1.0, 1.0]
    assert miss_rate_at(ours, 1 / n_frames).item() == 0.0


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_detections_are_taken_by_score_not_by_file_order(order: list[int]) -> None:
    # the same two boxes gave 1.0 or 0.5 when exchanged in the file
    boxes = [Box(0, 0, 0, 10, 10, score=0.9), Box(0, 3, 0, 10, 10, score=0.2)]
    ours = curve(make_dataset([(0, 0, 0, 10, 10, 1)], [boxes[i] for i in order]))
    assert average_precision(ours) == 1.0
    assert average_precision_coco(ours) == pytest.approx(1.0)


def test_a_detected_ignored_pedestrian_is_no_false_positive() -> None:
    # its detection was a false positive, and it was a miss
    truth = [at(0, 20), at(0, 70, ignore=True)]
    boxes = [*detections(0, centre=70, score=1.0), *detections(0, centre=20)]
    ours = curve(make_dataset(truth, boxes))
    assert average_precision(ours) == 1.0
    assert ours.n_truth == 1


def test_the_number_of_pedestrians_does_not_depend_on_the_system() -> None:
    # crowds that one system matched several times were counted for it
    truth = [*people(4), *(Box(f, 60, 0, 40, 40, ignore=True) for f in range(4))]
    many = [Box(f, 60 + 8 * i, 5, 10, 10, score=0.5) for f in range(4) for i in range(4)]
    dataset = make_dataset(truth, detections(*range(4)), many)
    assert [curve(dataset, name).n_truth for name in "xy"] == [4, 4]
    assert len(curve(dataset, "y")) == 0  # all on the regions
