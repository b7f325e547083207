"""What is in a box: two kinds of discs are told apart, and nothing odd gets a class."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from nvcore.subjects.detectors.base import Detections, DetectorError
from nvcore.subjects.detectors.classifier import (
    N_VALUES,
    SIDE,
    Classifier,
    box_content,
    describe,
    train_classifier,
)


def barred(seed: int) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """A picture with an upright bar on its left and a lying one on its right, in boxes of 40 px."""
    rng = np.random.default_rng(seed)
    picture = rng.integers(90, 110, (80, 140, 3), dtype=np.uint8)
    x, y = (int(value) for value in rng.integers(-3, 4, 2))
    cv2.rectangle(picture, (36 + x, 22 + y), (44 + x, 58 + y), (230, 230, 230), -1)
    cv2.rectangle(picture, (82 + x, 36 + y), (118 + x, 44 + y), (230, 230, 230), -1)
    boxes = np.array([[20.0 + x, 20.0 + y, 40, 40], [80.0 + x, 20.0 + y, 40, 40]])
    return picture, boxes, ("100", "30")


@pytest.fixture(scope="module")
def bars() -> Classifier:
    classifier = train_classifier([barred(seed) for seed in range(6)], seed=1)
    assert classifier is not None
    return classifier


def test_classes_stand_in_the_order_of_their_numbers(bars):
    assert bars.classes == ("30", "100")
    assert bars.weights.shape == (N_VALUES + 1, 2)


def test_what_it_was_not_trained_on_is_told_apart(bars):
    for seed in range(100, 110):
        picture, boxes, labels = barred(seed)
        probabilities = bars.probabilities(picture, boxes)
        assert [bars.classes[i] for i in probabilities.argmax(axis=1)] == [*labels]
        np.testing.assert_allclose(probabilities.sum(axis=1), 1)


def test_each_detection_gets_its_class(bars):
    picture, boxes, labels = barred(50)
    x, y, w, h = boxes.T
    assert bars.labels(picture, Detections(x, y, w, h, np.ones(2))).tolist() == [*labels]
    nothing = Detections(*(np.empty(0) for _ in range(5)))
    assert bars.labels(picture, nothing).tolist() == []


def test_grey_and_16_bits_are_as_good(bars):
    picture, boxes, labels = barred(51)
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
    for same in (grey, grey.astype(np.uint16) * 200):
        best = bars.probabilities(same, boxes).argmax(axis=1)
        assert [bars.classes[i] for i in best] == [*labels]


def test_the_same_examples_and_seed_give_the_same_classifier(bars):
    again = train_classifier([barred(seed) for seed in range(6)], seed=1)
    np.testing.assert_array_equal(again.weights, bars.weights)


def test_the_offset_alone_decides_where_all_else_weighs_nothing():
    weights = np.zeros((N_VALUES + 1, 2))
    weights[-1] = np.log([1, 3])
    probabilities = Classifier(("a", "b"), weights).probabilities(*barred(1)[:2])
    np.testing.assert_allclose(probabilities, [[0.25, 0.75]] * 2)


def test_boxes_of_one_class_or_of_none_need_no_classifier():
    picture, boxes, _ = barred(0)
    assert train_classifier([(picture, boxes, ("30", "30"))]) is None
    assert train_classifier([(picture, boxes, ("30", ""))]) is None
    assert train_classifier([]) is None


def test_a_class_for_each_box_is_expected():
    picture, boxes, _ = barred(0)
    with pytest.raises(DetectorError, match="2 boxes and 1 classes"):
        train_classifier([(picture, boxes, ("30",))])


def test_more_classes_than_a_model_can_have_are_refused():
    picture, boxes, _ = barred(0)
    examples = [(picture, boxes[:1], (str(number),)) for number in range(101)]
    with pytest.raises(DetectorError, match="at most 100"):
        train_classifier(examples)


@pytest.mark.parametrize("box", [(-30, -30, 40, 40), (500, 500, 40, 40), (5.4, 5.4, 0.2, 0.2)])
def test_a_box_beyond_the_picture_repeats_its_edge(box):
    content = box_content(np.full((50, 50), 100, np.uint8), np.array(box, float))
    assert content.shape == (SIDE, SIDE)
    assert len(np.unique(content)) == 1


def test_a_descriptor_ends_with_the_offset():
    values = describe([np.zeros((SIDE, SIDE), np.uint8)])
    assert values.shape == (1, N_VALUES + 1)
    assert values[0, -1] == 1
    assert not values[0, :-1].any()
