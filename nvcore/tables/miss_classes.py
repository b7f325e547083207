"""Encounters counted: miss classes of X against Y, and what a fusion of both would gain."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result, SystemResult
from nvcore.schema import Category, MissClass

FUSION_SYSTEMS: Final = ("x", "y", "x_or_y", "x_and_y")
ALL_CLASSES: Final = "all"
"""Row and column of the sums in `miss_class_totals`."""


def miss_class_counts(result: Result) -> pd.DataFrame:
    """How many encounters have which miss class for X and which for Y; distant ones left out.

    Returns
    -------
    Rows: miss class for X (`MissClass`, index `miss_class_x`); columns: miss class for Y. All
    classes are there, in the order of `MissClass`; row sums are X's counts, column sums Y's.
    """
    names = [kind.value for kind in MissClass]
    is_near = result.category != Category.DISTANT.value
    x, y = (
        pd.Categorical(system.encounters["miss_class"].to_numpy()[is_near], names).codes.astype(int)
        for system in (result.x, result.y)
    )
    n = len(names)
    counts = np.bincount(n * x + y, minlength=n * n).reshape(n, n)
    return pd.DataFrame(
        counts,
        index=pd.Index(names, name="miss_class_x"),
        columns=pd.Index(names, name="miss_class_y"),
    )


def miss_class_totals(result: Result) -> pd.DataFrame:
    """`miss_class_counts` with a last row and column of the sums, both called `ALL_CLASSES`."""
    counts = miss_class_counts(result)
    counts.loc[ALL_CLASSES] = counts.sum(axis=0)
    counts[ALL_CLASSES] = counts.sum(axis=1)
    return counts


def fusion_table(result: Result) -> pd.DataFrame:
    """What ``X or Y`` and ``X and Y`` gain in encounters and cost in false-alert episodes.

    Returns
    -------
    One row per system of `FUSION_SYSTEMS` (column `system`): name; encounters_detected (of
    `encounters`, which leaves distant ones out); gain_on_x, gain_on_y (encounters detected more
    than X, than Y alone; negative: fewer); false_alert_episodes, episodes_per_hour;
    more_episodes_than_x, more_episodes_than_y and the same per hour; mean_similarity (1 is best).
    Undefined is NaN.

    Notes
    -----
    Analyses both fused systems (``result.fusion``) at the first call for a result.
    """
    fused = result.fusion
    rows = [
        _fusion_row(result, kind, system)
        for kind, system in zip(FUSION_SYSTEMS, (result.x, result.y, fused.x, fused.y), strict=True)
    ]
    return pd.DataFrame(rows)


def _fusion_row(result: Result, kind: str, system: SystemResult) -> dict[str, Any]:
    alarms = system.false_alarm_summary
    detected, detected_x, detected_y = (
        int(one.encounters["is_detected"].sum()) for one in (system, result.x, result.y)
    )
    alone_x, alone_y = (one.false_alarm_summary for one in (result.x, result.y))
    return {
        "system": kind,
        "name": system.name,
        "encounters_detected": detected,
        "encounters": result.venn.n_near,
        "gain_on_x": detected - detected_x,
        "gain_on_y": detected - detected_y,
        "false_alert_episodes": alarms.episodes,
        "episodes_per_hour": alarms.episodes_per_hour,
        "more_episodes_than_x": alarms.episodes - alone_x.episodes,
        "more_episodes_than_y": alarms.episodes - alone_y.episodes,
        "more_episodes_per_hour_than_x": alarms.episodes_per_hour - alone_x.episodes_per_hour,
        "more_episodes_per_hour_than_y": alarms.episodes_per_hour - alone_y.episodes_per_hour,
        "mean_similarity": system.summary.mean,
    }
