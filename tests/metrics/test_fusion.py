from __future__ import annotations

import numpy as np
from builders import Box, Place, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import Scene, draw_scene

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset import Dataset
from nvcore.metrics.fusion import fuse


def fused(dataset: Dataset, *, iou: float = 0.5) -> Dataset:
    x, y = dataset.system("x"), dataset.system("y")
    return fuse(dataset, "x", "y", np.ones(len(x), bool), np.ones(len(y), bool), iou=iou)


def lefts(dataset: Dataset) -> tuple[list[float], list[float]]:
    """Left edges of `X or Y` and of `X and Y`."""
    either, both = (dataset.system(name) for name in dataset.systems)
    return either.x.tolist(), both.x.tolist()


def test_a_pair_stands_once_by_xs_box_and_unpaired_boxes_of_both_stay() -> None:
    dataset = make_dataset(
        x=[(0, 0, 0, 10, 10), (0, 30, 0, 10, 10)], y=[(0, 60, 0, 10, 10), (0, 2, 0, 10, 10)]
    )
    assert lefts(fused(dataset)) == ([0, 30, 60], [0])


def test_fused_systems_have_no_scores_and_names_that_say_what_they_are() -> None:
    dataset = fused(make_dataset(x=[Box(0, 0, 0, 9, 9, score=1)], y=[Box(0, 0, 0, 9, 9, score=7)]))
    assert dataset.systems == ("x or y", "x and y")
    assert np.isnan(dataset.boxes["score"]).all()


def test_recordings_frames_and_truth_stay_as_they_are() -> None:
    places = [Place([0, 5, 9], fps=7), Place([]), Place([3], width=640)]
    dataset = make_dataset([at(5, 50, track=1)], [at(5, 50)], places=places)
    other = fused(dataset)
    assert other.frames.equals(dataset.frames)
    assert other.recordings.equals(dataset.recordings)
    assert other.truth.track.tolist() == [1]
    assert other.fingerprint == dataset.fingerprint


def test_fused_systems_have_the_same_parameters_and_no_threshold_again() -> None:
    dataset = make_dataset([at(0, 50, track=1)], [at(0, 60, score=0.6)], [at(0, 50, score=9)])
    fusion = result_of(dataset, alpha=0.5, low=0.3, threshold_x=0.5, threshold_y=8).fusion
    assert (fusion.params.alpha, fusion.params.low, fusion.params.proximity) == (0.5, 0.3, "none")
    assert (fusion.x.threshold, fusion.y.threshold, fusion.params.threshold_y) == (None,) * 3
    assert fusion.x.similarity.tolist() == [0.9]  # the false alarm of X
    assert fusion.y.similarity.tolist() == [0.5]  # nothing that both saw


def assert_same(system: SystemResult, other: SystemResult) -> None:
    assert system.n_det.tolist() == other.n_det.tolist()
    assert system.similarity.tolist() == other.similarity.tolist()
    assert system.encounters.equals(other.encounters)
    assert system.events.equals(other.events)
    assert system.episodes.equals(other.episodes)
    assert repr(system.false_alarm_summary) == repr(other.false_alarm_summary)


def without_scores(seed: int) -> Scene:
    """A scene whose detections have no scores that fusion could lose."""
    scene = draw_scene(seed)
    scene.x, scene.y = ([b._replace(score=np.nan) for b in s] for s in (scene.x, scene.y))
    return scene


SEEDS = st.integers(0, 2**32 - 1)
few = settings(max_examples=12, deadline=None, derandomize=True)


@few
@given(SEEDS)
def test_x_or_x_and_x_and_x_are_x(seed: int) -> None:
    result = compare(without_scores(seed).dataset(), x="x", y="x")
    assert_same(result.fusion.x, result.x)
    assert_same(result.fusion.y, result.x)


def test_empty_systems_fuse_to_empty_ones() -> None:
    result: Result = result_of(make_dataset([at(0, 50, track=1)]))
    assert lefts(result.fusion.dataset) == ([], [])
    assert result.fusion.venn.neither == 1


def detected(result: Result) -> list[int]:
    """Encounters detected by X, Y, `X or Y` and `X and Y`."""
    systems = (result.x, result.y, result.fusion.x, result.fusion.y)
    return [int(system.encounters["is_detected"].sum()) for system in systems]


def test_an_encounter_may_be_detected_by_a_fusion_and_by_neither_system_or_the_other_way() -> None:
    truth = [at(frame, 50, track=1) for frame in range(8)]
    # a quarter each: half together
    assert detected(result_of(make_dataset(truth, truth[:2], truth[2:4]))) == [0, 0, 1, 0]
    # half each, in different frames
    assert detected(result_of(make_dataset(truth, truth[:4], truth[4:]))) == [1, 1, 1, 0]
    # X's box, which stands for the pair, is too far off
    off = [at(frame, 54, w=10) for frame in range(8)]
    between = [at(frame, 52, w=10) for frame in range(8)]
    wide = [at(frame, 50, track=1, w=10) for frame in range(8)]
    assert detected(result_of(make_dataset(wide, off, between))) == [0, 1, 0, 0]


def test_false_alarms_of_both_may_be_more_episodes_than_those_of_either() -> None:
    y = [at(frame, 50) for frame in range(100)]
    x = y[:5] + [at(frame, 20) for frame in range(5, 95)] + y[95:]
    x = [box for box in x if box.centre == 50] + [box for box in x if box.centre == 20]
    result = result_of(make_dataset([], sorted(x), y, places=[Place(range(100))]))
    assert result.y.false_alarm_summary.episodes == 1
    assert result.fusion.y.false_alarm_summary.episodes == 2
