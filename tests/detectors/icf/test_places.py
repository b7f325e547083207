"""Where windows are looked at."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.common.errors import ParameterError
from nvcore.subjects.detectors.icf import IcfDetector
from nvcore.subjects.detectors.icf.regions import (
    EVERYWHERE,
    Band,
    in_polygon,
    is_red,
    learn_band,
    red_sums,
)

TRIANGLE = (0.0, 0.0, 1.0, 0.0, 0.0, 1.0)


def test_a_polygon_holds_the_points_within():
    x, y = np.array([0.1, 0.6]), np.array([0.1, 0.6])
    assert in_polygon(x, y, TRIANGLE).tolist() == [[True, True], [True, False]]


def test_windows_are_looked_at_by_their_centres(drawn, model):
    right = model.run_with(region=(0.5, 0.0, 1.0, 0.0, 1.0, 1.0, 0.5, 1.0))
    for score_map in IcfDetector(right).score_maps(drawn(9).picture):
        settings, level = model.settings, score_map.level
        columns = np.arange(score_map.depth.shape[1])
        centre = (columns * settings.stride + settings.window_width / 2) * level.across
        np.testing.assert_array_equal(score_map.depth.any(axis=0), centre > 80)


def test_a_band_follows_the_boxes_of_the_training():
    height = np.linspace(0.1, 0.5, 20)
    row = 0.3 + 0.5 * height + 0.01 * (-1.0) ** np.arange(20)
    band = learn_band(row, height)
    assert band.slope == pytest.approx(0.5, abs=0.02)
    assert band.holds(row, 0.0).dtype == bool
    assert all(band.holds(row[i : i + 1], height[i])[0] for i in range(20))
    assert band.holds(np.array([0.3, 0.55, 0.8]), 0.5).tolist() == [False, True, False]


def test_few_boxes_or_those_of_one_height_give_no_band():
    assert learn_band(np.arange(9.0), np.arange(9.0)) == EVERYWHERE
    assert learn_band(np.arange(20.0), np.ones(20)) == EVERYWHERE


def test_the_band_is_used_only_if_wanted(drawn, model):
    narrow = replace(model, band=Band(0.5, 0.0, 0.1, 0.1))
    picture = drawn(9).picture
    whole, part = (
        IcfDetector(narrow.run_with(use_band=use)).score_maps(picture) for use in (False, True)
    )
    assert all(score_map.depth.all() for score_map in whole)
    for score_map in part:
        rows = np.arange(score_map.depth.shape[0])
        centre = (rows * 3 + 12) * score_map.level.down / 120
        np.testing.assert_array_equal(score_map.depth.any(axis=1), abs(centre - 0.5) <= 0.1)


def test_red_is_more_than_green_and_blue():
    pixels = np.array([[[200, 20, 20], [200, 190, 20], [20, 10, 10], [90, 90, 90]]], np.uint8)
    assert is_red(pixels).tolist() == [[True, False, False, False]]


def test_proposals_leave_only_windows_with_red(drawn, model):
    picture = drawn(9).picture
    detector = IcfDetector(model)
    red = detector.run_with(proposals="red", red_share=0.05)
    n = [sum(m.n_windows for m in d.score_maps(picture)) for d in (detector, red)]
    assert 0 < n[1] < 0.6 * n[0]
    assert len(red.detect(picture)) >= 2


def test_a_model_of_grey_pictures_refuses_proposals_by_colour(model):
    grey = IcfDetector(replace(model, is_colour=False))
    with pytest.raises(ParameterError, match="proposals: red is of pictures in colour"):
        grey.run_with(proposals="red")
    assert grey.run_with(proposals="none").about == grey.about


def test_a_grey_picture_has_no_proposals(settings):
    assert red_sums(np.zeros((50, 50), np.uint8), replace(settings, proposals="red")) is None
