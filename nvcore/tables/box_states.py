"""What became of every box, and the bytes in which a viewer gets the boxes of some frames."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.comparison import Result, SystemResult
from nvcore.dataset import BoxColumns, FrameColumns
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.kernels import BELOW
from nvcore.schema import NO_TRACK

NOT_JUDGED: Final = 0
"""State of a truth box that is ignored."""
MISSED: Final = 1
"""State of a pedestrian without a detection."""
FOUND: Final = 2
"""State of a pedestrian that was matched."""

SOURCE_TRUTH: Final = 0
SOURCE_X: Final = 1
SOURCE_Y: Final = 2

# bits of the state of a packed truth box; packed detections have their state of nvcore.kernels
BIT_IGNORE: Final = 1
BIT_MATCHED_X: Final = 2
BIT_MATCHED_Y: Final = 4
BIT_RELEVANT: Final = 8
BIT_SALIENT_X: Final = 16
BIT_SALIENT_Y: Final = 32


_HEAD = struct.Struct("<II")
_LARGEST_TRACK = 2**31 - 1


@dataclass(frozen=True, eq=False)
class BoxStates:
    """States of the boxes of some frames.

    Attributes
    ----------
    state_x, state_y
        Per truth box: NOT_JUDGED, MISSED or FOUND; uint8, shape (n_truth,).
    is_relevant
        Pedestrians near enough to count (``k >= 0.5``); bool, (n_truth,).
    is_salient_x, is_salient_y
        The most salient pedestrian of its frame, missed by more than the tolerance; bool,
        (n_truth,).
    x, y
        Per detection of each system: BELOW, MATCHED, FALSE_ALARM or ABSORBED of
        `nvcore.metrics.kernels`; int8, (n_det,).
    """

    state_x: np.ndarray
    state_y: np.ndarray
    is_relevant: np.ndarray
    is_salient_x: np.ndarray
    is_salient_y: np.ndarray
    x: np.ndarray
    y: np.ndarray


def box_states(result: Result, row_start: int, row_stop: int) -> BoxStates:
    """What became of the boxes of frames ``row_start:row_stop`` (rows of the frames table)."""
    truth = result.dataset.truth
    boxes = _boxes_of(truth, row_start, row_stop)
    is_pedestrian = ~truth.ignore[boxes]
    systems = (result.x, result.y)
    found_x, found_y = (
        np.where(is_pedestrian, np.where(s.matches.truth_det[boxes] >= 0, FOUND, MISSED),
                 NOT_JUDGED).astype(np.uint8)
        for s in systems
    )  # fmt: skip
    salient_x, salient_y = (_is_salient(s, boxes, row_start, row_stop) for s in systems)
    det_x, det_y = (
        s.matches.state[_boxes_of(result.dataset.system(s.name), row_start, row_stop)]
        for s in systems
    )
    return BoxStates(
        state_x=found_x,
        state_y=found_y,
        is_relevant=(result.k_truth.k[boxes] >= RELEVANT_K) & is_pedestrian,
        is_salient_x=salient_x,
        is_salient_y=salient_y,
        x=det_x,
        y=det_y,
    )


def _boxes_of(boxes: BoxColumns, row_start: int, row_stop: int) -> slice:
    return slice(int(boxes.offsets[row_start]), int(boxes.offsets[row_stop]))


def _is_salient(system: SystemResult, boxes: slice, row_start: int, row_stop: int) -> np.ndarray:
    marked = system.salient_row[row_start:row_stop]
    is_salient = np.zeros(boxes.stop - boxes.start, dtype=bool)
    is_salient[marked[marked >= 0] - boxes.start] = True
    return is_salient


@dataclass(frozen=True, eq=False)
class PackedBoxes:
    """Boxes of consecutive frames, as a viewer gets them.

    Attributes
    ----------
    offsets
        ``offsets[i]:offsets[i + 1]`` are the boxes of the i-th frame; uint32, (n_frames + 1,).
    x, y, w, h, score
        px, and the score (NaN: none); float32, (n,).
    track
        NO_TRACK where none; int32, (n,). If an id of the source and recording is no int32: the
        index of each id among its ids in ascending order.
    source
        SOURCE_TRUTH, SOURCE_X or SOURCE_Y; uint8, (n,).
    state
        Truth: the ``BIT_`` constants, added. Detections: MATCHED, FALSE_ALARM or ABSORBED of
        `nvcore.metrics.kernels`. uint8, (n,).
    """

    offsets: np.ndarray
    x: np.ndarray
    y: np.ndarray
    w: np.ndarray
    h: np.ndarray
    score: np.ndarray
    track: np.ndarray
    source: np.ndarray
    state: np.ndarray


_COLUMNS: Final = {
    "x": "<f4", "y": "<f4", "w": "<f4", "h": "<f4", "score": "<f4", "track": "<i4",
    "source": "|u1", "state": "|u1",
}  # fmt: skip


def pack_boxes(result: Result, row_start: int, row_stop: int) -> bytes:
    """Boxes of frames ``row_start:row_stop`` (rows of the frames table) with their states.

    Little endian: uint32 number of frames, uint32 number of boxes, the offsets, then the columns
    of `PackedBoxes` in their order, each padded with zeros to a multiple of 4 bytes. In a frame
    the truth comes first, then X, then Y; detections below the threshold are left out.
    """
    assert 0 <= row_start <= row_stop <= len(result.dataset.frames), (row_start, row_stop)
    packed = _gather(result, row_start, row_stop)
    parts = [
        _HEAD.pack(row_stop - row_start, len(packed.x)),
        packed.offsets.astype("<u4").tobytes(),
    ]
    for name, dtype in _COLUMNS.items():
        content = np.ascontiguousarray(getattr(packed, name), dtype=dtype).tobytes()
        parts += [content, bytes(-len(content) % 4)]
    return b"".join(parts)


def unpack_boxes(content: bytes) -> PackedBoxes:
    """What `pack_boxes` packed; the documentation of the format."""
    n_frames, n_boxes = _HEAD.unpack_from(content)
    offsets = np.frombuffer(content, "<u4", n_frames + 1, _HEAD.size)
    at = _HEAD.size + offsets.nbytes
    columns = {}
    for name, dtype in _COLUMNS.items():
        columns[name] = np.frombuffer(content, dtype, n_boxes, at)
        at += columns[name].nbytes + -columns[name].nbytes % 4
    return PackedBoxes(offsets, **columns)


def _gather(result: Result, row_start: int, row_stop: int) -> PackedBoxes:
    dataset, frames = result.dataset, result.dataset.frame_columns
    states = box_states(result, row_start, row_stop)
    state = np.zeros(len(states.state_x), np.uint8)
    for is_set, bit in (
        (states.state_x == NOT_JUDGED, BIT_IGNORE),
        (states.state_x == FOUND, BIT_MATCHED_X),
        (states.state_y == FOUND, BIT_MATCHED_Y),
        (states.is_relevant, BIT_RELEVANT),
        (states.is_salient_x, BIT_SALIENT_X),
        (states.is_salient_y, BIT_SALIENT_Y),
    ):
        state[is_set] |= bit
    x, y = dataset.system(result.x.name), dataset.system(result.y.name)
    sources = (
        (SOURCE_TRUTH, dataset.truth, result.tracks.track, state, np.ones(len(state), dtype=bool)),
        (SOURCE_X, x, x.track, states.x, states.x != BELOW),
        (SOURCE_Y, y, y.track, states.y, states.y != BELOW),
    )
    gathered: dict[str, list[np.ndarray]] = {name: [] for name in ("frame", *_COLUMNS)}
    for source, boxes, track, state_of, is_kept in sources:
        rows = _boxes_of(boxes, row_start, row_stop)
        shown = _small_tracks(track, boxes.offsets, frames, row_start, row_stop)
        columns = {
            "frame": boxes.frame_index[rows] - row_start,
            **{name: getattr(boxes, name)[rows] for name in ("x", "y", "w", "h", "score")},
            "track": shown,
            "source": np.full(len(shown), source),
            "state": state_of,
        }
        for name, values in columns.items():
            gathered[name].append(values[is_kept])
    whole = {name: np.concatenate(values) for name, values in gathered.items()}
    frame = whole.pop("frame")
    order = np.argsort(frame, kind="stable")
    counts = np.bincount(frame, minlength=row_stop - row_start)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    return PackedBoxes(offsets, **{name: values[order] for name, values in whole.items()})


def _small_tracks(
    track: np.ndarray, offsets: np.ndarray, frames: FrameColumns, row_start: int, row_stop: int
) -> np.ndarray:
    """Tracks of the boxes of some frames, as int32."""
    start, stop = offsets[row_start], offsets[row_stop]
    small = np.empty(stop - start, np.int32)
    touched = np.unique(frames.recording[row_start:row_stop])
    for recording in touched:  # a loop over recordings, nearly always one
        # the ids of the whole recording, so that every part of it is packed alike
        first, last = offsets[frames.first[[recording, recording + 1]]]
        ids = track[first:last]
        part = slice(max(start, first) - start, min(stop, last) - start)
        given = track[start:stop][part]
        if len(ids) and (ids.min() < NO_TRACK or ids.max() > _LARGEST_TRACK):
            known = np.unique(ids[ids != NO_TRACK])
            given = np.where(given == NO_TRACK, NO_TRACK, np.searchsorted(known, given))
        small[part] = given
    return small
