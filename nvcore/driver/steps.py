"""Count jumps of estimates when another adaptation period becomes the nearest."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.driver.estimators import Estimator

WHOSE = ["recording", "track"]


class Steps(NamedTuple):
    """Numbers of pedestrians whose estimates switch from one period's estimator to the next.

    Attributes
    ----------
    n_crossing
        Pedestrians (tracks) for whom the estimator of another period is taken from some frame on.
    n_jumping
        Those of them for whom the two estimators differ by more than the sd of each, on the
        features of the same frame, so coming nearer does not count as a jump.
    """

    n_crossing: int = 0
    n_jumping: int = 0


def steps_between_periods(
    estimator: Estimator,
    features: NDArray[np.float64],
    table: pd.DataFrame,
    taken_s: NDArray[np.float64],
) -> Steps:
    """Count pedestrians whose estimates switch to another period's estimator as the eyes adapt.

    A new change of light does not count.

    Parameters
    ----------
    features
        Of each row, as of `Estimator.estimate`, float64, shape (n, 8).
    table
        Of `nvcore.driver.estimate.EstimateRun`; boxes without a track are left out.
    taken_s
        The period whose estimator was taken for each row, seconds, float64, shape (n,); NaN: none,
        such rows are left out.

    Returns
    -------
    How many pedestrians are followed to another period's estimator, and for how many of them the
    two differ by more than the sd of each; both 0 without tracks, or estimates.

    Examples
    --------
    >>> from nvcore.driver.estimators import estimator_path, read_estimator
    >>> estimator = read_estimator(estimator_path("sample"))
    >>> features = np.tile([30, 80, 20, 15, 8, 12, 2, 150.0], (2, 1))
    >>> period_s = np.array([0.9, 1.1])  # the nearest are those of 0.5 s and of 1.5 s
    >>> estimates = estimator.estimate(features, period_s)
    >>> table = pd.DataFrame({
    ...     "recording": "drive", "track": 7, "frame": [17, 21], "period_s": period_s,
    ...     "detectability": estimates.detectability, "sd": estimates.sd,
    ... })
    >>> steps_between_periods(estimator, features, table, estimates.period_s).n_crossing
    1
    """
    rows = table.assign(taken_s=taken_s, row=np.arange(len(table)))
    needed = ["track", "detectability", "period_s", "taken_s"]
    rows = rows[rows[needed].notna().all(axis=1)].sort_values([*WHOSE, "frame"], kind="stable")
    before = rows.shift()
    is_same = (rows[WHOSE] == before[WHOSE]).all(axis=1)
    is_step = is_same & (rows["taken_s"] > before["taken_s"])
    steps = rows[is_step]
    former = estimator.estimate(
        features[steps["row"].to_numpy()], before.loc[is_step, "taken_s"].to_numpy(np.float64)
    )
    change = (steps["detectability"] - former.detectability).abs()
    jumps = steps[change > np.fmax(steps["sd"], former.sd)]
    return Steps(*(len(part[WHOSE].drop_duplicates()) for part in (steps, jumps)))
