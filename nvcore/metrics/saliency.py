"""Saliency: how much the misses of a recording will annoy the driver (paper, second metric)."""

from __future__ import annotations

import numpy as np
import pandas as pd
from scipy.special import expit

from nvcore.columns import FrameColumns
from nvcore.metrics.similarity import SetDistances
from nvcore.params import Params

EVENT_COLUMNS = (
    "recording",
    "encounter",
    "track",
    "first_row",
    "last_row",
    "duration_s",
    "tau",
    "recency",
    "saliency_s",
)


def qualify(distances: SetDistances, frames: FrameColumns, *, tolerance: float) -> np.ndarray:
    """Truth row of the pedestrian that qualifies in each frame, -1 none; int64, (n_frames,).

    The pedestrian that attains D(G, S), if ``D(G, S) > tolerance * W/2``: below that it is
    localisation noise, not a miss.
    """
    least = tolerance * 0.5 * frames.width[frames.recording]
    return np.where(distances.d_miss > least, distances.salient_row, -1)


def recency_weight(tau: np.ndarray, params: Params) -> np.ndarray:
    """Weight in (0, 1) of an event that ends at `tau`; larger later: drivers remember the end.

    ``1 / (1 + exp(-(tau - recency_midpoint) / recency_spread))``
    """
    weight: np.ndarray = expit((tau - params.recency_midpoint) / params.recency_spread)
    return weight


def find_events(
    salient_row: np.ndarray,
    encounter_of: np.ndarray,
    track: np.ndarray,
    encounter_rows: tuple[np.ndarray, np.ndarray],
    frames: FrameColumns,
    params: Params,
) -> pd.DataFrame:
    """Saliency events: maximal runs of listed frames in which one pedestrian qualifies.

    ``saliency = duration * recency`` in seconds, 0 is best. `tau` is the fraction of the recording
    (or, with ``saliency_scope="encounter"``, of the encounter) that has passed at the end of the
    event's last frame.

    Parameters
    ----------
    salient_row
        From `qualify`.
    encounter_of
        Encounter of each truth row, -1 none; int64, shape (n_truth,).
    track
        Track of each truth row; int64, shape (n_truth,).
    encounter_rows
        First and last frame row of every encounter.

    Returns
    -------
    Columns `EVENT_COLUMNS`, in order of time. No miss, no truth: no rows.

    References
    ----------
    Paper 11-0360, metric of saliency.
    """
    rows = np.flatnonzero(salient_row >= 0)
    encounter = encounter_of[salient_row[rows]]
    # an encounter lies in one recording: a run that ends with the recording changes it too
    goes_on = (rows[1:] == rows[:-1] + 1) & (encounter[1:] == encounter[:-1])
    starts = np.flatnonzero(np.concatenate([[True], ~goes_on])[: len(rows)])
    ends = np.concatenate([starts[1:] - 1, [len(rows) - 1]])[: len(starts)]
    first, last, event_encounter = rows[starts], rows[ends], encounter[starts]
    recording = frames.recording[first]
    rate = frames.fps[recording]
    passed = frames.passed
    if params.saliency_scope == "encounter":
        start, end = encounter_rows[0][event_encounter], encounter_rows[1][event_encounter]
    else:
        start, end = frames.first[recording], frames.first[recording + 1] - 1
    whole = passed[end + 1] - passed[start]
    tau = (passed[last + 1] - passed[start]) / whole
    duration_s = (passed[last + 1] - passed[first]) / rate
    recency = recency_weight(tau, params)
    return pd.DataFrame(
        {
            "recording": recording,
            "encounter": event_encounter,
            "track": track[salient_row[first]],
            "first_row": first,
            "last_row": last,
            "duration_s": duration_s,
            "tau": tau,
            "recency": recency,
            "saliency_s": duration_s * recency,
        },
        columns=list(EVENT_COLUMNS),
    )


def aggregate_saliency(saliency_s: np.ndarray, *, aggregate: str) -> float:
    """One number from event saliencies: the largest ("max") or the sum ("sum"); 0 without any."""
    if not len(saliency_s):
        return 0.0
    return float(saliency_s.max() if aggregate == "max" else saliency_s.sum())
