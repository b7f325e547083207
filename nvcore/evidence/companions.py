"""Two further comparisons that guard against misreading: at equal false alarms, paired strictly.

A lower threshold gives more detections and more false alarms, and a false alarm near a missed
pedestrian raises similarity. So whatever a verdict claims has to hold where both systems have
equally many false alarms, and where boxes are paired strictly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.evidence.measures import Judged, significance_table, unit_measures
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.operating_points import (
    EqualAlarms,
    are_unequal,
    count_alarms,
    find_equal_alarms,
    has_scores,
    threshold_for,
    with_thresholds,
)
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import WHOLE, Units, find_units
from nvcore.protocols import PROTOCOLS, Protocol


@dataclass(frozen=True, eq=False)
class Companions:
    """The same two systems at equal false alarms, and paired strictly.

    Attributes
    ----------
    equal
        Both at equal false alarms; None: no threshold gives them, or they are not needed since X
        and Y are set alike and no difference could be claimed.
    evidence
        Evidence of `equal`, with intervals if X and Y are set to different operating points.
        Numbers of false alarms that are equal in these recordings would not be in others: p and
        intervals allow for that (`shifts_at_equal_alarms`). None without `equal`.
    strict
        The comparison that the verdict is about (`equal` if X and Y are set unequally), with
        ``pairing="matched"``.
    """

    equal: EqualAlarms | None
    evidence: pd.DataFrame | None
    strict: Result


def find_companions(
    result: Result,
    evidence: pd.DataFrame,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    miss_rate: Judged | None = None,
    primary: str | None = None,
) -> Companions:
    """The companions of a comparison, reusing its stages.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result, with the same protocol and primary
        measure.
    miss_rate
        ``judge_miss_rate(result, units, protocol)``, if already computed: it does not depend on
        thresholds.
    """
    is_unequal = are_unequal(result)
    has_candidates = bool((evidence["p_corrected"] <= SIGNIFICANT).any())
    equal = find_equal_alarms(result) if is_unequal or has_candidates else None
    basis = equal.result if equal is not None and is_unequal else result
    strict = basis
    if result.params.pairing != "matched":
        params = replace(basis.params, pairing="matched")
        strict = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=basis)
    if equal is None:
        return Companions(None, None, strict)
    units = find_units(equal.result)
    if (evidence["figure"] != MISS_RATE).all():  # not asked for
        extra = []
    elif miss_rate is None:
        extra = [judge_miss_rate(result, units, protocol, has_interval=is_unequal)]
    else:
        extra = [miss_rate]
    shifts = {}
    if units.kind in WHOLE or is_unequal:
        shifts = shifts_at_equal_alarms(result, equal, units)
    at_equal = significance_table(
        equal.result,
        extra,
        keys=evidence["figure"].tolist(),
        units=units,
        shifts=shifts,
        primary=primary,
        has_intervals=is_unequal,
    )
    ends = [
        significance_table(
            end,
            extra,
            keys=evidence["figure"].tolist(),
            units=units,
            shifts=shifts,
            primary=primary,
            has_intervals=False,
        )
        for end in _ends_of_plateau(result, equal)
    ]
    return Companions(equal, least_of(at_equal, ends), strict)


def _ends_of_plateau(result: Result, alike: EqualAlarms) -> list[Result]:
    """The comparisons at the lowest and the highest threshold that give as many false alarms.

    Empty where no detection lies between the two.
    """
    moved, equal = alike.moved, alike.result
    n_target = count_alarms(equal.system(moved))
    thresholds = [
        threshold_for(result, moved, n_target, "lowest"),
        threshold_for(result, moved, n_target, "highest"),
    ]
    low, high = (-np.inf if threshold is None else threshold for threshold in thresholds)
    score = result.dataset.system(result.system(moved).name).score
    if not ((score >= low) & (score < high)).any():
        return []
    return [with_thresholds(result, {f"threshold_{moved}": threshold}) for threshold in thresholds]


def least_of(evidence: pd.DataFrame, ends: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """The evidence as far as it holds at the ends, too (an intersection-union test).

    p is the largest, and 1 where the ends do not agree on the better system; intervals reach as far
    beyond as differences do.
    """
    if not ends:
        return evidence
    apart = evidence["difference"].to_numpy()
    of_ends = np.array([end["difference"].to_numpy() for end in ends])
    agrees = (np.sign(of_ends) == np.sign(apart)).all(axis=0)
    largest = {
        name: np.where(
            agrees | np.isnan(evidence[name]),
            np.maximum.reduce([evidence[name], *(end[name] for end in ends)]),
            1.0,
        )
        for name in ("p", "p_corrected")
    }
    return evidence.assign(
        **largest,
        low=evidence["low"] + np.minimum((of_ends - apart).min(axis=0), 0),
        high=evidence["high"] + np.maximum((of_ends - apart).max(axis=0), 0),
    )


def judge_both(
    result: Result, protocol: Protocol = PROTOCOLS["all"], *, has_intervals: bool = True
) -> tuple[pd.DataFrame, Companions]:
    """`evidence_table` and `find_companions` of a comparison."""
    units = find_units(result)
    miss_rate = judge_miss_rate(result, units, protocol, has_interval=has_intervals)
    evidence = evidence_table(
        result, protocol, units=units, miss_rate=miss_rate, has_intervals=has_intervals
    )
    return evidence, find_companions(result, evidence, protocol, miss_rate=miss_rate)


def shifts_of(result: Result, units: Units) -> dict[str, np.ndarray]:
    """`shifts_at_equal_alarms` of a comparison; empty where no threshold gives these."""
    alike = find_equal_alarms(result)
    return {} if alike is None else shifts_at_equal_alarms(result, alike, units)


def shifts_at_equal_alarms(
    result: Result, alike: EqualAlarms, units: Units
) -> dict[str, np.ndarray]:
    """What to take off each unit's part in a difference at equal false alarms, by measure.

    How far a measure moves with the logarithm of the ratio of false alarms, X to Y, times the
    unit's part in that: the difference is then that at a ratio of 1 to the first order (delta
    method), and varies between recordings as a difference at equal false alarms does. Without this,
    verdicts claimed a difference in 17 % of pairs of equal systems (16 recordings).

    The slope is that between two comparisons in which one of the systems has fewer false alarms by
    a standard error of that logarithm.

    Returns
    -------
    Float64, shape (n_units,), of each measure that is judged by units and moves.
    """
    equal, moved = alike.result, alike.moved
    other = "y" if moved == "x" else "x"
    alarms = {
        letter: np.bincount(units.unit_of_frame, system.false_alarms, len(units))
        for letter, system in equal.sides
    }
    apart, total = alarms["x"] - alarms["y"], float(alarms["x"].sum() + alarms["y"].sum())
    n_target = count_alarms(equal.system(other))
    if not n_target or not apart.any():
        return {}
    error = float(np.sqrt((apart**2).sum())) / n_target  # standard error of the logarithm
    n_fewer = min(max(1, int(n_target * np.exp(-error))), n_target - 1)
    fewer = {f"threshold_{moved}": threshold_for(result, moved, n_fewer, "round")}
    at_equal = {f"threshold_{moved}": equal.system(moved).threshold}
    if has_scores(result, other):
        against = at_equal | {f"threshold_{other}": threshold_for(result, other, n_fewer, "round")}
    else:
        n_more = max(int(np.ceil(n_target * np.exp(error))), n_target + 1)
        against = {f"threshold_{moved}": threshold_for(result, moved, n_more, "round")}
    ends = [with_thresholds(result, changed) for changed in (fewer, against)]
    ratios = [np.log((count_alarms(end.x) + 0.5) / (count_alarms(end.y) + 0.5)) for end in ends]
    if ratios[0] == ratios[1]:
        return {}
    differences = [
        {
            measure.key: float(
                measure.statistic(measure.x.sum(axis=0)) - measure.statistic(measure.y.sum(axis=0))
            )
            for measure in unit_measures(end, units)
        }
        for end in ends
    ]
    of_units = apart / (total / 2) * len(units)
    slopes = {
        key: (differences[0][key] - differences[1][key]) / (ratios[0] - ratios[1])
        for key in differences[0]
    }
    return {key: slope * of_units for key, slope in slopes.items() if np.isfinite(slope) and slope}
