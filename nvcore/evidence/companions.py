"""Two further comparisons that guard against misreading: equal false alarms, strict pairing.

A lower threshold gives more detections and more false alarms, and a false alarm near a missed
pedestrian raises similarity. So a claim of the verdict must also hold if both systems have equally
many false alarms, and if boxes are paired strictly.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result, compare
from nvcore.comparison.measures.table import inference_of
from nvcore.evidence.graded import MIN_UNITS, Graded, grade
from nvcore.evidence.measures import (
    Evidence,
    Judged,
    evidence_of,
    judge,
    significance_table,
    unit_measures,
)
from nvcore.evidence.miss_rate import KEY as MISS_RATE
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.operating_points import (
    are_delivered,
    are_unequal,
    count_alarms,
    find_equal_alarms,
    has_scores,
    moved_of,
    threshold_for,
    which_moves,
    with_thresholds,
)
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.units import WHOLE, Units, find_units, find_whole
from nvcore.settings.protocols import PROTOCOLS, Protocol

MOST_ERROR: Final = 0.5
"""Largest standard error of log(false alarms of X / false alarms of Y) for judging unequally set
systems at equal false alarms. If there are few false alarms, or most are in few recordings,
equalising them there says little about other recordings. Without this limit, 9 % of pairs of equal
systems with one false alarm in 50 frames were told apart (20 recordings)."""
UNSURE: Final = (
    "false alarms are too few, or too unevenly spread over recordings, to set the two alike"
)


@dataclass(frozen=True, eq=False)
class Companions:
    """The same two systems at equal false alarms, and with strict pairing.

    Attributes
    ----------
    equal
        Comparison at equal false alarms. None if no threshold gives them, or if it is not needed: X
        and Y already have equal false alarms, or are set alike without a claimable difference.
    evidence
        Evidence of `equal`, without intervals (`judge_equal_alarms`). None without `equal`.
    strict
        The comparison that the verdict is based on (`equal` if X and Y are at unequal operating
        points), with ``pairing="matched"``.
    graded
        Probability that Y misses fewer encounters at equal false alarms, if asked for.
    """

    equal: Result | None
    evidence: pd.DataFrame | None
    strict: Result
    graded: Graded | None = None


def find_companions(
    result: Result,
    evidence: pd.DataFrame,
    protocol: Protocol = PROTOCOLS["all"],
    *,
    miss_rate: Judged | None = None,
    primary: str | None = None,
    is_graded: bool = True,
) -> Companions:
    """Compute the companions of a comparison, reusing its stages.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result, with the same protocol and primary
        measure.
    miss_rate
        ``judge_miss_rate(result, units, protocol)``, if already computed: it does not depend on
        thresholds.
    is_graded
        False leaves out `Companions.graded`.
    """
    is_unequal = are_unequal(result)
    has_candidates = bool((evidence["p_corrected"] <= SIGNIFICANT).any())
    is_free = result.as_set is None and not are_delivered(result)
    is_needed = is_free and (is_unequal or has_candidates)
    equal = find_equal_alarms(result) if is_needed else None
    basis = equal if equal is not None and is_unequal else result
    strict = basis
    if result.params.pairing != "matched":
        params = replace(basis.params, pairing="matched")
        strict = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=basis)
    graded = grade_systems(result) if is_graded else None
    if equal is None:
        return Companions(None, None, strict, graded)
    extra = []
    if (evidence["figure"] == MISS_RATE).any():  # asked for
        units = find_units(equal)
        extra = [miss_rate or judge_miss_rate(result, units, protocol, has_interval=False)]
    keys = evidence["figure"].tolist()
    at_equal = judge_equal_alarms(equal, extra, keys=keys, primary=primary, has_intervals=False)
    return Companions(equal, at_equal, strict, graded)


def grade_systems(result: Result) -> Graded:
    """Return the probability that Y misses fewer encounters at equal false alarms.

    It is averaged over the ratios of false alarms that are likely in other recordings: the one
    found, and a standard error of its logarithm less and more. Delivered thresholds stay.
    """
    units = find_whole(result.dataset)
    if len(units) < MIN_UNITS:
        return Graded.undefined("units", units)
    if are_delivered(result):
        return grade((result,), units)
    equal = find_equal_alarms(result) if result.as_set is None else result
    if equal is None:
        return Graded.undefined("points" if which_moves(result) else "scores", units)
    is_unsure = are_unequal(result) and _alarms_apart(equal, units).error > MOST_ERROR
    ends = () if is_unsure else ends_of_ratio(equal, units)
    return grade((equal, *ends), units) if ends else Graded.undefined("alarms", units)


def judge_equal_alarms(
    equal: Result,
    extra: Sequence[Judged] = (),
    *,
    keys: Sequence[str] | None = None,
    units: Units | None = None,
    primary: str | None = None,
    has_intervals: bool = True,
) -> pd.DataFrame:
    """Return the `significance_table` of a comparison at equal false alarms.

    Numbers of false alarms that are equal in these recordings would differ in others. p and
    intervals allow for that (`shifts_at_equal_alarms`). The difference must also hold at both ends
    of the range of thresholds that give these numbers (`least_of`). Systems that are set unequally
    have no p and no interval if the recordings say too little about their false alarms
    (`MOST_ERROR`).

    Parameters
    ----------
    equal
        Result of `nvcore.evidence.operating_points.find_equal_alarms`.
    extra, keys, units, primary, has_intervals
        See `nvcore.evidence.measures.significance_table`.
    """
    units = find_units(equal) if units is None else units
    is_shifted = units.kind in WHOLE or has_intervals
    judge_one = partial(
        significance_table,
        extra=extra,
        keys=keys,
        units=units,
        shifts=shifts_at_equal_alarms(equal, units) if is_shifted else {},
        primary=primary,
    )
    ends = [judge_one(end, has_intervals=False) for end in _ends_of_plateau(equal)]
    judged = least_of(judge_one(equal, has_intervals=has_intervals), ends)
    if are_unequal(equal.as_set or equal) and _alarms_apart(equal, units).error > MOST_ERROR:
        return _without_tests(judged)
    return judged


def is_unsure(evidence: pd.DataFrame | pd.Series[Any] | Mapping[Hashable, Any]) -> bool:
    """Whether a table of evidence, or a row of it, lacks tests because of too few false alarms."""
    return any(UNSURE in note for note in np.atleast_1d(evidence["note"]))


def _without_tests(evidence: pd.DataFrame) -> pd.DataFrame:
    """Remove tests that depend on the current thresholds, with `UNSURE` as the reason."""
    at_thresholds = evidence["figure"].map(lambda key: inference_of(key).test != "curve")
    has_some = np.isfinite(evidence["p"]) | np.isfinite(evidence["low"])
    is_tested = at_thresholds & evidence["unit"].isin(WHOLE) & has_some
    table = evidence.copy()
    table.loc[is_tested, ["low", "high", "p", "p_corrected", "least_p", "effect"]] = np.nan
    table.loc[is_tested, "method"] = ""
    notes = [f"{note}; {UNSURE}" if note else UNSURE for note in table.loc[is_tested, "note"]]
    table.loc[is_tested, "note"] = notes
    return table


def judge_keys(
    result: Result, keys: Sequence[str], *, units: Units | None = None
) -> tuple[Evidence, ...]:
    """Judge measures by `nvcore.evidence.measures.judge`.

    At equal false alarms this works like `judge_equal_alarms`.
    """
    if result.as_set is None:
        return judge(result, keys, units=units)
    table = judge_equal_alarms(result, keys=keys, units=units, primary="")
    return tuple(row for key in keys if (row := evidence_of(table, key)) is not None)


def _ends_of_plateau(equal: Result) -> list[Result]:
    """Return the comparisons at the lowest and highest threshold with the same false alarms.

    The list is empty if no detection lies between the two.
    """
    moved = moved_of(equal)
    n_target = count_alarms(equal.system(moved))
    thresholds = [
        threshold_for(equal, moved, n_target, "lowest"),
        threshold_for(equal, moved, n_target, "highest"),
    ]
    low, high = (-np.inf if threshold is None else threshold for threshold in thresholds)
    score = equal.dataset.system(equal.system(moved).name).score
    if not ((score >= low) & (score < high)).any():
        return []
    return [with_thresholds(equal, {f"threshold_{moved}": threshold}) for threshold in thresholds]


def least_of(evidence: pd.DataFrame, ends: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Weaken the evidence to what also holds at the ends (an intersection-union test).

    p is the largest one, and 1 if the ends do not agree on the better system. Intervals are
    extended as far as the differences extend.
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


def shifts_at_equal_alarms(equal: Result, units: Units) -> dict[str, np.ndarray]:
    """Compute the shift of each unit's part in a difference at equal false alarms, by measure.

    The shift is the change of the measure with log(false alarms of X / false alarms of Y), times
    the unit's part in that logarithm. To first order (delta method), the shifted difference is that
    at a ratio of 1, and it varies between recordings as a difference at equal false alarms does.
    Without shifts, verdicts claimed a difference in 17 % of pairs of equal systems (16 recordings).
    The slope is taken between two comparisons in which one of the systems has fewer false alarms by
    a standard error of that logarithm.

    Returns
    -------
    Float64, shape (n_units,), for each measure that is judged by units and changes.
    """
    alarms, ends = _alarms_apart(equal, units), ends_of_ratio(equal, units)
    ratios = [np.log((count_alarms(end.x) + 0.5) / (count_alarms(end.y) + 0.5)) for end in ends]
    if not ends or ratios[0] == ratios[1]:
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
    of_units = alarms.apart / (alarms.total / 2) * len(units)
    slopes = {
        key: (differences[0][key] - differences[1][key]) / (ratios[0] - ratios[1])
        for key in differences[0]
    }
    return {key: slope * of_units for key, slope in slopes.items() if np.isfinite(slope) and slope}


def ends_of_ratio(equal: Result, units: Units) -> tuple[Result, ...]:
    """Return two comparisons: one of the systems has fewer false alarms by a standard error.

    The error is that of the logarithm of their ratio. The first has the moved system with fewer.
    Empty if it is unknown for lack of false alarms that differ between units.
    """
    return equal.keep(f"ends_of_ratio_{units.kind}", lambda: _find_ends(equal, units))


def _find_ends(equal: Result, units: Units) -> tuple[Result, ...]:
    alarms = _alarms_apart(equal, units)
    n_target, error = alarms.n_target, alarms.error
    if not n_target or not alarms.apart.any():
        return ()
    moved = moved_of(equal)
    other = "y" if moved == "x" else "x"
    n_fewer = min(max(1, int(n_target * np.exp(-error))), n_target - 1)
    fewer = {f"threshold_{moved}": threshold_for(equal, moved, n_fewer, "round")}
    at_equal = {f"threshold_{moved}": equal.system(moved).threshold}
    if has_scores(equal, other):
        against = at_equal | {f"threshold_{other}": threshold_for(equal, other, n_fewer, "round")}
    else:
        n_more = max(int(np.ceil(n_target * np.exp(error))), n_target + 1)
        against = {f"threshold_{moved}": threshold_for(equal, moved, n_more, "round")}
    return tuple(with_thresholds(equal, changed) for changed in (fewer, against))


@dataclass(frozen=True, eq=False)
class AlarmsApart:
    """False alarms of X and Y after a threshold was moved to equalise them.

    Attributes
    ----------
    apart
        False alarms X - Y in every unit; shape (n_units,).
    total
        False alarms of both systems in all units.
    n_target
        False alarms of the system whose threshold was not moved.
    error
        Standard error of the logarithm of their ratio; infinite without false alarms.
    """

    apart: np.ndarray
    total: float
    n_target: int
    error: float


def _alarms_apart(equal: Result, units: Units) -> AlarmsApart:
    x, y = (units.total(units.unit_of_frame, system.false_alarms) for _, system in equal.sides)
    n_target = count_alarms(equal.system("y" if moved_of(equal) == "x" else "x"))
    error = float(np.sqrt(((x - y) ** 2).sum())) / n_target if n_target else np.inf
    return AlarmsApart(x - y, float(x.sum() + y.sum()), n_target, error)
