"""What the model sees and how it decides."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nvcore.common.errors import ParameterError
from nvcore.subjects.detectors.icf import IcfDetector
from nvcore.subjects.detectors.icf.channels import channel_planes
from nvcore.subjects.detectors.icf.displays import (
    channels_of,
    coarse_map,
    computed_scale,
    map_at,
    preparation,
    rejected_paths,
    tree,
    truth_paths,
    usable_scales,
    window_of,
    window_path,
)


def test_the_picture_is_shown_before_and_after_each_step(model, drawn):
    more = replace(model, settings=replace(model.settings, clahe_clip=4.0))
    steps = preparation(more, drawn(0).picture, 1.0)
    whole, smooth, equalised = steps.values()
    np.testing.assert_array_equal(whole, drawn(0).picture)
    assert smooth.std() < whole.std()
    assert (equalised != smooth).any()
    plain = preparation(model, drawn(0).picture, 2.0)
    assert {name: step.shape for name, step in plain.items()} == dict.fromkeys(
        ("as it comes", "after the blur"), (60, 80, 3)
    )


def test_channels_are_shown_by_name(model, drawn):
    planes = channels_of(model, drawn(0).picture, 1.0)
    assert tuple(planes) == model.channels
    expected = channel_planes(drawn(0).picture, model.settings)
    np.testing.assert_array_equal(np.stack(list(planes.values())), expected)


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
        (score_map,) = [candidate for candidate in maps if candidate.level.scale == scale]
        assert score_map.score[row, column] == boxes.score[k]
    with pytest.raises(ParameterError, match="at every scale"):
        window_of(model, 10, 10, (0.0, 0.0, 10.0))


def test_displays_show_the_channels_that_a_run_approximates(model, drawn):
    picture, run = drawn(3).picture, model.run_with(scales_between=2)
    assert [computed_scale(run, picture, scale) for scale in (0.9, 1.1, 1.2)] == [0.9, 0.9, 1.2]
    maps = {score_map.level.scale: score_map for score_map in IcfDetector(run).score_maps(picture)}
    for scale in (0.9, 1.1, 1.2):
        alone = map_at(run, picture, scale)
        np.testing.assert_array_equal(alone.score, maps[scale].score)
        row, column = np.argwhere(maps[scale].depth > 1)[0]
        path = window_path(run, picture, scale, int(row), int(column))
        assert (path.rejected_after or len(run.trees)) == maps[scale].depth[row, column]
    exact, close = (channels_of(each, picture, 1.1)["gradient"] for each in (model, run))
    assert (exact != close).any()


def test_of_a_coarse_map_the_highest_of_each_cell_is_kept(model, drawn):
    whole = IcfDetector(model).score_maps(drawn(3).picture)[0]
    coarse = coarse_map(whole, most=10)
    assert max(coarse.score.shape) <= 10
    assert coarse.depth[0, 0] == whole.depth[: coarse.step, : coarse.step].max()
    assert np.nanmax(coarse.score) == np.nanmax(whole.score)
    assert (coarse.n_windows, coarse.n_features) == (whole.n_windows, whole.n_features)
    assert coarse.n_through == np.isfinite(whole.score).sum()


def test_scales_are_those_that_hold_a_window(model, drawn):
    assert usable_scales(model.settings, 160, 120) == model.settings.scales
    assert usable_scales(model.settings, 26, 30) == (0.9, 1.0)
    with pytest.raises(ParameterError, match="smaller than the window there"):
        map_at(model, drawn(0).picture[:30, :26], 1.35)


def test_objects_are_followed_over_the_trees_and_background_until_it_is_rejected(model, drawn):
    scene = drawn(3)
    tiny = np.array([[5.0, 5, 4, 4]])  # no window is as small
    objects = truth_paths(model, scene.picture, np.concatenate([scene.boxes, tiny]))
    assert len(objects) == len(scene.boxes) == 2
    assert all(path.confidence[-1] > 0 for path in objects)
    background = rejected_paths(model, scene.picture, scene.boxes, 1.0)
    ends = {path.rejected_after for path in background}
    assert 1 < len(ends) <= 6
    assert None not in ends
    assert min(ends) <= 3
