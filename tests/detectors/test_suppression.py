"""Boxes go where a more confident one overlaps them; scores are kept."""

from __future__ import annotations

import numpy as np
import pytest

from nvcore.subjects.detectors.suppression import sorted_detections, staying_boxes, suppress

BOXES = np.array([[0, 0, 10, 10], [5, 0, 10, 10], [100, 0, 10, 10], [0, 0, 10, 10]], float)
SCORES = np.array([0.5, 0.9, 0.1, 0.2])


def test_the_most_confident_come_first_and_equal_ones_by_place():
    detections = sorted_detections(BOXES, np.array([1.0, 2.0, 1.0, 1.0]))
    assert detections.x.tolist() == [5, 0, 0, 100]


def test_an_overlap_of_1_keeps_all_even_doubles():
    assert len(suppress(sorted_detections(BOXES, SCORES), 1.0)) == 4


def test_an_overlap_of_0_keeps_boxes_that_only_touch():
    box = np.array([[0, 0, 10, 10], [10, 0, 10, 10]], float)
    assert len(suppress(sorted_detections(box, np.array([1.0, 2.0])), 0.0)) == 2


def test_labels_do_not_suppress_each_other():
    label = np.array(["a", "b", "a", "a"], dtype=object)
    detections = suppress(sorted_detections(BOXES, SCORES, label), 0.3)
    assert detections.label is not None
    assert detections.label.tolist() == ["b", "a", "a"]


@pytest.mark.parametrize("n", [0, 1])
def test_nothing_and_one_box_stay(n: int):
    assert len(suppress(sorted_detections(BOXES[:n], SCORES[:n]), 0.0)) == n


# IoU of the second with the first 80/120 = 0.67, of the third with the second the same, of the
# third with the first 60/140 = 0.43; the fourth lies within the first, a quarter of it
ROW = np.array([[0.0, 2, 4, 1], [0, 0, 0, 1], [10, 10, 10, 5], [10, 10, 10, 5]])


@pytest.mark.parametrize(
    ("overlap", "of", "expected"),
    [
        (0.5, "union", [0, 2, 3]),  # the second, which goes, does not suppress the third
        (0.4, "union", [0, 3]),
        (0.5, "smaller", [0]),
        (0.7, "union", [0, 1, 2, 3]),
        (1.0, "smaller", [0, 1, 2, 3]),
    ],
)
def test_the_less_confident_of_two_overlapping_boxes_goes(overlap, of, expected):
    assert np.flatnonzero(staying_boxes(ROW, overlap, of)).tolist() == expected


@pytest.mark.parametrize(
    ("of", "second"), [("union", [0.0, 0, 10, 5]), ("smaller", [5.0, 0, 10, 10])]
)
def test_a_box_goes_by_more_than_the_overlap_and_not_by_just_that(of, second):
    box = np.array([[0.0, 0, 10, 10], second]).T  # they share 50 px², just a half
    assert staying_boxes(box, 0.5, of).tolist() == [True, True]
    assert staying_boxes(box, 0.49, of).tolist() == [True, False]
