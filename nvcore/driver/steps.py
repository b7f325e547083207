"""Steps of the estimates where the nearest adaptation period becomes another."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

WHOSE = ["recording", "track"]


class Steps(NamedTuple):
    """How many pedestrians are followed from one estimator to the next.

    Attributes
    ----------
    n_crossing
        Pedestrians (tracks) for whom the estimator of another period is taken from some frame on.
    n_jumping
        Those of them whose estimate differs there by more than its sd before and after.
    """

    n_crossing: int = 0
    n_jumping: int = 0


def steps_between_periods(table: pd.DataFrame, taken_s: NDArray[np.float64]) -> Steps:
    """Steps while the eyes adapt; a new change of light is none.

    Parameters
    ----------
    table
        Of `nvcore.driver.estimate.EstimateRun`; boxes without a track are left out.
    taken_s
        The period whose estimator was taken for each row, float64, shape (n,).
    """
    rows = table.assign(taken_s=taken_s)
    needed = ["track", "detectability", "period_s", "taken_s"]
    rows = rows[rows[needed].notna().all(axis=1)].sort_values([*WHOSE, "frame"], kind="stable")
    before = rows.shift()
    is_same = (rows[WHOSE] == before[WHOSE]).all(axis=1)
    is_step = is_same & (rows["taken_s"] > before["taken_s"])
    change = (rows["detectability"] - before["detectability"]).abs()
    is_jump = is_step & (change > np.fmax(rows["sd"], before["sd"]))
    return Steps(*(len(rows.loc[which, WHOSE].drop_duplicates()) for which in (is_step, is_jump)))
