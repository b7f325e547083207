"""Similarity: how well the detections of a frame fit its pedestrians (paper, equations 1, 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.frames import maximin_frames, maximum_frames, nearest_frames
from nvcore.settings.params import Distance


@dataclass(frozen=True)
class Nearest:
    """Distance of each box to the other set, px, infinite if there is nothing to measure to.

    Attributes
    ----------
    truth
        Distance of each truth box to the counted detections; float64, shape (n_truth,).
    detections
        Distance of each detection to the pedestrians; float64, shape (n_det,).
    """

    truth: np.ndarray
    detections: np.ndarray


@dataclass(frozen=True)
class SetDistances:
    """Weighted MaxiMin distances of every frame.

    Attributes
    ----------
    d_miss
        D(G, S), the effect of misses, px, 0 is best; float64, shape (n_frames,).
    d_false
        D(S, G), the effect of false alarms, px, 0 is best; float64, shape (n_frames,).
    salient_row
        Truth row that attains D(G, S), -1 without pedestrians; int64, shape (n_frames,).
    """

    d_miss: np.ndarray
    d_false: np.ndarray
    salient_row: np.ndarray


def find_nearest(
    truth: BoxColumns,
    detections: BoxColumns,
    is_counted: np.ndarray,
    frames: FrameColumns,
    *,
    distance: Distance = "lateral",
) -> Nearest:
    """Compute each box's distance to the nearest member of the other set, frame by frame.

    The result does not depend on alpha, edge weight or the sigmoid, so that these can be changed
    live. `measure_matched` is the counterpart for ``pairing="matched"``.

    Parameters
    ----------
    truth, detections
        Boxes, px, sorted by frame.
    is_counted
        Detections that belong to S; bool, shape (n_det,).
    frames
        The listed frames.
    distance
        ``"lateral"``: |c_a - c_b|; ``"ground"``: Euclidean between foot points.
    """
    near_truth, near_detections = np.empty(len(truth)), np.empty(len(detections))
    over_ranges(
        nearest_frames,
        len(frames),
        *(truth.arrays, ~truth.ignore, detections.arrays, is_counted),
        *(distance == "ground", frames.arrays, near_truth, near_detections),
    )
    return Nearest(near_truth, near_detections)


def measure_matched(
    truth: BoxColumns,
    detections: BoxColumns,
    truth_det: np.ndarray,
    frames: FrameColumns,
    *,
    distance: Distance = "lateral",
) -> Nearest:
    """Compute each box's distance to its match, px, infinite without a match.

    With these distances a false alarm is never nearer to a pedestrian than the border, and cannot
    raise similarity.

    Parameters
    ----------
    truth_det
        Per truth box: row of its detection, -1 none; int64, shape (n_truth,).
    """
    near_truth, near_detections = np.full(len(truth), np.inf), np.full(len(detections), np.inf)
    rows = np.flatnonzero(truth_det >= 0)
    partners = truth_det[rows]
    width = frames.width[frames.recording[truth.frame_index[rows]]]
    centres = (
        np.clip(boxes.x[of] + 0.5 * boxes.w[of], 0, width)
        for boxes, of in ((truth, rows), (detections, partners))
    )
    apart = np.abs(np.subtract(*centres))
    if distance == "ground":
        feet = (truth.y + truth.h)[rows] - (detections.y + detections.h)[partners]
        apart = np.hypot(apart, feet)
    near_truth[rows] = near_detections[partners] = apart
    return Nearest(near_truth, near_detections)


def border_of(boxes: BoxColumns, frames: FrameColumns, edge_weight: np.ndarray) -> np.ndarray:
    """Compute the border of each box, px, 0 to W/2, shape (n,).

    The border limits the distance between a miss or false alarm and the other set:
    ``edge_weight * W/2 + (1 - edge_weight) * min(c, W - c)``

    Parameters
    ----------
    edge_weight
        Edge weight of each recording, 0 urban to 1 rural; float64, shape (n_recordings,).
    """
    recording = frames.recording[boxes.frame_index]
    width = frames.width[recording]
    centre = np.clip(boxes.x + 0.5 * boxes.w, 0, width)
    return border_at(centre, width, edge_weight[recording])


def border_at(
    centre: np.ndarray, width: float | np.ndarray, edge_weight: float | np.ndarray
) -> np.ndarray:
    """Compute the border at lateral positions, px, in the shape of `centre` (see `border_of`)."""
    border: np.ndarray = edge_weight * 0.5 * width + (1 - edge_weight) * np.minimum(
        centre, width - centre
    )
    return border


def miss_terms(
    truth: BoxColumns,
    k_truth: np.ndarray,
    nearest_truth: np.ndarray,
    frames: FrameColumns,
    edge_weight: np.ndarray,
) -> np.ndarray:
    """Compute each pedestrian's own term of D(G, S), px, NaN if ignored, shape (n_truth,).

    ``k(a) * min(border(a), nearest(a))``. 0 is best. D(G, S) of a frame is the largest of its
    terms.
    """
    border = border_of(truth, frames, edge_weight)
    return np.where(truth.ignore, np.nan, k_truth * np.minimum(border, nearest_truth))


def measure_sets(
    truth: BoxColumns,
    k_truth: np.ndarray,
    detections: BoxColumns,
    k_detections: np.ndarray,
    is_counted: np.ndarray,
    nearest: Nearest,
    frames: FrameColumns,
    *,
    edge_weight: np.ndarray,
    track: np.ndarray | None = None,
) -> SetDistances:
    """Compute the weighted MaxiMin distances D(G, S) and D(S, G) of every frame, px, 0 is best.

    ``D(A, B) = max over a of k(a) * min(border(a), min over b of d(a, b))``, ``D(empty, B) = 0``,
    ``border(a) = edge_weight * W/2 + (1 - edge_weight) * min(c_a, W - c_a)``.

    Parameters
    ----------
    edge_weight
        Edge weight of each recording, 0 urban to 1 rural; float64, shape (n_recordings,).
    track
        Track of each truth box for ties, if linked; None: ``truth.track``.

    References
    ----------
    Paper 11-0360, equation 1.
    """
    n_frames = len(frames)
    d_miss, d_false = np.empty(n_frames), np.empty(n_frames)
    salient_row = np.empty(n_frames, np.int64)
    over_ranges(
        maximin_frames,
        n_frames,
        *(truth.arrays, ~truth.ignore, k_truth, nearest.truth),
        *(truth.track if track is None else track, edge_weight),
        *(frames.arrays, d_miss, salient_row),
    )
    over_ranges(
        maximum_frames,
        n_frames,
        *(detections.arrays, is_counted, k_detections, nearest.detections),
        *(edge_weight, frames.arrays, d_false),
    )
    return SetDistances(d_miss, d_false, salient_row)


def salient_detection(
    detections: BoxColumns,
    k_detections: np.ndarray,
    is_member: np.ndarray,
    nearest: Nearest,
    frames: FrameColumns,
    row: int,
    *,
    edge_weight: np.ndarray,
) -> int:
    """Return the detection row that attains D(S, G) in a frame, or -1 without members.

    The counterpart of `SetDistances.salient_row`, computed on demand because the maximum alone is
    faster.

    Parameters
    ----------
    is_member
        Detections that belong to S; bool, shape (n_det,).
    row
        Row of the frames table.
    edge_weight
        Edge weight of each recording; float64, shape (n_recordings,).
    """
    d, argmax = np.empty(1), np.empty(1, np.int64)
    boxes = detections.arrays._replace(offsets=detections.offsets[row : row + 2])
    frame = frames.arrays._replace(recording=frames.recording[row : row + 1])
    maximin_frames(
        *(0, 1, boxes, is_member, k_detections, nearest.detections),
        *(detections.track, edge_weight, frame, d, argmax),
    )
    return int(argmax[0])


def trace_similarity(
    distances: SetDistances, frames: FrameColumns, *, alpha: float = 0.9
) -> np.ndarray:
    """Compute the similarity of every frame, 0 to 1 (best), float64, shape (n_frames,).

    ``M = 1 - (alpha * D(G, S) + (1 - alpha) * D(S, G)) / (W / 2)``. A frame with neither
    pedestrians nor detections has 1.

    References
    ----------
    Paper 11-0360, equation 2.
    """
    effect = alpha * distances.d_miss
    effect += (1 - alpha) * distances.d_false
    effect /= frames.half_width
    np.subtract(1, effect, out=effect)
    return np.maximum(effect, 0, out=effect)  # alpha and 1 - alpha can add up to just over 1


def smooth(values: np.ndarray, frames: FrameColumns, *, window: float = 1.0) -> np.ndarray:
    """Compute the moving mean over the frames within ``window / 2`` s, never across recordings.

    It compares frame numbers, so that a frame exactly half a window away always counts.
    """
    start, stop = frames.within(window)
    mean: np.ndarray = frames.sums(values, start, stop) / (stop - start)
    return mean


def runs_of(key: np.ndarray, recording: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return first and last row of every maximal run of equal `key` >= 0 within one recording.

    Parameters
    ----------
    key, recording
        Integers, shape (n_frames,); rows with a negative key belong to no run.

    Returns
    -------
    first, last
        int64, shape (n_runs,), both inclusive.
    """
    if not len(key):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    changes = (key[1:] != key[:-1]) | (recording[1:] != recording[:-1])
    first = np.flatnonzero(np.concatenate([[True], changes]))
    last = np.concatenate([first[1:] - 1, [len(key) - 1]])
    inside = key[first] >= 0
    return first[inside], last[inside]


