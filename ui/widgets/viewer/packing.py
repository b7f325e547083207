"""Compact encodings of a recording's arrays for the browser: runs, spans, minima, base64."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from nvcore.metrics.cost_map import CostMap
from nvcore.settings.objects import PEDESTRIAN, Objects

MOST_BUCKETS = 2000
"""Maximum number of points of a trace. The strip is not wider than this on any screen."""

TIME_TOLERANCE_S = 1e-6


def pack(values: Any, dtype: str) -> str:
    """Encode values as little-endian binary numbers in base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=f"<{dtype}").tobytes()).decode()


def find_runs(frames: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Split frame numbers into runs of a constant step.

    Parameters
    ----------
    frames : array of int, shape (n,)
        Frame numbers in rising order.

    Returns
    -------
    starts, firsts, steps : arrays, shape (runs,)
        First row of each run, its frame number, and the step to the next frame.
    """
    frames = np.asarray(frames)
    if len(frames) == 0:
        empty = np.empty(0, dtype=np.int64)
        return empty, empty, empty
    steps = np.diff(frames)
    # a run starts at the first row, and after every step that differs from the previous one
    bends = np.flatnonzero(steps[1:] != steps[:-1]) + 1
    starts = np.concatenate(([0], bends)).astype(np.int64)
    step_at = np.append(steps, 1)
    return starts, frames[starts], step_at[starts]


def find_spans(mask: np.ndarray) -> np.ndarray:
    """Return the rows where the mask is True as (start, stop) pairs, shape (spans, 2)."""
    edges = np.diff(np.concatenate(([0], np.asarray(mask, dtype=np.int8), [0])))
    return np.column_stack((np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)))


def decimate_minima(similarity: np.ndarray, n_rows: int) -> tuple[np.ndarray, int]:
    """Return the lowest similarity of each bucket of rows, and the number of rows per bucket.

    The minimum keeps short dips visible. A bucket without any defined value is NaN.

    Parameters
    ----------
    similarity : array of float, shape (n_rows,)
        Similarity of one system per row, 0..1, NaN if undefined.
    n_rows : int
        Rows of the recording.
    """
    bucket_rows = max(1, -(-n_rows // MOST_BUCKETS))
    buckets = -(-n_rows // bucket_rows)
    padded = np.full(buckets * bucket_rows, np.nan, dtype=np.float32)
    padded[:n_rows] = similarity
    return np.fmin.reduce(padded.reshape(buckets, bucket_rows), axis=1), bucket_rows


def pack_frames(frames: np.ndarray) -> dict[str, str]:
    """Encode frame numbers for the browser, as one run if they are regular."""
    starts, firsts, steps = find_runs(frames)
    return {"starts": pack(starts, "i4"), "firsts": pack(firsts, "f8"), "steps": pack(steps, "f8")}


def pack_times(times_s: np.ndarray, frames: np.ndarray, fps: float) -> dict[str, Any]:
    """Encode times for the browser, as an offset only if they follow from frame number and rate."""
    times_s = np.asarray(times_s, dtype=np.float64)
    if len(times_s) and fps > 0:
        offsets = times_s - np.asarray(frames) / fps
        if np.abs(offsets - offsets[0]).max() < TIME_TOLERANCE_S:
            return {"offset": float(offsets[0])}
    return {"every_row": pack(times_s, "f8")}


def pack_cost(cost: CostMap, objects: Objects = PEDESTRIAN) -> dict[str, str]:
    """Encode a cost map for the browser, which multiplies weight and border and interpolates."""
    text = objects.say(cost.text)
    return {"k": pack(cost.k, "f4"), "border": pack(cost.border, "f4"), "text": text}
