"""Threshold and overlap moved on boxes that are kept give what the detector gives."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from onnx_models import blob_model

from nvcore.subjects.detectors.candidates import (
    candidates,
    counting,
    open_loosened,
    usual_threshold,
)
from nvcore.subjects.detectors.icf.settings import OF_A_RUN
from nvcore.subjects.detectors.registry import open_detector, run_settings
from nvcore.subjects.detectors.suppression import only


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    """A scene with a person of rectangles, and noise."""
    rng = np.random.default_rng(1)
    scene = cv2.GaussianBlur(rng.integers(0, 160, (240, 320), dtype=np.uint8), (5, 5), 0)
    cv2.ellipse(scene, (150, 70), (12, 14), 0, 0, 360, 230, -1)
    cv2.rectangle(scene, (132, 84), (168, 150), 210, -1)
    cv2.rectangle(scene, (136, 150), (147, 215), 190, -1)
    cv2.rectangle(scene, (153, 150), (164, 215), 190, -1)
    return scene


@pytest.mark.parametrize("overlap", [0.0, 0.3, 0.5, 1.0])
@pytest.mark.parametrize("threshold", [-1.5, -1.0, -0.5])
def test_hog_gives_the_boxes_that_count(picture: np.ndarray, threshold: float, overlap: float):
    boxes = candidates(open_loosened("hog:daimler"), picture, most=10**6)
    own = open_detector("hog:daimler", {"hit_threshold": threshold, "overlap": overlap})
    is_counting = counting(boxes, own.about, threshold=threshold, overlap=overlap)
    counted, expected = only(boxes, is_counting), own.detect(picture)
    assert len(expected) > 0
    np.testing.assert_array_equal(counted.score, expected.score)
    np.testing.assert_array_equal(counted.x, expected.x)


def test_a_network_gives_the_boxes_that_count(picture: np.ndarray, tmp_path: Path):
    path = blob_model(tmp_path / "blob.onnx")
    boxes = candidates(open_loosened(path), picture)
    own = open_detector(path, {"threshold": 0.4, "overlap": 0.2})
    is_counting = counting(boxes, own.about, threshold=0.4, overlap=0.2)
    expected = own.detect(picture)
    assert 0 < len(expected) < len(boxes)
    np.testing.assert_array_equal(only(boxes, is_counting).score, expected.score)
    assert usual_threshold(open_detector(path).about) == 0.25


def test_the_most_confident_candidates_are_kept(picture: np.ndarray):
    detector = open_loosened("hog")
    every, few = candidates(detector, picture, most=10**6), candidates(detector, picture, most=5)
    np.testing.assert_array_equal(few.score, every.score[:5])
    assert (np.diff(every.score) <= 0).all()


def test_without_a_threshold_of_its_own_that_of_the_settings_is_usual():
    assert usual_threshold(open_detector("hog", {"hit_threshold": 0.25}).about) == 0.25


def test_every_setting_of_a_run_is_known():
    assert set(run_settings(open_detector("hog").about)) >= {"overlap", "hit_threshold"}
    of_icf = run_settings(open_detector("icf:sample").about)
    assert set(of_icf) == OF_A_RUN
    assert (of_icf["stride"].low, of_icf["stride"].high) == (1, 256)
    assert all(facts.meaning.endswith(".") for facts in of_icf.values())