def find_low_intervals(
    similarity: np.ndarray, frames: FrameColumns, *, low: float = 0.9
) -> pd.DataFrame:
    """Find maximal runs of consecutive listed frames with a similarity below `low`.

    Returns
    -------
    One row per interval: recording (row of the recordings), first_row, last_row (of the frames),
    duration_s, depth_s (sum of ``(low - M) * time step``, seconds; larger is worse),
    min_similarity and worst_row (the first frame that has it).
    """
    is_low = similarity < low
    first, last = runs_of(np.where(is_low, 0, -1), frames.recording)
    rate = frames.fps[frames.recording[first]] if len(first) else np.empty(0)
    low_rows = np.flatnonzero(is_low)
    if len(first):
        starts = np.searchsorted(low_rows, first)
        least = np.minimum.reduceat(similarity[low_rows], starts)  # no run is empty
        shortfall = np.add.reduceat((low - similarity[low_rows]) * frames.gap[low_rows], starts)
        lengths = last - first + 1
        is_least = similarity[low_rows] == np.repeat(least, lengths)
        hits = np.flatnonzero(is_least)
        worst = low_rows[hits[np.searchsorted(hits, starts)]]
    else:
        least, shortfall, worst = np.empty(0), np.empty(0), np.empty(0, np.int64)
    return pd.DataFrame(
        {
            "recording": frames.recording[first],
            "first_row": first,
            "last_row": last,
            "duration_s": (frames.passed[last + 1] - frames.passed[first]) / rate,
            "depth_s": shortfall / rate,
            "min_similarity": least,
            "worst_row": worst,
        }
    )


