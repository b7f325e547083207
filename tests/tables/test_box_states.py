"""What became of every box, and the bytes that a viewer gets."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from builders import NAN, Place, at, make_dataset, result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from scenes import draw_scene

from nvcore.comparison import Result, compare
from nvcore.metrics.kernels import ABSORBED, BELOW, FALSE_ALARM, MATCHED
from nvcore.params import Params
from nvcore.tables.box_states import (
    BIT_IGNORE,
    BIT_MATCHED_X,
    BIT_MATCHED_Y,
    BIT_RELEVANT,
    BIT_SALIENT_X,
    BIT_SALIENT_Y,
    FOUND,
    MISSED,
    NOT_JUDGED,
    SOURCE_TRUTH,
    SOURCE_X,
    SOURCE_Y,
    box_states,
    pack_boxes,
    unpack_boxes,
)


@pytest.fixture(scope="module")
def result() -> Result:
    """Three frames. 0: tracks 1 (both find it) and 2 (only X). 1: nothing. 2: an ignore region."""
    truth = [at(0, 30, track=1), at(0, 60, track=2), at(2, 50, w=40, ignore=True)]
    x = [at(0, 30, score=0.9), at(0, 60, score=0.8), at(2, 50, score=0.7), at(2, 90, score=0.6)]
    y = [at(0, 30, score=0.9), at(0, 60, score=0.1)]
    return result_of(make_dataset(truth, x, y), threshold_y=0.5)


def test_a_truth_box_is_found_missed_or_not_judged(result: Result):
    states = box_states(result, 0, 3)
    assert states.state_x.tolist() == [FOUND, FOUND, NOT_JUDGED]
    assert states.state_y.tolist() == [FOUND, MISSED, NOT_JUDGED]


def test_detections_keep_the_state_of_the_matching(result: Result):
    states = box_states(result, 0, 3)
    assert states.x.tolist() == [MATCHED, MATCHED, ABSORBED, FALSE_ALARM]
    assert states.y.tolist() == [MATCHED, BELOW]


def test_only_the_most_salient_miss_is_marked(result: Result):
    states = box_states(result, 0, 3)
    assert states.is_salient_x.tolist() == [False, False, False]
    assert states.is_salient_y.tolist() == [False, True, False]


def test_relevant_are_near_pedestrians_that_are_judged():
    truth = [at(0, 30, track=1), at(0, 60, track=2, h=5), at(0, 80, ignore=True)]
    states = box_states(result_of(make_dataset(truth), proximity="height"), 0, 1)
    assert states.is_relevant.tolist() == [True, False, False]


def test_packed_boxes_stand_by_frame_truth_first_without_those_below_the_threshold(
    result: Result,
):
    packed = unpack_boxes(pack_boxes(result, 0, 3))
    assert packed.offsets.tolist() == [0, 5, 5, 8]
    T, X, Y = SOURCE_TRUTH, SOURCE_X, SOURCE_Y
    assert packed.source.tolist() == [T, T, X, X, Y, T, X, X]
    assert (packed.x + packed.w / 2).tolist() == [30, 60, 30, 60, 30, 50, 50, 90]


def test_packed_states_are_bits_of_the_truth_and_states_of_detections(result: Result):
    both = BIT_RELEVANT | BIT_MATCHED_X | BIT_MATCHED_Y
    only_x = BIT_RELEVANT | BIT_MATCHED_X | BIT_SALIENT_Y
    assert unpack_boxes(pack_boxes(result, 0, 3)).state.tolist() == [
        both, only_x, MATCHED, MATCHED, MATCHED, BIT_IGNORE, ABSORBED, FALSE_ALARM,
    ]  # fmt: skip


def test_the_most_salient_miss_of_x_has_a_bit_of_its_own():
    packed = unpack_boxes(pack_boxes(result_of(make_dataset([at(0, 50)], y=[at(0, 50)])), 0, 1))
    assert packed.state[0] == BIT_RELEVANT | BIT_MATCHED_Y | BIT_SALIENT_X


def test_boxes_scores_and_tracks_are_packed(result: Result):
    packed = unpack_boxes(pack_boxes(result, 0, 1))
    assert [getattr(packed, name)[0] for name in "xywh"] == [29, 40, 2, 50]
    assert packed.track.tolist() == [1, 2, -1, -1, -1]
    assert packed.score.tolist()[2:] == pytest.approx([0.9, 0.8, 0.9])
    assert np.isnan(packed.score[:2]).all()


def test_a_part_of_the_frames_is_packed_alone(result: Result):
    packed = unpack_boxes(pack_boxes(result, 1, 3))
    assert packed.offsets.tolist() == [0, 0, 3]
    assert packed.source.tolist() == [SOURCE_TRUTH, SOURCE_X, SOURCE_X]


@pytest.mark.parametrize("rows", [(0, 0), (1, 2), (3, 3)])
def test_frames_without_boxes_are_packed_as_none(result: Result, rows: tuple[int, int]):
    packed = unpack_boxes(pack_boxes(result, *rows))
    assert packed.offsets.tolist() == [0] * (rows[1] - rows[0] + 1)
    assert len(packed.x) == 0


def test_the_bytes_are_little_endian_and_padded_to_four():
    content = pack_boxes(result_of(make_dataset([at(0, 50, track=3)])), 0, 1)
    assert content == (
        struct.pack("<II", 1, 1)  # frames, boxes
        + struct.pack("<II", 0, 1)  # offsets
        + struct.pack("<5f", 49, 40, 2, 50, NAN)
        + struct.pack("<i", 3)
        + bytes([SOURCE_TRUTH, 0, 0, 0])
        + bytes([BIT_RELEVANT | BIT_SALIENT_X | BIT_SALIENT_Y, 0, 0, 0])
    )


def test_tracks_beyond_int32_are_numbered_over_the_whole_recording():
    large = 1_700_000_000_000
    truth = [at(0, 10, track=large), at(1, 50, track=7), at(1, 80, track=large + 5)]
    result = result_of(make_dataset(truth))
    assert unpack_boxes(pack_boxes(result, 0, 2)).track.tolist() == [1, 0, 2]
    assert unpack_boxes(pack_boxes(result, 1, 2)).track.tolist() == [0, 2]


def test_a_large_track_leaves_the_ids_of_other_recordings_and_missing_ones_alone():
    truth = [at(0, 10, track=9), at(0, 10, track=2**40, recording=1)]
    y = [at(0, 10, track=2**40), at(0, 50)]
    result = result_of(make_dataset(truth, y=y, places=[Place([0]), Place([0])]))
    assert unpack_boxes(pack_boxes(result, 0, 2)).track.tolist() == [9, 0, -1, 0]


def test_x_and_y_may_be_one_system():
    result = compare(make_dataset(x=[at(0, 50)]), x="x", y="x")
    assert unpack_boxes(pack_boxes(result, 0, 1)).source.tolist() == [SOURCE_X, SOURCE_Y]


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_two_parts_hold_together_what_the_whole_holds(seed: int, share: float):
    result = compare(draw_scene(seed).dataset(), Params(threshold_x=0.4))
    n = len(result.dataset.frames)
    cut = int(share * n)
    whole, *parts = (
        unpack_boxes(pack_boxes(result, *rows)) for rows in ((0, n), (0, cut), (cut, n))
    )
    for name in ("x", "y", "w", "h", "score", "track", "source", "state"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert joined.tobytes() == getattr(whole, name).tobytes(), name
    assert len(whole.x) == sum(
        int(np.count_nonzero(s.matches.state != BELOW)) for s in (result.x, result.y)
    ) + len(result.dataset.truth)
