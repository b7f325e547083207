"""Binary encodings of a comparison: boxes for the viewer, columns for sliders being dragged."""

from __future__ import annotations

import hashlib
import json
import struct
from dataclasses import replace
from itertools import chain
from typing import Any, Final

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import weigh_misses
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import DetectionState, TruthState
from nvcore.metrics.matching import match_system
from nvcore.metrics.proximity import in_use
from nvcore.settings.params import Params
from nvcore.settings.stages import DISTANCES, ENCOUNTERS, SEVERITY
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
LIVE: Final = (
    *("alpha", "midpoint", "spread", "midpoint_m", "spread_m"),
    *("edge_weight", "low", "threshold_x", "threshold_y"),
)
"""Settings whose effect the browser can compute by itself."""
MOST_BYTES: Final = 100_000_000
"""Size limit of a packed comparison. Above it, only the server computes."""
KINDS: Final = {"f": "<f8", "i": "<i4"}
"""Column types: float64 or int32."""


def pack_boxes(result: Result, row_start: int, row_stop: int) -> bytes:
    """Encode the boxes of frames ``row_start:row_stop`` (rows of the frames table) with states.

    `widgets/viewer/data/boxes.js` reads them. Little endian: uint32 number of frames F, uint32
    number of boxes, F + 1 uint32 offsets (frame i has the boxes from offset i up to offset i + 1),
    then one column after the other, each padded with zeros to a multiple of 4 bytes. Within a
    frame the truth comes first, then X, then Y.
    """
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


def version_of(result: Result) -> str:
    """Return a hash of everything that the result of `pack_comparison` depends on."""
    defaults: dict[str, Any] = {name: getattr(Params(), name) for name in LIVE}
    fixed = replace(result.params.only_for(DISTANCES, ENCOUNTERS, SEVERITY), **defaults)
    text = f"{result.dataset.fingerprint}{fixed!r}\0{result.x.name}\0{result.y.name}"
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def n_bytes(result: Result) -> int:
    """Estimate the size of the result of `pack_comparison`, bytes."""
    dataset = result.dataset
    n_boxes = sum(len(dataset.system(system.name)) for _, system in result.sides)
    return 36 * (n_boxes + len(dataset.truth)) + 32 * len(dataset.frames)


def can_pack(result: Result) -> bool:
    """Whether the comparison is small enough to be sent."""
    return n_bytes(result) <= MOST_BYTES


def has_mixed_scores(result: Result) -> bool:
    """Whether some detections of X or Y lack a score, so that a threshold may change matches."""
    scores = (result.dataset.system(system.name).score for _, system in result.sides)
    return any(0 < np.count_nonzero(np.isnan(score)) < len(score) for score in scores)


def pack_comparison(result: Result) -> bytes:
    """Encode recordings, frames, pedestrians and the detections of X and Y as columns.

    Ignored truth boxes, and detections that they absorb, are left out. The result does not depend
    on the settings in `LIVE`: detections are matched without a threshold in descending score, so a
    threshold does not change the matches above it.

    `shell/live/comparison.js` reads it. Little endian: uint32 length of a JSON header, the header,
    zeros up to a multiple of 8 bytes, then the columns, each padded to 8 bytes as well. The header
    gives each column's name, kind, first byte after the header, and length.
    """
    dataset, params, frames = result.dataset, result.params, result.dataset.frame_columns
    unset = replace(params, midpoint=None, spread=None, edge_weight=None)
    columns: dict[str, np.ndarray] = {
        "first": frames.first,
        **{name: getattr(frames, name) for name in ("width", "fps")},
        **{name: in_use(unset, name, frames) for name in ("midpoint", "spread", "edge_weight")},
        "horizon": _horizon(result),
        "frame": frames.frame.astype(float),
        "gap": frames.gap,
        "encounter_recording": result.encounters.recording,
    }
    is_counted = ~dataset.truth.ignore
    columns |= _boxes("truth", dataset.truth, is_counted, result)
    columns["truth_encounter"] = result.encounters.encounter_of[is_counted]
    columns["truth_factor"] = weigh_misses(np.ones(len(dataset.truth)), dataset, params)[is_counted]
    new_row = np.cumsum(is_counted) - 1
    for letter, system in result.sides:
        matches = match_system(dataset, system.name, None, params)
        is_member = matches.state != DetectionState.ABSORBED
        detections = dataset.system(system.name)
        columns |= _boxes(letter, detections, is_member, result)
        columns[f"{letter}_score"] = detections.score[is_member]
        partner = matches.det_truth[is_member]
        columns[f"{letter}_match"] = np.where(partner < 0, -1, new_row[partner])
    return _encode(columns)


def _horizon(result: Result) -> np.ndarray:
    """Return the horizon's row by recording, px. It is 0 if proximity is not measured from it."""
    frames = result.dataset.frame_columns
    if result.params.proximity == "horizon":
        return in_use(result.params, "horizon", frames)
    return np.zeros(len(frames.fps))


def _boxes(
    name: str, boxes: BoxColumns, is_kept: np.ndarray, result: Result
) -> dict[str, np.ndarray]:
    """Return columns of boxes: their offsets by frame, and the inputs of their weight."""
    params, frames = result.params, result.dataset.frame_columns
    own_boxes = boxes.only(is_kept)
    recording = frames.recording[own_boxes.frame_index]
    columns = {
        "offsets": own_boxes.offsets,
        "size": own_boxes.y + own_boxes.h if params.proximity == "horizon" else own_boxes.h,
        "centre": np.clip(own_boxes.x + 0.5 * own_boxes.w, 0, frames.width[recording]),
    }
    if params.proximity == "distance":
        columns["metres"] = (result.weighed_truth if name == "truth" else boxes).distance_m[is_kept]
    if params.distance == "ground":
        columns["foot"] = own_boxes.y + own_boxes.h
    return {f"{name}_{column}": values for column, values in columns.items()}


def _encode(columns: dict[str, np.ndarray]) -> bytes:
    header, parts, start = [], [], 0
    for name, values in columns.items():
        kind = "f" if values.dtype.kind == "f" else "i"
        content = values.astype(KINDS[kind]).tobytes()
        parts.append((content, bytes(-len(content) % 8)))
        header.append([name, kind, start, len(values)])
        start += sum(map(len, parts[-1]))
    text = json.dumps(header).encode()
    lead = (struct.pack("<I", len(text)), text, bytes(-(4 + len(text)) % 8))
    return b"".join(chain(lead, *parts))
