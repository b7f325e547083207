"""Training: repeatable, with hard background, stopped on request, clear about what is missing."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import CancelledError
from dataclasses import replace

import numpy as np
import pytest

from nvcore.dataset.provenance import TrainedOn
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.icf import IcfDetector, IcfSettings, Scene, train
from nvcore.subjects.detectors.icf.channels import check_picture, levels, planes_of
from nvcore.subjects.detectors.icf.features import draw_features
from nvcore.subjects.detectors.icf.model import from_bytes, to_bytes
from nvcore.subjects.detectors.icf.windows import (
    is_background,
    level_values,
    object_windows,
    window_values,
)


def quick(settings: IcfSettings) -> IcfSettings:
    return replace(settings, features=100, trees_per_round=(4, 8), negatives=100)


def as_bytes(scenes: Sequence[Scene], settings: IcfSettings, seed: int = 1) -> bytes:
    return to_bytes(train(scenes, settings, name="d", label="disc", seed=seed))


def test_scenes_settings_and_seed_decide_the_model(drawn, settings, monkeypatch):
    scenes = [drawn(i) for i in range(12)]
    small = quick(settings)
    first = as_bytes(scenes, small)
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    assert as_bytes(scenes, small) == first
    assert as_bytes(scenes, small, seed=2) != first
    assert as_bytes(scenes[1:], small) != first


def test_a_model_notes_what_it_was_trained_on(drawn, settings):
    scenes = [drawn(i) for i in range(12)]
    known = {"name": "d", "label": "disc"}
    digest = [train(scenes[:n], quick(settings), **known).trained_on for n in (12, 12, 11)]
    assert digest[0] == digest[1] != digest[2]
    part = TrainedOn("0" * 64, "drive", 0, 9)
    assert train(scenes, quick(settings), **known, trained_on=[part]).trained_on == (part,)


def test_labels_of_several_classes_give_the_model_a_classifier(drawn, settings):
    known = {"name": "d", "label": "disc"}
    scenes = [replace(drawn(i), labels=("left", "right")) for i in range(12)]
    model = train(scenes, quick(settings), **known)
    assert model.labels == ("left", "right")
    plain = train([drawn(i) for i in range(12)], quick(settings), **known)
    assert plain.classifier is None
    assert plain.trained_on != model.trained_on
    alike = [replace(scene, labels=("disc", "")) for scene in scenes]
    assert train(alike, quick(settings), **known).classifier is None


def test_hard_background_is_added_between_rounds(drawn, settings):
    scenes = [drawn(i) for i in range(12)]
    few = replace(quick(settings), negatives=12)
    n = [
        train(scenes, replace(few, negatives_per_round=most), name="d", label="disc")
        for most in (0, 15, 200)
    ]
    assert n[1].n_background == n[0].n_background + 15
    assert n[2].n_background > n[1].n_background
    assert [len(model.trees) for model in n] == [8, 8, 8]


def test_windows_are_told_apart_at_the_end(model, settings):
    assert len(model.trees) == settings.trees_per_round[-1]
    assert model.round_ends.tolist() == [12, 60]
    assert model.error[-1] == 0


def test_without_hard_background_only_the_last_round_is_run(drawn, settings):
    scenes = [drawn(i) for i in range(12)]
    alone = replace(quick(settings), negatives_per_round=0)
    model = train(scenes, alone, name="d", label="disc", seed=1)
    assert model.round_ends.tolist() == [8]
    both = as_bytes(scenes, replace(alone, trees_per_round=(8,)))
    assert from_bytes(both, "").trees.leaves.tolist() == model.trees.leaves.tolist()


def test_only_the_features_that_trees_use_are_kept(model):
    used = np.unique(model.trees.feature)
    np.testing.assert_array_equal(used, np.arange(len(model.features)))


def test_crops_are_no_background_and_scenes_may_have_no_object(drawn, settings):
    crops = []
    for i in range(12):
        scene = drawn(i, n_discs=1)
        x, y, w, h = scene.boxes[0].astype(int)
        part = scene.picture[max(y - 4, 0) : y + h + 4, max(x - 4, 0) : x + w + 4]
        box = np.array([[x - max(x - 4, 0), y - max(y - 4, 0), w, h]], float)
        crops.append(Scene(part, box, has_background=False))
    scenes = [drawn(i, n_discs=0) for i in range(20, 26)]
    model = train([*crops, *scenes], settings, name="d", label="disc", held_out=crops)
    detector = IcfDetector(model)
    assert sum(len(detector.detect(drawn(i).picture)) for i in range(50, 54)) >= 6
    assert model.band.holds(np.array([0.5]), 0.1).all()  # crops say nothing of places


def test_training_may_be_cancelled_and_tells_what_it_does(drawn, settings):
    scenes = [drawn(i) for i in range(10)]
    seen: list[tuple[float, str]] = []
    train(scenes, quick(settings), name="d", label="disc", progress=lambda *p: seen.append(p))
    shares = [share for share, _ in seen]
    assert shares == sorted(shares)
    assert shares[0] == 0
    assert shares[-1] < 1
    for wish in {what for _, what in seen}:

        def stop(_share: float, what: str, wish: str = wish) -> None:
            if what == wish:
                raise CancelledError

        with pytest.raises(CancelledError):
            train(scenes, quick(settings), name="d", label="disc", progress=stop)


def test_a_training_needs_both_kinds_of_windows(drawn, settings):
    known = {"name": "d", "label": "disc"}
    crop = Scene(drawn(0).picture, drawn(0).boxes, has_background=False)
    with pytest.raises(DetectorError, match="no object"):
        train([drawn(0, n_discs=0)], settings, **known)
    with pytest.raises(DetectorError, match="no background"):
        train([crop, crop], settings, **known)
    with pytest.raises(DetectorError, match="calibrate"):
        train([drawn(0)], quick(settings), **known)


def test_grey_pictures_give_a_grey_model_that_works_on_all(drawn, settings):
    def grey(scene: Scene) -> Scene:
        return replace(scene, picture=check_picture(scene.picture, False))

    scenes = [grey(drawn(i)) for i in range(15)]
    model = train(scenes, settings, name="d", label="disc")
    assert not model.is_colour
    assert model.channels[:2] == ("grey", "gradient")
    detector = IcfDetector(model)
    boxes = detector.detect(grey(drawn(60)).picture)
    wide = np.repeat(grey(drawn(60)).picture[..., None], 3, axis=2)
    np.testing.assert_allclose(detector.detect(wide).score, boxes.score)
    in_three = [replace(s, picture=np.repeat(s.picture[..., None], 3, axis=2)) for s in scenes]
    assert not train(in_three, quick(settings), name="d", label="disc").is_colour


def test_a_window_that_is_cut_out_is_that_of_the_pyramid(drawn, settings):
    # at scale 1, where nothing is interpolated, a box of the object's size on a whole pixel
    picture = drawn(3).picture
    features = draw_features(settings, 10, seed=0)
    (group,) = levels(160, 120, replace(settings, scales=(1.0,), copies=0))
    row, column = np.array([5]), np.array([9])
    of_level = level_values(picture, group[0], row, column, settings, features)
    box = group[0].boxes(row, column, settings)[:, 0]
    (window,) = object_windows(picture, box, replace(settings, copies=0), np.random.default_rng(0))
    np.testing.assert_array_equal(window_values([window], settings, features), of_level)


def test_copies_are_moved_scaled_and_mirrored(drawn, settings):
    scene = drawn(3)
    more = replace(settings, copies=4, mirrored=True, least_object_px=10.0)
    windows = object_windows(scene.picture, scene.boxes[0], more, np.random.default_rng(0))
    assert [window.shape for window in windows] == [(32, 32, 3)] * 5
    assert len({window.tobytes() for window in windows}) == 5


def test_copies_lose_detail_down_to_the_least_height(settings):
    picture = np.indices((90, 90)).sum(axis=0) // 2 % 2 * 255
    box = np.array([25.0, 25, 40, 40])
    rng = np.random.default_rng(0)
    more = replace(settings, copies=40, least_object_px=5.0)
    _whole, *copies = object_windows(picture.astype(np.uint8), box, more, rng)
    assert min(copy.std() for copy in copies) < 0.3 * max(copy.std() for copy in copies)


def test_a_box_at_or_beyond_the_edge_repeats_the_edge(settings):
    picture = np.tile(np.arange(50, dtype=np.uint8), (40, 1))
    rng = np.random.default_rng(0)
    for x, level in ((-300.0, 0), (400.0, 49)):
        box = np.array([x, 10, 20, 20])
        (window,) = object_windows(picture, box, replace(settings, copies=0), rng)
        assert (window == level).all()


def test_background_lies_apart_from_objects_and_outside_what_is_ignored():
    boxes = np.array([[0.0, 40, 5, 100], [0, 0, 0, 0], [20, 20, 20, 20], [20, 20, 20, 20]])
    scene = Scene(
        np.zeros((9, 9), np.uint8), np.array([[0.0, 0, 20, 20]]), np.array([[95.0, 0, 200, 200]])
    )
    assert is_background(boxes, scene).tolist() == [False, True, False, False]


def test_channels_of_a_scale_can_be_made_from_another(drawn, model):
    near = model.run_with(scales_between=1)
    picture = drawn(7).picture
    exact, close = (IcfDetector(m).score_maps(picture) for m in (model, near))
    assert [m.level.scale for m in exact] == [m.level.scale for m in close]
    np.testing.assert_array_equal(exact[0].depth, close[0].depth)
    assert (exact[1].depth != close[1].depth).any()
    groups = levels(160, 120, near.settings)
    assert [len(group) for group in groups] == [2, 2, 1]
    planes = dict(planes_of(picture, groups[0], near.settings, model.powers))
    expected = [(m.level.height, m.level.width) for m in close[:2]]
    assert [p.shape[1:] for p in planes.values()] == expected
