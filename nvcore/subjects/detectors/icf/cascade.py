"""Cascade: early rejection of windows before the last tree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nvcore.subjects.detectors.icf.settings import IcfSettings


@dataclass(frozen=True, eq=False)
class Calibration:
    """Running confidences that objects reach, both those trained on and those held out.

    Attributes
    ----------
    trace
        Minimum sum of confidences after each tree; float64, (n_trees,).
    stage_ends
        Number of trees up to the end of each stage; int32, (n_stages,). The last is n_trees.
    stage_floors
        Minimum sum of the confidences of each stage's own trees; float64, (n_stages,).
    """

    trace: NDArray[np.float64]
    stage_ends: NDArray[np.int32]
    stage_floors: NDArray[np.float64]


def calibrate(sums: NDArray[np.float64], kept_share: float, slack: float = 0.0) -> Calibration:
    """Calibrate a cascade by direct backward pruning, keeping all objects with a high final sum.

    The share `kept_share` of the objects with the highest sum over all trees is kept. The trace is
    the minimum of their sums after each tree. The stages of a hard cascade, which end after 2, 4,
    8, ... trees, are calibrated in the same way.

    Parameters
    ----------
    sums
        Running sums of objects, (n_objects, n_trees), with at least one object and one tree.
    kept_share
        Share of objects to keep, rounded to whole objects.
    slack
        Distance of the trace and the floors below the minimum sums.

    References
    ----------
    C. Zhang, P. Viola: Multiple-instance pruning for learning efficient cascade detectors,
    NIPS 2007.
    """
    n_kept = max(1, round(kept_share * len(sums)))
    passing = sums[np.argsort(-sums[:, -1], kind="stable")[:n_kept]]
    n_trees = sums.shape[1]
    whole = [2**k for k in range(1, n_trees.bit_length()) if 2**k < n_trees]
    ends = np.array([*whole, n_trees], np.int32)
    at_ends = passing[:, ends - 1]
    of_stage = np.diff(at_ends, axis=1, prepend=0.0)
    return Calibration(passing.min(axis=0) - slack, ends, of_stage.min(axis=0) - slack)


def lower(first: Calibration, second: Calibration) -> Calibration:
    """Combine two calibrations of the same trees so that windows passed by either one pass."""
    return Calibration(
        np.minimum(first.trace, second.trace),
        first.stage_ends,
        np.minimum(first.stage_floors, second.stage_floors),
    )


def floors(
    settings: IcfSettings, calibration: Calibration
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the minimum sum to pass each tree, and where the sum restarts.

    A calibrated trace rejects no window with a sum above 0, even if all objects had more, because
    the trees so far classify it as an object.
    """
    n_trees = len(calibration.trace)
    restarts = np.zeros(n_trees, np.bool_)
    if settings.cascade == "calibrated":
        return np.minimum(calibration.trace, 0.0), restarts
    if settings.cascade == "constant":
        return np.full(n_trees, float(settings.rejection)), restarts
    lowest = np.full(n_trees, -np.inf)
    if settings.cascade == "hard":
        # sums of a stage are differences at calibration but sums here, with other rounding errors
        lowest[calibration.stage_ends - 1] = calibration.stage_floors - 1e-9
        restarts[calibration.stage_ends[:-1]] = True
    return lowest, restarts


def passes(
    settings: IcfSettings, calibration: Calibration, sums: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return whether each window passes each tree. Failing one tree means rejection.

    Parameters
    ----------
    sums
        Running sums over all trees without rejection, (n_windows, n_trees).

    Returns
    -------
    Bool, (n_windows, n_trees). A hard cascade compares the sum since the start of the stage.
    """
    lowest, restarts = floors(settings, calibration)
    starts = np.maximum.accumulate(np.where(restarts, np.arange(len(lowest)), 0))
    before = np.concatenate([np.zeros((len(sums), 1)), sums], axis=1)[:, starts]
    is_passing: NDArray[np.bool_] = sums - before >= lowest
    return is_passing
