"""What rejects a window before the last tree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.icf.settings import IcfSettings


@dataclass(frozen=True, eq=False)
class Calibration:
    """Confidences with which objects pass the trees: those trained on, and those held out.

    Attributes
    ----------
    trace
        Lowest sum of the confidences up to each tree; float64, (n_trees,).
    stage_ends
        Number of trees up to the end of each stage; int32, (n_stages,), the last is n_trees.
    stage_floors
        Lowest sum of the confidences of a stage's own trees; float64, (n_stages,).
    """

    trace: NDArray[np.float64]
    stage_ends: NDArray[np.int32]
    stage_floors: NDArray[np.float64]


def calibrate(sums: NDArray[np.float64], kept_share: float, slack: float = 0.0) -> Calibration:
    """Direct backward pruning: no object that is confident at the end is rejected on the way.

    Of the objects, the share `kept_share` with the highest sum over all trees counts. The trace is
    the least of their sums after each tree. The stages of a hard cascade, which end after 2, 4,
    8, ... trees, are calibrated likewise.

    Parameters
    ----------
    sums
        Running sums of objects, (n_objects, n_trees); at least one of each.
    kept_share
        Of the objects, rounded to whole ones.
    slack
        How far below the least sum the trace and the floors lie.

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
    """What lets pass all windows that either of two calibrations of the same trees lets pass."""
    return Calibration(
        np.minimum(first.trace, second.trace),
        first.stage_ends,
        np.minimum(first.stage_floors, second.stage_floors),
    )


def floors(
    settings: IcfSettings, calibration: Calibration
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Lowest sum after each tree with which a window stays, and where the sum begins anew.

    A calibrated trace rejects no window whose sum is above 0, even where all objects had more:
    so far the trees take it for an object.
    """
    n_trees = len(calibration.trace)
    restarts = np.zeros(n_trees, np.bool_)
    if settings.cascade == "calibrated":
        return np.minimum(calibration.trace, 0.0), restarts
    if settings.cascade == "constant":
        return np.full(n_trees, float(settings.rejection)), restarts
    lowest = np.full(n_trees, -np.inf)
    if settings.cascade == "hard":
        # sums of a stage are differences at calibration, sums here: rounded differently
        lowest[calibration.stage_ends - 1] = calibration.stage_floors - 1e-9
        restarts[calibration.stage_ends[:-1]] = True
    return lowest, restarts


def passes(
    settings: IcfSettings, calibration: Calibration, sums: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Whether each window stays after each tree by itself; one that fails anywhere is rejected.

    Parameters
    ----------
    sums
        Running sums of all trees, as if nothing rejected a window, (n_windows, n_trees).

    Returns
    -------
    Bool, (n_windows, n_trees). In a hard cascade the sum since the stage began counts.
    """
    lowest, restarts = floors(settings, calibration)
    starts = np.maximum.accumulate(np.where(restarts, np.arange(len(lowest)), 0))
    before = np.concatenate([np.zeros((len(sums), 1)), sums], axis=1)[:, starts]
    is_passing: NDArray[np.bool_] = sums - before >= lowest
    return is_passing
