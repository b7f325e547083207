"""Saliency: how much a recording's misses will annoy the driver (second metric of the paper)."""

from __future__ import annotations

import numpy as np
import pandas as pd
import scipy

from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.encounters import RELEVANT_K, Encounters
from nvcore.metrics.similarity import SetDistances, miss_terms
from nvcore.settings.params import Params

EVENT_COLUMNS = (
    "recording",
    "encounter",
    "track",
    "first_row",
    "last_row",
    "duration_s",
    "relevant_s",
    "weight_s",
    "tau",
    "rest_s",
    "recency",
    "saliency_s",
)


def qualify(distances: SetDistances, frames: FrameColumns, *, tolerance: float) -> np.ndarray:
    """Return the truth row that attains D(G, S) in each frame, -1 within tolerance, int64.

    A pedestrian only qualifies if ``D(G, S) > tolerance * W/2``. Anything below is localisation
    noise, not a miss.
    """
    least = tolerance * frames.half_width
    return np.where(distances.d_miss > least, distances.salient_row, -1)


def qualify_each(
    truth: BoxColumns,
    terms: np.ndarray,
    encounters: Encounters,
    frames: FrameColumns,
    *,
    tolerance: float,
) -> np.ndarray:
    """Return the truth rows whose own term exceeds the tolerance, by encounter and frame, int64.

    The term must be greater than ``tolerance * W/2``. A track that occurs twice in a frame
    counts once there, with the larger term.

    Parameters
    ----------
    terms
        Term of each truth box (`nvcore.metrics.similarity.miss_terms`), px; float64, (n_truth,).
    """
    rows = encounters.order
    least = tolerance * frames.half_width[encounters.frame_index]
    rows = rows[terms[rows] > least]
    encounter, frame_row = encounters.encounter_of[rows], truth.frame_index[rows]
    is_twin = (encounter[1:] == encounter[:-1]) & (frame_row[1:] == frame_row[:-1])
    if is_twin.any():
        rows = rows[np.lexsort((-terms[rows], frame_row, encounter))]
        encounter, frame_row = encounters.encounter_of[rows], truth.frame_index[rows]
        is_twin = (encounter[1:] == encounter[:-1]) & (frame_row[1:] == frame_row[:-1])
    unique: np.ndarray = rows[np.concatenate([[True], ~is_twin])[: len(rows)]]
    return unique


def recency_weight(tau: np.ndarray, rest_s: np.ndarray, params: Params) -> np.ndarray:
    """Return an event's weight in (0, 1). Later ends weigh more, as drivers remember the end.

    ``1 / (1 + exp(-(tau - recency_midpoint) / recency_spread))``, or with
    ``recency_unit="seconds"`` ``1 / (1 + exp((rest_s - recency_midpoint_s) / recency_spread_s))``.

    Parameters
    ----------
    tau
        Share of the recording (or encounter) that has passed at the end of the event.
    rest_s
        Seconds from the end of the event to the end of the recording (or encounter).
    """
    if params.recency_unit == "seconds":
        weight: np.ndarray = scipy.special.expit(
            (params.recency_midpoint_s - rest_s) / params.recency_spread_s
        )
    else:
        weight = scipy.special.expit((tau - params.recency_midpoint) / params.recency_spread)
    return weight


