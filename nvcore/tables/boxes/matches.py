"""Table with one row per box of truth, X and Y: its match, whether it counts, its weight."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.output.parquet import to_parquet_bytes
from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.columns import BoxColumns
from nvcore.dataset.schema import (
    NO_TRACK,
    UNKNOWN_OCCLUSION,
    DetectionState,
    TruthState,
    categories_of,
    integers_of,
)
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.metrics.matching import iou_of_pairs
from nvcore.metrics.proximity import in_use
from nvcore.metrics.similarity import border_of, miss_terms
from nvcore.tables.column import CellKind, Column

MATCHES: Final = "matches.parquet"
"""Name of the file."""

FRAMES_AT_ONCE: Final = 50_000
SOURCES: Final = ("truth", "x", "y")
OF_INPUTS: Final = ("distance_m", "occlusion", "file", "line")
"""Columns copied unchanged from the inputs."""

_NONE = "detection of the other system"
_OF_BOTH = (
    Column(
        "outcome",
        CellKind.TEXT,
        "",
        "Truth: `matched`, `missed`, or `not_judged` (ignore region). Detection: `matched`, "
        "`false_alarm`, `absorbed` (by an ignore region), or `below` (the threshold).",
        empty=_NONE,
    ),
    Column(
        "match",
        CellKind.INTEGER,
        "",
        "`box` of the partner: the system's in rows of the truth, the truth's in those of the "
        "system.",
        empty=f"matched with none; {_NONE}",
    ),
    Column(
        "iou",
        CellKind.NUMBER,
        "0 to 1",
        "Overlap with the partner: intersection over union.",
        empty=f"matched with none; {_NONE}",
    ),
    Column(
        "nearest_px",
        CellKind.NUMBER,
        "px",
        "Distance to the nearest box of the other side that counts; strict pairing: to the "
        "partner.",
        empty=f"{{nobody}} is there; the box is not judged; {_NONE}",
    ),
    Column(
        "term",
        CellKind.NUMBER,
        "0 to 1",
        "k * the smaller of `border_px` and `nearest_px`, over half the width. The largest of a "
        "frame is `d_miss` (rows of the truth) or `d_false` of `frames.csv`.",
        "low",
        f"the box is not judged; {_NONE}",
    ),
)
MATCH_COLUMNS: Final[tuple[Column, ...]] = (
    Column("source", CellKind.TEXT, "", "Whose box it is: `truth`, `x` or `y`."),
    Column("box", CellKind.INTEGER, "", "Number of the box among those of its source, from 0."),
    Column("recording", CellKind.TEXT, "", "Name of the recording."),
    Column("frame", CellKind.INTEGER, "", "Frame number, as in `frames.csv`."),
    Column("x", CellKind.NUMBER, "px", "Left edge of the box."),
    Column("y", CellKind.NUMBER, "px", "Upper edge of the box."),
    Column("w", CellKind.NUMBER, "px", "Width of the box."),
    Column("h", CellKind.NUMBER, "px", "Height of the box."),
    Column("score", CellKind.NUMBER, "", "Score of the detection.", empty="it has none"),
    Column(
        "track",
        CellKind.INTEGER,
        "",
        "Track: of {a_one} as in `encounters.csv`, of a detection as in its file.",
        empty="it has none",
    ),
    Column("distance_m", CellKind.NUMBER, "m", "Distance from the camera.", empty="not stated"),
    Column(
        "occlusion",
        CellKind.INTEGER,
        "",
        "How much of the {one} is hidden: 0 nothing, 1 a part, 2 most.",
        empty="not stated",
    ),
    Column(
        "counts",
        CellKind.TRUTH_VALUE,
        "",
        "Truth: whether it is {a_one} near enough to count (k >= 0.5). Detection: whether it "
        "is matched or a false alarm.",
    ),
    Column("k", CellKind.NUMBER, "0 to 1", "Proximity weight: 0 far, 1 near."),
    Column("border_px", CellKind.NUMBER, "px", "The most that the box can count for."),
    Column(
        "cost",
        CellKind.NUMBER,
        "0 to 1",
        "What missing the {one} costs: k * `border_px` over half the width.",
        empty="ignore region, or a detection",
    ),
    *(replace(column, name=f"{column.name}_{side}") for side in "xy" for column in _OF_BOTH),
    Column("file", CellKind.TEXT, "", "File that it stands in.", empty="it stands in no file"),
    Column(
        "line",
        CellKind.INTEGER,
        "",
        "Line of that file; JSON counts records, tables from 1.",
        empty="it stands in no file",
    ),
)
"""Columns of `matches_table`."""

_TRUTH_OUTCOMES: Final = tuple(state.name.lower() for state in TruthState)
_DETECTION_OUTCOMES: Final = tuple(state.name.lower() for state in DetectionState)
_OUTCOMES: Final = tuple(dict.fromkeys((*_TRUTH_OUTCOMES, *_DETECTION_OUTCOMES)))


def matches_table(result: Result, rows: slice = slice(None)) -> pd.DataFrame:
    """Return one row per box in an evaluated frame, by recording and frame: truth, then X, then Y.

    Detections below the threshold and ignore regions are included; `outcome_x` and `outcome_y` have
    their outcome. Columns are those of `MATCH_COLUMNS`.

    Parameters
    ----------
    rows
        Rows of the frames table to include.
    """
    start, stop, _ = rows.indices(len(result.dataset.frames))
    parts = [
        _truth_rows(result, start, stop),
        *(_system_rows(result, *side, start, stop) for side in result.sides),
    ]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    order = np.argsort(columns.pop("row"), kind="stable")
    return _finished(result, {name: values[order] for name, values in columns.items()})


def matches_parquet(result: Result) -> bytes:
    """Return `matches_table` as Parquet, computed in chunks of frames to save memory."""
    starts = range(0, max(len(result.dataset.frames), 1), FRAMES_AT_ONCE)
    return to_parquet_bytes(
        matches_table(result, slice(start, start + FRAMES_AT_ONCE)) for start in starts
    )


def _finished(result: Result, columns: dict[str, np.ndarray]) -> pd.DataFrame:
    """Convert the table of numbers to names, with unknown values missing."""
    inputs, names = result.dataset.inputs["file"], result.dataset.recordings["name"]
    has_line = columns["line"] > 0
    file = np.where(has_line & (columns["file"] < len(inputs)), columns["file"], -1)
    made: dict[str, Any] = {
        **columns,
        "source": categories_of(columns["source"], SOURCES),
        "recording": _texts(columns["recording"], names),
        "track": integers_of(columns["track"], columns["track"] != NO_TRACK),
        "occlusion": integers_of(columns["occlusion"], columns["occlusion"] != UNKNOWN_OCCLUSION),
        "file": _texts(file, inputs),
        "line": integers_of(columns["line"], has_line),
    }
    for side in "xy":
        match = columns[f"match_{side}"]
        made[f"match_{side}"] = integers_of(match, match >= 0)
        codes = columns[f"outcome_{side}"]
        made[f"outcome_{side}"] = categories_of(codes, _OUTCOMES)
    return pd.DataFrame({column.name: made[column.name] for column in MATCH_COLUMNS})


def _texts(codes: np.ndarray, texts: pd.Series[str]) -> Any:
    """Return texts by their numbers, -1 for none. Two numbers may have the same text."""
    number, unique = pd.factorize(texts.to_numpy(dtype=object))
    return categories_of(np.append(number, -1)[codes], unique)


def _common(result: Result, boxes: BoxColumns, source: int, first: int) -> dict[str, np.ndarray]:
    """Return the columns common to all sources, with empty columns about X and Y."""
    frames, n = result.dataset.frame_columns, len(boxes)
    rows = slice(boxes.first_row, boxes.first_row + n)
    columns = {
        "row": boxes.frame_index,
        "source": np.full(n, source, np.int8),
        "box": np.arange(first, first + n),
        "recording": frames.recording[boxes.frame_index],
        "frame": frames.frame[boxes.frame_index],
        **{name: getattr(boxes, name) for name in (*"xywh", "score", "track")},
        "border_px": border_of(boxes, frames, _edge_weight(result)),
        "cost": np.full(n, np.nan),
        **{name: result.dataset.boxes[name].to_numpy()[rows] for name in OF_INPUTS},
    }
    for side in "xy":
        columns |= {
            f"outcome_{side}": np.full(n, -1, np.int8),
            f"match_{side}": np.full(n, -1),
            **{f"{name}_{side}": np.full(n, np.nan) for name in ("iou", "nearest_px", "term")},
        }
    return columns


def _truth_rows(result: Result, start: int, stop: int) -> dict[str, np.ndarray]:
    dataset, frames = result.dataset, result.dataset.frame_columns
    rows, truth = dataset.truth.rows_of(start, stop), dataset.truth.of_frames(start, stop)
    half_width, k = frames.half_width[truth.frame_index], result.k_truth.k[rows]
    columns = _common(result, truth, 0, rows.start)
    for side, system in result.sides:
        partner, nearest = system.matches.truth_det[rows], system.nearest.truth[rows]
        weights = result.k_miss[rows]
        term = miss_terms(truth, weights, nearest, frames, _edge_weight(result)) / half_width
        state = np.where(partner >= 0, TruthState.MATCHED, TruthState.MISSED)
        state = np.where(truth.ignore, TruthState.NOT_JUDGED, state)
        columns |= {
            f"outcome_{side}": _codes(_TRUTH_OUTCOMES)[state],
            f"match_{side}": partner,
            f"iou_{side}": _iou(truth, dataset.system(system.name), partner),
            f"nearest_px_{side}": _known(nearest, ~truth.ignore),
            f"term_{side}": term,
        }
    return columns | {
        "track": result.tracks.track[rows],
        "counts": (k >= RELEVANT_K) & ~truth.ignore,
        "k": k,
        "cost": _known(result.cost[rows], ~truth.ignore),
    }


def _system_rows(
    result: Result, side: str, system: SystemResult, start: int, stop: int
) -> dict[str, np.ndarray]:
    dataset, frames = result.dataset, result.dataset.frame_columns
    detections = dataset.system(system.name)
    rows, boxes = detections.rows_of(start, stop), detections.of_frames(start, stop)
    columns = _common(result, boxes, SOURCES.index(side), rows.start)
    k, state = system.weights.k[rows], system.matches.state[rows]
    is_counted = (state == DetectionState.MATCHED) | (state == DetectionState.FALSE_ALARM)
    nearest, partner = system.nearest.detections[rows], system.matches.det_truth[rows]
    term = k * np.minimum(columns["border_px"], nearest) / frames.half_width[boxes.frame_index]
    return columns | {
        "counts": is_counted,
        "k": k,
        f"outcome_{side}": _codes(_DETECTION_OUTCOMES)[state],
        f"match_{side}": partner,
        f"iou_{side}": _iou(boxes, dataset.truth, partner),
        f"nearest_px_{side}": _known(nearest, is_counted),
        f"term_{side}": np.where(is_counted, term, np.nan),
    }


def _edge_weight(result: Result) -> np.ndarray:
    return in_use(result.params, "edge_weight", result.dataset.frame_columns)


def _codes(outcomes: tuple[str, ...]) -> np.ndarray:
    return np.array([_OUTCOMES.index(outcome) for outcome in outcomes], np.int8)


def _known(values: np.ndarray, is_judged: np.ndarray) -> np.ndarray:
    return np.where(is_judged & np.isfinite(values), values, np.nan)


def _iou(boxes: BoxColumns, others: BoxColumns, partner: np.ndarray) -> np.ndarray:
    """Return the IoU of each box with its partner, NaN for none (-1)."""
    iou = np.full(len(boxes), np.nan)
    rows = np.flatnonzero(partner >= 0)
    of = partner[rows]
    iou[rows] = iou_of_pairs(
        (boxes.x[rows], boxes.y[rows], boxes.w[rows], boxes.h[rows]),
        (others.x[of], others.y[of], others.w[of], others.h[of]),
    )
    return iou
