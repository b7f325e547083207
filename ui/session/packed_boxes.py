"""Binary encoding of boxes for the viewer.

`widgets/viewer/data/boxes.js` reads them.


Little endian: uint32 number of frames, uint32 number of boxes, uint32 offsets (those of the i-th
and the next one are the first and the last + 1 of the i-th frame's boxes; one more than there are
frames), then a column after the other, each padded with zeros to a multiple of 4 bytes. In a frame
the truth comes first, then X, then Y.
"""

from __future__ import annotations

import struct
from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.schema import TruthState
from nvcore.tables.boxes.states import TruthBoxes, gather_boxes

SOURCE_TRUTH: Final = 0
SOURCE_X: Final = 1
SOURCE_Y: Final = 2

# bits of the state of a truth box; detections have their `DetectionState`
BIT_IGNORE: Final = 1
BIT_MATCHED_X: Final = 2
BIT_MATCHED_Y: Final = 4
BIT_RELEVANT: Final = 8
BIT_SALIENT_X: Final = 16
BIT_SALIENT_Y: Final = 32

COLUMNS: Final = {
    "x": "<f4",  # px
    "y": "<f4",
    "w": "<f4",
    "h": "<f4",
    "score": "<f4",  # NaN: none
    "track": "<i4",  # as in `nvcore.tables.boxes.states.TruthBoxes`
    "source": "|u1",  # SOURCE_TRUTH, SOURCE_X or SOURCE_Y
    "state": "|u1",  # truth: the BIT_ constants, added; detections: their `DetectionState`
}


def pack_boxes(result: Result, row_start: int, row_stop: int) -> bytes:
    """Boxes of frames ``row_start:row_stop`` (rows of the frames table) with their states."""
    gathered = gather_boxes(result, row_start, row_stop)
    sources = (gathered.truth, gathered.x, gathered.y)
    states = (_truth_bits(gathered.truth), gathered.x.state, gathered.y.state)
    frame = np.concatenate([boxes.frame for boxes in sources])
    xywh = np.concatenate([boxes.xywh for boxes in sources])
    columns = {
        **{name: xywh[:, i] for i, name in enumerate("xywh")},
        "score": np.concatenate([boxes.score for boxes in sources]),
        "track": np.concatenate([boxes.track for boxes in sources]),
        "source": np.repeat(
            [SOURCE_TRUTH, SOURCE_X, SOURCE_Y], [len(boxes.frame) for boxes in sources]
        ),
        "state": np.concatenate(states),
    }
    n_frames = row_stop - row_start
    offsets = np.concatenate([[0], np.cumsum(np.bincount(frame, minlength=n_frames))])
    by_frame = np.argsort(frame, kind="stable")
    parts = [struct.pack("<II", n_frames, len(frame)), offsets.astype("<u4").tobytes()]
    for name, dtype in COLUMNS.items():
        content = columns[name][by_frame].astype(dtype).tobytes()
        parts += [content, bytes(-len(content) % 4)]
    return b"".join(parts)


def _truth_bits(truth: TruthBoxes) -> np.ndarray:
    bits = np.zeros(len(truth.frame), np.uint8)
    for is_set, bit in (
        (truth.state_x == TruthState.NOT_JUDGED, BIT_IGNORE),
        (truth.state_x == TruthState.MATCHED, BIT_MATCHED_X),
        (truth.state_y == TruthState.MATCHED, BIT_MATCHED_Y),
        (truth.is_relevant, BIT_RELEVANT),
        (truth.is_salient_x, BIT_SALIENT_X),
        (truth.is_salient_y, BIT_SALIENT_Y),
    ):
        bits[is_set] |= bit
    return bits
