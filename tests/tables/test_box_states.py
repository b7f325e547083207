"""The boxes of a stretch of frames, and what became of each."""

from __future__ import annotations

import numpy as np
import pytest
from builders import Place, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw_scene, three_frames

from nvcore.comparison.compare import compare
from nvcore.dataset.schema import DetectionState, TruthState
from nvcore.settings.params import Params
from nvcore.tables.boxes.states import FrameBoxes, gather_boxes


@pytest.fixture(scope="module")
def boxes() -> FrameBoxes:
    return gather_boxes(three_frames(), 0, 3)


def test_a_truth_box_is_matched_missed_or_not_judged(boxes: FrameBoxes):
    matched, missed, not_judged = TruthState.MATCHED, TruthState.MISSED, TruthState.NOT_JUDGED
    assert boxes.truth.state_x.tolist() == [matched, matched, not_judged]
    assert boxes.truth.state_y.tolist() == [matched, missed, not_judged]


def test_detections_keep_the_state_of_the_matching_and_their_place(boxes: FrameBoxes):
    assert boxes.x.state.tolist() == [
        DetectionState.MATCHED,
        DetectionState.MATCHED,
        DetectionState.ABSORBED,
        DetectionState.FALSE_ALARM,
    ]
    assert boxes.x.frame.tolist() == [0, 0, 2, 2]
    assert (boxes.x.xywh[:, 0] + boxes.x.xywh[:, 2] / 2).tolist() == [30, 60, 50, 90]
    assert boxes.x.score.tolist() == pytest.approx([0.9, 0.8, 0.7, 0.6])


def test_detections_below_the_threshold_are_left_out(boxes: FrameBoxes):
    assert boxes.y.state.tolist() == [DetectionState.MATCHED]
    assert boxes.y.xywh.tolist() == [[29, 40, 2, 50]]
    assert boxes.y.score.tolist() == pytest.approx([0.9])


def test_only_the_most_salient_miss_is_marked(boxes: FrameBoxes):
    assert boxes.truth.is_salient_x.tolist() == [False, False, False]
    assert boxes.truth.is_salient_y.tolist() == [False, True, False]


def test_relevant_are_near_pedestrians_that_are_judged():
    truth = [at(0, 30, track=1), at(0, 60, track=2, h=5), at(0, 80, ignore=True)]
    result = result_of(make_dataset(truth), proximity="height")
    assert gather_boxes(result, 0, 1).truth.is_relevant.tolist() == [True, False, False]


def test_frames_count_from_the_first_of_the_stretch():
    boxes = gather_boxes(three_frames(), 1, 3)
    assert boxes.truth.frame.tolist() == [1]
    assert boxes.x.frame.tolist() == [1, 1]
    assert boxes.y.frame.tolist() == []


def test_tracks_beyond_int32_are_numbered_over_the_whole_recording():
    large = 1_700_000_000_000
    truth = [at(0, 10, track=large), at(1, 50, track=7), at(1, 80, track=large + 5)]
    result = result_of(make_dataset(truth))
    assert gather_boxes(result, 0, 2).truth.track.tolist() == [1, 0, 2]
    assert gather_boxes(result, 1, 2).truth.track.tolist() == [0, 2]


def test_a_large_track_leaves_the_ids_of_other_recordings_and_missing_ones_alone():
    truth = [at(0, 10, track=9), at(0, 10, track=2**40, recording=1)]
    y = [at(0, 10, track=2**40), at(0, 50)]
    boxes = gather_boxes(result_of(make_dataset(truth, y=y, places=[Place([0]), Place([0])])), 0, 2)
    assert boxes.truth.track.tolist() == [9, 0]
    assert sorted(boxes.y.track.tolist()) == [-1, 0]


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_two_parts_hold_together_what_the_whole_holds(seed: int, share: float):
    result = compare(draw_scene(seed).dataset(), Params(threshold_x=0.4))
    n = len(result.dataset.frames)
    cut = int(share * n)
    whole, first, second = (gather_boxes(result, *rows) for rows in ((0, n), (0, cut), (cut, n)))
    for source in ("truth", "x", "y"):
        parts = [vars(getattr(part, source)) for part in (first, second)]
        parts[1] = {**parts[1], "frame": parts[1]["frame"] + cut}
        for name, column in vars(getattr(whole, source)).items():
            joined = np.concatenate([part[name] for part in parts])
            assert joined.tobytes() == column.tobytes(), (source, name)
    assert len(whole.truth.frame) == len(result.dataset.truth)
    for boxes, system in ((whole.x, result.x), (whole.y, result.y)):
        assert len(boxes.frame) == np.count_nonzero(system.matches.state != DetectionState.BELOW)