@dataclass(frozen=True)
class SimilaritySummary:
    """Aggregates of similarity over frames, NaN without frames.

    Attributes
    ----------
    mean, minimum, percentile_5
        In [0, 1], 1 is best.
    share_low
        Share of frames below `low`, 0 is best.
    """

    mean: float
    minimum: float
    percentile_5: float
    share_low: float


def _percentile_5(values: np.ndarray) -> float:
    """Return exactly ``np.percentile(values, 5)``, ten times as fast for short arrays."""
    place = 0.05 * (len(values) - 1)
    below = int(place)
    above, share = min(below + 1, len(values) - 1), place - below
    low, high = np.partition(values, (below, above))[[below, above]]
    step = high - low
    return float(low + step * share if share < 0.5 else high - step * (1 - share))


def summarise_similarity(similarity: np.ndarray, *, low: float = 0.9) -> SimilaritySummary:
    """Compute mean, minimum, 5th percentile (linear interpolation) and share of low frames."""
    if not len(similarity):
        return SimilaritySummary(np.nan, np.nan, np.nan, np.nan)
    return SimilaritySummary(
        mean=float(similarity.mean()),
        minimum=float(similarity.min()),
        percentile_5=_percentile_5(similarity),
        share_low=float(np.count_nonzero(similarity < low) / len(similarity)),
    )