def find_events(
    truth: BoxColumns,
    k_truth: np.ndarray,
    nearest_truth: np.ndarray,
    d_miss: np.ndarray,
    salient_row: np.ndarray,
    track: np.ndarray,
    encounters: Encounters,
    frames: FrameColumns,
    edge_weight: np.ndarray,
    params: Params,
    *,
    k_miss: np.ndarray | None = None,
) -> pd.DataFrame:
    """Find saliency events: maximal runs of listed frames in which one pedestrian qualifies.

    ``saliency = weight * recency`` in seconds, 0 is best. The weight is the event's duration, or
    with ``saliency_weight="risk"`` the sum of ``D(G, S) / (W/2) * time step`` over its frames.
    With ``saliency_of="each"`` every pedestrian qualifies by their own term, which then
    replaces D(G, S).

    Parameters
    ----------
    k_truth, nearest_truth, track
        Proximity weight, distance to the system's detections (px) and track of each truth row;
        shape (n_truth,).
    d_miss, salient_row
        D(G, S) of each frame, px, and the row that qualifies (`qualify`); shape (n_frames,).
    edge_weight
        Edge weight of each recording; float64, shape (n_recordings,).
    k_miss
        Weight of missing each truth row, shape (n_truth,); None: `k_truth`.

    Returns
    -------
    Columns `EVENT_COLUMNS`, in order of time. relevant_s: time in which the pedestrian counts
    (``k >= 0.5``); tau, rest_s: share of the recording that has passed at the end of the event's
    last frame, and seconds left (with ``saliency_scope="encounter"``, of the encounter). No miss,
    no truth: no rows.

    References
    ----------
    Paper 11-0360, metric of saliency.
    """
    if params.saliency_of == "each":
        weights = k_truth if k_miss is None else k_miss
        terms = miss_terms(truth, weights, nearest_truth, frames, edge_weight)
        boxes = qualify_each(truth, terms, encounters, frames, tolerance=params.tolerance)
        rows, effect = truth.frame_index[boxes], terms[boxes]
    else:
        rows = np.flatnonzero(salient_row >= 0)
        boxes, effect = salient_row[rows], d_miss[rows]
    encounter = encounters.encounter_of[boxes]
    # an encounter lies in one recording: a run that ends with the recording changes it too
    goes_on = (rows[1:] == rows[:-1] + 1) & (encounter[1:] == encounter[:-1])
    starts = np.flatnonzero(np.concatenate([[True], ~goes_on])[: len(rows)])
    ends = np.concatenate([starts[1:] - 1, [len(rows) - 1]])[: len(starts)]
    first, last, event_encounter = rows[starts], rows[ends], encounter[starts]
    recording = frames.recording[first]
    rate, passed = frames.fps[recording], frames.passed
    if params.saliency_scope == "encounter":
        start, end = encounters.first_row[event_encounter], encounters.last_row[event_encounter]
    else:
        start, end = frames.first[recording], frames.first[recording + 1] - 1
    whole = passed[end + 1] - passed[start]
    duration_s = (passed[last + 1] - passed[first]) / rate
    if params.saliency_weight == "risk":
        weight_s = _sum(effect / frames.half_width[rows] * frames.gap[rows], starts) / rate
    else:
        weight_s = duration_s
    tau = (passed[last + 1] - passed[start]) / whole
    rest_s = (passed[end + 1] - passed[last + 1]) / rate
    recency = recency_weight(tau, rest_s, params)
    events = pd.DataFrame(
        {
            "recording": recording,
            "encounter": event_encounter,
            "track": track[boxes[starts]],
            "first_row": first,
            "last_row": last,
            "duration_s": duration_s,
            "relevant_s": _sum(frames.gap[rows] * (k_truth[boxes] >= RELEVANT_K), starts) / rate,
            "weight_s": weight_s,
            "tau": tau,
            "rest_s": rest_s,
            "recency": recency,
            "saliency_s": weight_s * recency,
        },
        columns=list(EVENT_COLUMNS),
    )
    if params.saliency_of == "each":
        events = events.sort_values(["first_row", "encounter"], ignore_index=True)
    return events


def _sum(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Sum the values of each event. Events are not empty."""
    sums: np.ndarray = np.add.reduceat(values, starts) if len(starts) else np.empty(0)
    return sums


def saliency_by_recording(events: pd.DataFrame, n_recordings: int, *, aggregate: str) -> np.ndarray:
    """Return each recording's saliency, seconds (0 is best), float64, (n_recordings,).

    This is its most salient event ("max") or the sum of all ("sum"), or 0 without any event.
    """
    return aggregate_events(
        events["recording"].to_numpy(dtype=np.int64),
        events["saliency_s"].to_numpy(dtype=float),
        n_recordings,
        aggregate=aggregate,
    )


def aggregate_events(
    recording: np.ndarray, saliency_s: np.ndarray, n_recordings: int, *, aggregate: str
) -> np.ndarray:
    """Aggregate the saliency of events to recordings, see `saliency_by_recording`."""
    saliency = np.zeros(n_recordings)
    add = np.maximum if aggregate == "max" else np.add
    add.at(saliency, recording, saliency_s)
    return saliency


def mean_saliency(events: pd.DataFrame, frames: FrameColumns, *, aggregate: str) -> float:
    """Return the mean saliency over recordings with frames, seconds, or NaN if none has frames.

    References
    ----------
    ``docs/decisions/004-saliency-over-recordings.md``.
    """
    has_frames = np.diff(frames.first) > 0
    if not has_frames.any():
        return float("nan")
    saliency = saliency_by_recording(events, len(has_frames), aggregate=aggregate)
    return float(saliency[has_frames].mean())
