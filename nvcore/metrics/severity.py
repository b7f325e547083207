"""Severity: the cost of failing to detect a pedestrian, in seconds of a full-weight miss."""

from __future__ import annotations

import numpy as np
import pandas as pd

from nvcore.dataset.columns import BoxColumns, FrameColumns
from nvcore.metrics.encounters import Encounters
from nvcore.metrics.kernels import over_ranges
from nvcore.metrics.kernels.encounters import severity_frames
from nvcore.metrics.kernels.frames import cost_frames


def cost_of_miss(
    truth: BoxColumns, k_truth: np.ndarray, frames: FrameColumns, edge_weight: np.ndarray
) -> np.ndarray:
    """Compute the cost of missing each pedestrian, 0 to 1, float64, shape (n_truth,).

    ``k * border / (W/2)``: 1 is a near pedestrian straight ahead. The distance to the nearest
    detection does not count, or else a system that fills the picture with false alarms would have
    no failures.

    Parameters
    ----------
    k_truth
        Proximity weight of each truth box, in (0, 1).
    edge_weight
        Edge weight of each recording, 0 urban to 1 rural; float64, shape (n_recordings,).
    """
    cost = np.empty(len(truth))
    over_ranges(cost_frames, len(frames), truth.arrays, k_truth, edge_weight, frames.arrays, cost)
    return cost


def weigh_failures(
    truth: BoxColumns,
    encounters: Encounters,
    k_truth: np.ndarray,
    cost: np.ndarray,
    is_matched: np.ndarray,
    frames: FrameColumns,
) -> pd.DataFrame:
    """Weigh one system's failures in every encounter. 0 is best.

    Parameters
    ----------
    cost
        Result of `cost_of_miss`.
    is_matched
        Truth boxes that the system matched; bool, shape (n_truth,).

    Returns
    -------
    One row per encounter: severity_s, the sum of cost and time step over the relevant frames
    (``k >= 0.5``) in which the pedestrian is not matched, in seconds; peak_cost, the largest cost
    among them, 0 to 1; peak_row, the first frame row that has it. These are 0, 0 and -1 if nothing
    was missed or the encounter is distant.
    """
    n = len(encounters)
    severity, peak, peak_row = np.zeros(n), np.zeros(n), np.empty(n, np.int64)
    severity_frames(
        *(truth.offsets, encounters.encounter_of, frames.gap, k_truth, cost, is_matched),
        *(severity, peak, peak_row),
    )
    return pd.DataFrame(
        {
            "severity_s": severity / frames.fps[encounters.recording],
            "peak_cost": peak,
            "peak_row": peak_row,
        }
    )
