"""The bytes in which the viewer gets the boxes of some frames."""

from __future__ import annotations

import struct
from types import SimpleNamespace

import numpy as np
import pytest
from builders import NAN, at, make_dataset, result_of
from scenes import three_frames

from nvcore.comparison.compare import Result, compare
from nvcore.dataset.schema import DetectionState
from ui.session.packed_comparison import (
    BIT_IGNORE,
    BIT_MATCHED_X,
    BIT_MATCHED_Y,
    BIT_RELEVANT,
    BIT_SALIENT_X,
    BIT_SALIENT_Y,
    COLUMNS,
    SOURCE_TRUTH,
    SOURCE_X,
    SOURCE_Y,
    pack_boxes,
)


def unpack_boxes(content: bytes) -> SimpleNamespace:
    """The offsets and columns, as the viewer's script reads them."""
    n_frames, n_boxes = struct.unpack_from("<II", content)
    columns = {"offsets": np.frombuffer(content, "<u4", n_frames + 1, 8)}
    position = 8 + columns["offsets"].nbytes
    for name, dtype in COLUMNS.items():
        columns[name] = np.frombuffer(content, dtype, n_boxes, position)
        position += columns[name].nbytes + -columns[name].nbytes % 4
    assert position == len(content)
    return SimpleNamespace(**columns)


@pytest.fixture(scope="module")
def result() -> Result:
    return three_frames()


def test_boxes_stand_by_frame_truth_first_without_those_below_the_threshold(result: Result):
    packed = unpack_boxes(pack_boxes(result, 0, 3))
    assert packed.offsets.tolist() == [0, 5, 5, 8]
    T, X, Y = SOURCE_TRUTH, SOURCE_X, SOURCE_Y
    assert packed.source.tolist() == [T, T, X, X, Y, T, X, X]
    assert (packed.x + packed.w / 2).tolist() == [30, 60, 30, 60, 30, 50, 50, 90]


def test_states_are_bits_of_the_truth_and_states_of_detections(result: Result):
    matched = DetectionState.MATCHED
    assert unpack_boxes(pack_boxes(result, 0, 3)).state.tolist() == [
        BIT_RELEVANT | BIT_MATCHED_X | BIT_MATCHED_Y,
        BIT_RELEVANT | BIT_MATCHED_X | BIT_SALIENT_Y,
        *(matched, matched, matched),
        BIT_IGNORE,
        DetectionState.ABSORBED,
        DetectionState.FALSE_ALARM,
    ]


def test_boxes_scores_and_tracks_are_packed(result: Result):
    packed = unpack_boxes(pack_boxes(result, 0, 1))
    assert [getattr(packed, name)[0] for name in "xywh"] == [29, 40, 2, 50]
    assert packed.track.tolist() == [1, 2, -1, -1, -1]
    assert packed.score.tolist()[2:] == pytest.approx([0.9, 0.8, 0.9])
    assert np.isnan(packed.score[:2]).all()


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


def test_x_and_y_may_be_one_system():
    result = compare(make_dataset(x=[at(0, 50)]), x="x", y="x")
    assert unpack_boxes(pack_boxes(result, 0, 1)).source.tolist() == [SOURCE_X, SOURCE_Y]
