"""What the model sees and how it decides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.detectors.icf import IcfDetector
from nvcore.detectors.icf.channels import channel_planes
from nvcore.detectors.icf.displays import (
    approximation_error,
    channels_of,
    preparation,
    tree,
    window_of,
    window_path,
)
from nvcore.errors import ParameterError


def test_the_picture_is_shown_before_and_after_each_step(model, drawn):
    more = replace(model, settings=replace(model.settings, clahe_clip=4.0))
    steps = preparation(more, drawn(0).picture, 1.0)
    np.testing.assert_array_equal(steps.resized, drawn(0).picture)
    assert steps.blurred.std() < steps.resized.std()
    assert (steps.equalised != steps.blurred).any()
    plain = preparation(model, drawn(0).picture, 2.0)
    assert plain.equalised.shape == (60, 80, 3)


def test_channels_are_shown_by_name(model, drawn):
    planes = channels_of(model, drawn(0).picture, 1.0)
    assert tuple(planes) == model.channels
    expected = channel_planes(drawn(0).picture, model.settings)
    np.testing.assert_array_equal(np.stack(list(planes.values())), expected)


def test_channels_of_the_same_scale_are_not_approximated(model, drawn):
    picture = drawn(0).picture
    same = approximation_error(model, picture, 1.0, 1.0)
    near = approximation_error(model, picture, 1.1, 1.0)
    far = approximation_error(model, picture, 2.0, 1.0)
    assert set(same.values()) == {0.0}
    assert 0 < near["gradient"] < far["gradient"]


def test_the_leaves_of_a_path_add_up_to_its_confidence(model, drawn):
    path = window_path(model, drawn(0).picture, 1.0, 3, 5)
    leaves = model.trees.leaves[np.arange(len(model.trees)), path.leaf]
    np.testing.assert_allclose(leaves.cumsum(), path.confidence)
    np.testing.assert_array_equal(path.floor, np.minimum(model.calibration.trace, 0))


def test_a_tree_says_what_it_asks(model):
    shown = tree(model, 0)
    feature = model.features[model.trees.feature[0, 0]]
    assert shown.root.channel == model.channels[feature[0]]
    assert (shown.root.left, shown.root.bottom) == (feature[1], feature[4])
    assert 0 <= shown.root.threshold <= 1
    assert shown.root.minus is None
    assert shown.leaves == tuple(model.trees.leaves[0])


def test_a_difference_names_both_rectangles(model):
    features = model.features.copy()
    features[:, 5:] = features[:, :5]
    features[:, 5] = 1
    minus = tree(replace(model, features=features), 0).root.minus
    assert minus == ("U", *features[model.trees.feature[0, 0], 1:5])


def test_what_is_not_there_is_refused(model, drawn):
    picture = drawn(0).picture
    with pytest.raises(ParameterError, match="counted from 0"):
        tree(model, len(model.trees))
    with pytest.raises(ParameterError, match="rows of"):
        window_path(model, picture, 1.0, 99, 0)
    with pytest.raises(ParameterError, match="smaller than the window"):
        channels_of(model, picture, 9.0)


def test_score_maps_tell_windows_and_features(model, drawn):
    maps = IcfDetector(model).score_maps(drawn(0).picture)
    assert [m.n_windows for m in maps] == [m.score.size for m in maps]
    assert all(2 * m.n_windows <= m.n_features for m in maps)


def test_a_box_leads_back_to_its_window(model, drawn):
    picture = drawn(3).picture
    detector = IcfDetector(model)
    maps = detector.score_maps(picture)
    boxes = detector.candidates(maps)
    assert len(boxes) > 10
    for k in range(0, len(boxes), 5):
        box = boxes.x[k], boxes.y[k], boxes.w[k]
        scale, row, column = window_of(model, picture.shape[1], picture.shape[0], box)
        (score_map,) = [one for one in maps if one.level.scale == scale]
        assert score_map.score[row, column] == boxes.score[k]
    with pytest.raises(ParameterError, match="at every scale"):
        window_of(model, 10, 10, (0.0, 0.0, 10.0))
