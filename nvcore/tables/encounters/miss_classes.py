"""Counts of encounters: miss classes of X against Y, and the gain of fusing both systems."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.dataset.schema import MissClass
from nvcore.metrics.encounter_classes import classes_of
from nvcore.metrics.venn import count_categories, measure_exclusivity

FUSION_SYSTEMS: Final = ("x", "y", "x_or_y", "x_and_y")
CLASS_COLUMNS: Final = (
    *("both", "x_only", "y_only", "neither", "distant"),
    *("severity_s_x", "severity_s_y", "jaccard", "phi"),
)
ALL_CLASSES: Final = "all"
"""Row and column of the sums in `miss_class_totals`."""


def miss_class_counts(result: Result) -> pd.DataFrame:
    """Count encounters by their miss class for X and for Y, without distant ones.

    Returns
    -------
    Rows: miss class for X (`MissClass`, index `miss_class_x`); columns: miss class for Y. All
    classes are included, in the order of `MissClass`. Row sums are X's counts, column sums Y's.
    """
    names = [kind.value for kind in MissClass]
    is_near = result.is_near
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
    """Add a last row and column of sums, both called `ALL_CLASSES`, to `miss_class_counts`."""
    counts = miss_class_counts(result)
    counts.loc[ALL_CLASSES] = counts.sum(axis=0)
    counts[ALL_CLASSES] = counts.sum(axis=1)
    return counts


def class_counts(result: Result) -> pd.DataFrame:
    """Count the encounters of each class by the systems that detect them, with exclusivity.

    Returns
    -------
    One row per class of `nvcore.metrics.encounter_classes` (index `class`), in its order; both,
    x_only, y_only, neither: encounters that count; distant: those that do not; severity_s_x,
    severity_s_y (0 is best); jaccard, phi of the two miss sets (NaN undefined). An encounter of
    several classes is in several rows.
    """
    rows = {}
    for name, is_member in classes_of(result.dataset).members.items():  # a loop over classes
        venn = count_categories(result.category[is_member])
        exclusivity = measure_exclusivity(venn)
        rows[name] = {
            **{kind: venn.counts()[kind] for kind in ("both", "x_only", "y_only", "neither")},
            "distant": venn.distant,
            **{
                f"severity_s_{letter}": float(system.failures["severity_s"][is_member].sum())
                for letter, system in result.sides
            },
            "jaccard": exclusivity.jaccard,
            "phi": exclusivity.phi,
        }
    table = pd.DataFrame.from_dict(rows, orient="index", columns=list(CLASS_COLUMNS))
    return table.rename_axis("class")


def fusion_table(result: Result) -> pd.DataFrame:
    """Compare fused systems with X and Y: gain in encounters, cost in false-alert episodes.

    Returns
    -------
    One row per system of `FUSION_SYSTEMS` (column `system`): name; encounters_detected (of
    `encounters`, which excludes distant ones); gain_on_x, gain_on_y (additional encounters compared
    with only X or only Y; negative: fewer); false_alert_episodes, episodes_per_hour;
    more_episodes_than_x, more_episodes_than_y and the same per hour; mean_similarity (1 is best).
    NaN is undefined.

    Notes
    -----
    The first call for a result scores both fused systems (``result.fusion``).
    """
    fused = result.fusion
    rows = [
        _fusion_row(result, kind, system)
        for kind, system in zip(FUSION_SYSTEMS, (result.x, result.y, fused.x, fused.y), strict=True)
    ]
    return pd.DataFrame(rows)


def _fusion_row(result: Result, kind: str, system: SystemResult) -> dict[str, Any]:
    alarms = system.false_alarm_summary
    n_detected, n_detected_x, n_detected_y = (
        int(scored.encounters["is_detected"].sum()) for scored in (system, result.x, result.y)
    )
    alone_x, alone_y = result.x.false_alarm_summary, result.y.false_alarm_summary
    return {
        "system": kind,
        "name": system.name,
        "encounters_detected": n_detected,
        "encounters": result.venn.n_near,
        "gain_on_x": n_detected - n_detected_x,
        "gain_on_y": n_detected - n_detected_y,
        "false_alert_episodes": alarms.episodes,
        "episodes_per_hour": alarms.episodes_per_hour,
        "more_episodes_than_x": alarms.episodes - alone_x.episodes,
        "more_episodes_than_y": alarms.episodes - alone_y.episodes,
        "more_episodes_per_hour_than_x": alarms.episodes_per_hour - alone_x.episodes_per_hour,
        "more_episodes_per_hour_than_y": alarms.episodes_per_hour - alone_y.episodes_per_hour,
        "mean_similarity": system.summary.mean,
    }
