"""Detection: which windows there are, what rejects them, which boxes stay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from nvcore.metrics.detection import WindowGrid, scale_steps
from nvcore.subjects.detectors.base import Detector, DetectorError
from nvcore.subjects.detectors.candidates import candidates, counting, open_loosened
from nvcore.subjects.detectors.icf import AS_IN_REPORT, IcfDetector, write_model
from nvcore.subjects.detectors.icf.cascade import Calibration, calibrate, floors, lower, passes
from nvcore.subjects.detectors.icf.channels import levels
from nvcore.subjects.detectors.icf.displays import window_path
from nvcore.subjects.detectors.registry import open_detector

SCALES_OF_HEADS = scale_steps(1.0, 2.4, 0.2)
OF_SIGNS = (4415340, 1103840, 490593, 275959, 176614, 122648, 90109, 68989, 54510, 44153)
OF_HEADS = (921548, 230387, 102394, 57596, 36862, 25599, 18807, 14399, 11377, 9215)


def windows_in(settings, width: int, height: int) -> int:
    groups = levels(width, height, settings)
    return sum(int(np.prod(level.grid(settings))) for group in groups for level in group)


@pytest.mark.parametrize("stride", range(1, 11))
@pytest.mark.parametrize(
    ("side", "scales", "size", "published"),
    [(64, AS_IN_REPORT.scales, (1360, 800), OF_SIGNS), (30, SCALES_OF_HEADS, (640, 480), OF_HEADS)],
)
def test_windows_are_the_published_ones_and_counted_whole(side, scales, size, published, stride):
    area = WindowGrid(side, side, stride, scales, count="area").per_image(*size)
    # 1,103,835 by the formula for stride 2, where the report has 1,103,840; others rounded or cut
    assert abs(float(area) - published[stride - 1]) < (6 if stride == 2 else 1)
    settings = replace(
        AS_IN_REPORT, window_width=side, window_height=side, object_width=side,
        object_height=side, scales=scales, stride=stride,
    )  # fmt: skip
    assert windows_in(settings, *size) == WindowGrid(side, side, stride, scales).per_image(*size)


def test_objects_are_found_and_nothing_else(model, drawn):
    detector: Detector = IcfDetector(model)
    scenes = [drawn(100 + i) for i in range(8)]
    n_matches = n_boxes = 0
    for scene in scenes:
        boxes = detector.detect(scene.picture)
        n_boxes += len(boxes)
        for x, y, w, h in scene.boxes:
            across = np.minimum(boxes.x + boxes.w, x + w) - np.maximum(boxes.x, x)
            down = np.minimum(boxes.y + boxes.h, y + h) - np.maximum(boxes.y, y)
            shared = np.maximum(across, 0) * np.maximum(down, 0)
            n_matches += bool((shared > 0.5 * (boxes.w * boxes.h + w * h - shared)).any())
    assert n_matches == 16
    assert n_boxes <= 18


def test_boxes_come_by_descending_score_and_above_the_threshold(model, drawn):
    detector = IcfDetector(model)
    picture = drawn(100).picture
    score = detector.detect(picture).score
    assert (np.diff(score) <= 0).all()
    higher = detector.run_with(threshold=float(score[0]))
    assert higher.detect(picture).score.tolist() == [s for s in score if s >= score[0]]


def test_no_number_of_threads_changes_the_boxes(model, drawn, monkeypatch):
    boxes = []
    for n_threads in (1, 3):
        monkeypatch.setattr("os.cpu_count", lambda n=n_threads: n)
        boxes.append(IcfDetector(model).detect(drawn(101).picture))
    for name in ("x", "y", "w", "h", "score"):
        np.testing.assert_array_equal(getattr(boxes[0], name), getattr(boxes[1], name))


def test_a_picture_that_is_smaller_than_the_window_has_no_boxes(model):
    boxes = IcfDetector(model).detect(np.zeros((10, 10, 3), np.uint8))
    assert len(boxes) == 0


def test_a_colour_model_refuses_a_grey_picture(model):
    with pytest.raises(DetectorError, match="grey picture"):
        IcfDetector(model).detect(np.zeros((100, 100), np.uint8))


def test_a_picture_that_would_become_too_large_is_refused(model):
    detector = IcfDetector(model).run_with(scales=(0.05,))
    with pytest.raises(DetectorError, match="begin with a larger scale"):
        detector.detect(np.zeros((700, 700, 3), np.uint8))


def test_channels_count_in_what_a_level_takes(settings):
    few, many = (replace(settings, scales=(1.0,), channels=c) for c in (("grey",), ("luv", "hsv")))
    assert levels(15_000, 10_000, few)
    with pytest.raises(DetectorError, match=r"150 million pixels, whose 6 channels take 4.5 GB"):
        levels(15_000, 10_000, many)


@pytest.mark.parametrize("cascade", ["calibrated", "constant", "hard", "none"])
def test_a_window_is_rejected_where_its_path_says(model, drawn, cascade):
    run = model.run_with(cascade=cascade, rejection=-0.5)
    picture = drawn(102).picture
    maps = IcfDetector(run).score_maps(picture)
    score_map = maps[1]
    for row, column in ((0, 0), (4, 9), *np.argwhere(~np.isnan(score_map.score))[:3]):
        path = window_path(run, picture, score_map.level.scale, int(row), int(column))
        expected = path.rejected_after or len(run.trees)
        assert score_map.depth[row, column] == expected
        score = score_map.score[row, column]
        assert np.isnan(score) == (path.rejected_after is not None)
        if path.rejected_after is None:
            assert score == pytest.approx(path.confidence[-1], abs=1e-9)


def test_without_a_cascade_every_window_comes_through(model, drawn):
    maps = IcfDetector(model.run_with(cascade="none")).score_maps(drawn(103).picture)
    assert all((score_map.depth == len(model.trees)).all() for score_map in maps)
    assert maps[0].n_features == 2 * len(model.trees) * maps[0].n_windows


def test_the_trace_rejects_no_object_that_is_confident_at_the_end():
    rng = np.random.default_rng(0)
    sums = rng.normal(0.3, 1, (50, 37)).cumsum(axis=1)
    calibration = calibrate(sums, kept_share=0.9)
    passes = (sums >= calibration.trace).all(axis=1)
    best = np.sort(sums[:, -1])[::-1][:45]
    assert set(best) <= set(sums[passes, -1])
    assert calibration.trace[-1] == best[-1]


def test_the_trace_is_the_least_sum_of_those_that_are_kept():
    sums = np.array([[1.0, 2.0, 3.0], [-1.0, 0.5, 2.0], [-4.0, -5.0, -9.0]])
    calibration = calibrate(sums, kept_share=2 / 3)
    np.testing.assert_array_equal(calibration.trace, [-1.0, 0.5, 2.0])
    np.testing.assert_array_equal(calibration.stage_ends, [2, 3])
    np.testing.assert_array_equal(calibration.stage_floors, [0.5, 1.0])


def test_slack_lowers_the_trace_and_the_floors_of_stages():
    sums = np.array([[1.0, 2.0, 3.0], [3.0, 6.0, 9.0]])
    calibration = calibrate(sums, kept_share=1.0, slack=0.5)
    np.testing.assert_array_equal(calibration.trace, [0.5, 1.5, 2.5])
    np.testing.assert_array_equal(calibration.stage_floors, [1.5, 0.5])


def test_the_lower_of_two_calibrations_keeps_the_share_of_each_by_itself(settings):
    rng = np.random.default_rng(0)
    seen = rng.normal(0.6, 1, (400, 37)).cumsum(axis=1)
    unseen = rng.normal(0.1, 1, (20, 37)).cumsum(axis=1)
    both = lower(calibrate(seen, 0.9), calibrate(unseen, 0.9))
    together = calibrate(np.concatenate([seen, unseen]), 0.9)
    for cascade in ("calibrated", "hard"):
        run = replace(settings, cascade=cascade)
        assert passes(run, both, seen).all(axis=1).mean() >= 0.9
        assert passes(run, both, unseen).all(axis=1).mean() >= 0.9
    assert (unseen >= together.trace).all(axis=1).mean() < 0.9


def test_two_calibrations_that_keep_all_are_that_of_all_objects():
    sums = np.random.default_rng(0).normal(0.3, 1, (30, 37)).cumsum(axis=1)
    both = lower(calibrate(sums[:20], 1.0), calibrate(sums[20:], 1.0))
    every = calibrate(sums, 1.0)
    np.testing.assert_array_equal(both.trace, every.trace)
    np.testing.assert_array_equal(both.stage_floors, every.stage_floors)


def test_in_a_hard_cascade_the_sum_of_each_stage_passes_by_itself(settings):
    calibration = Calibration(np.zeros(4), np.array([2, 4], np.int32), np.array([1.0, 1.0]))
    hard = replace(settings, cascade="hard")
    sums = np.array([[1.0, 2, 3, 3], [1, 2, 2, 2.5], [0, 0.5, 9, 9]])  # second stage: 1, 0.5, 8.5
    assert passes(hard, calibration, sums).all(axis=1).tolist() == [True, False, False]
    constant = replace(settings, cascade="constant", rejection=1.0)
    assert passes(constant, calibration, sums).all(axis=1).tolist() == [True, True, False]


def test_no_window_is_rejected_that_the_trees_take_for_an_object_so_far(model):
    calibration = calibrate(np.array([[0.5, -1.0, 4.0], [2.0, -2.0, 3.0]]), kept_share=1.0)
    lowest, restarts = floors(replace(model.settings, cascade="calibrated"), calibration)
    assert lowest.tolist() == [0.0, -2.0, 0.0]
    assert not restarts.any()


def test_each_stage_of_a_hard_cascade_begins_anew(model):
    calibration = calibrate(np.arange(1.0, 9.0)[None], kept_share=1.0)
    lowest, restarts = floors(replace(model.settings, cascade="hard"), calibration)
    assert np.flatnonzero(restarts).tolist() == [2, 4]
    assert np.flatnonzero(np.isfinite(lowest)).tolist() == [1, 3, 7]
    np.testing.assert_allclose(lowest[[1, 3, 7]], [2, 2, 4])


def test_a_detector_says_what_it_is(model):
    about = IcfDetector(model).about
    assert (about.kind, about.name, about.labels) == ("icf", "discs", ("disc",))
    assert about.settings["scales"] == "0.9 1 1.1 1.2 1.35"
    assert len(about.fingerprint) == 64
    assert [len(part.fingerprint) for part in about.trained_on] == [64]


def test_other_settings_are_another_fingerprint(model):
    detector = IcfDetector(model)
    assert detector.run_with().about.fingerprint == detector.about.fingerprint
    assert detector.run_with(stride=2).about.fingerprint != detector.about.fingerprint


@pytest.mark.parametrize("overlap_of", ["union", "smaller"])
def test_threshold_and_overlap_moved_on_kept_boxes_give_its_own(
    model, drawn, overlap_of, tmp_path: Path
):
    path = tmp_path / "discs.npz"
    write_model(model, path)
    boxes = candidates(open_loosened(path), drawn(3).picture, most=10**6)
    settings = {"threshold": 2.0, "overlap": 0.3, "overlap_of": overlap_of}
    own = open_detector(path, settings)
    is_counting = counting(boxes, own.about, threshold=2.0, overlap=0.3)
    expected = own.detect(drawn(3).picture)
    assert 0 < len(expected) < len(boxes)
    np.testing.assert_array_equal(boxes.score[is_counting], expected.score)
