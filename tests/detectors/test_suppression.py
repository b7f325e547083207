"""Boxes go where a more confident one overlaps them; scores are kept."""

from __future__ import annotations

import numpy as np
import pytest

from nvcore.detectors.suppression import sorted_detections, suppress

BOXES = np.array([[0, 0, 10, 10], [5, 0, 10, 10], [100, 0, 10, 10], [0, 0, 10, 10]], float)
SCORES = np.array([0.5, 0.9, 0.1, 0.2])


def test_the_most_confident_come_first_and_equal_ones_by_place():
    detections = sorted_detections(BOXES, np.array([1.0, 2.0, 1.0, 1.0]))
    assert detections.x.tolist() == [5, 0, 0, 100]


def test_a_box_above_the_overlap_goes():
    # boxes 0 and 1 share 50 of 150 px: an IoU of a third
    detections = sorted_detections(BOXES, SCORES)
    assert suppress(detections, 0.3).score.tolist() == [0.9, 0.1]
    assert suppress(detections, 0.4).score.tolist() == [0.9, 0.5, 0.1]


def test_an_overlap_of_1_keeps_all_even_doubles():
    assert len(suppress(sorted_detections(BOXES, SCORES), 1.0)) == 4


def test_an_overlap_of_0_keeps_boxes_that_only_touch():
    box = np.array([[0, 0, 10, 10], [10, 0, 10, 10]], float)
    assert len(suppress(sorted_detections(box, np.array([1.0, 2.0])), 0.0)) == 2


def test_a_box_that_went_suppresses_nobody():
    # the middle one goes by the first; the last overlaps the middle one alone
    box = np.array([[0, 0, 10, 10], [4, 0, 10, 10], [8, 0, 10, 10]], float)
    kept = suppress(sorted_detections(box, np.array([3.0, 2.0, 1.0])), 0.3)
    assert kept.x.tolist() == [0, 8]


def test_labels_do_not_suppress_each_other():
    label = np.array(["a", "b", "a", "a"], dtype=object)
    kept = suppress(sorted_detections(BOXES, SCORES, label), 0.3)
    assert kept.label is not None
    assert kept.label.tolist() == ["b", "a", "a"]


@pytest.mark.parametrize("n", [0, 1])
def test_nothing_and_one_box_stay(n: int):
    assert len(suppress(sorted_detections(BOXES[:n], SCORES[:n]), 0.0)) == n
