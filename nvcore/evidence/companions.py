"""Two further comparisons that guard against misreading: at equal false alarms, paired strictly.

A lower threshold gives more detections and more false alarms, and a false alarm near a missed
pedestrian raises similarity. So whatever a verdict claims has to hold where both systems have
equally many false alarms, and where boxes are paired strictly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.evidence.measures import Evidence, significance_table
from nvcore.evidence.miss_rate import KEY as MISS_RATE
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

STANDARD_ERRORS: Final = 1.96
"""How far apart two numbers of false alarms may be and still pass for equal (standard errors). With
0, verdicts claimed a difference in 17 % of pairs of equal systems (16 recordings)."""


@dataclass(frozen=True, eq=False)
class Companions:
    """The same two systems at equal false alarms, and paired strictly.

    Numbers of false alarms that are equal in these recordings may differ in others, and a range of
    thresholds gives the same number. So a claim has to hold at both ends of what may pass for
    equal, each the worst for one of the systems.

    Attributes
    ----------
    equal
        Both at equal false alarms; None: no threshold gives them, or they are not needed since X
        and Y are set alike and no difference could be claimed.
    evidence
        Evidence at both ends of what may pass for equal; with intervals if X and Y are set to
        different operating points. Empty without `equal`.
    strict
        The comparison that the verdict is about (`equal` if X and Y are set unequally), with
        ``pairing="matched"``.
    of_equal
        Evidence of `equal` itself, with intervals; None where `equal` only confirms the comparison
        as set.
    """

    equal: EqualAlarms | None
    evidence: tuple[pd.DataFrame, ...]
    strict: Result
    of_equal: pd.DataFrame | None = None

    @property
    def weaker_evidence(self) -> pd.DataFrame:
        """The evidence of `equal`, made as weak as the weaker end.

        p and corrected p are the larger ones of the two ends; intervals span those of `equal` and
        of both ends. NaN where an end has none.
        """
        assert self.of_equal is not None
        tables = (self.of_equal, *self.evidence)

        def of_all(extreme: np.ufunc, name: str, tables: Sequence[pd.DataFrame]) -> np.ndarray:
            ends: np.ndarray = extreme.reduce([table[name].to_numpy() for table in tables])
            return ends

        return self.of_equal.assign(
            p=of_all(np.maximum, "p", self.evidence),
            p_holm=of_all(np.maximum, "p_holm", self.evidence),
            low=of_all(np.minimum, "low", tables),
            high=of_all(np.maximum, "high", tables),
        )


def find_companions(result: Result, evidence: pd.DataFrame) -> Companions:
    """The companions of a comparison, reusing its stages.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result; its miss rate is kept, since it does
        not depend on thresholds.
    """
    is_unequal = are_unequal(result)
    has_candidates = bool((evidence["p_holm"] <= SIGNIFICANT).any())
    equal = find_equal_alarms(result) if is_unequal or has_candidates else None
    basis = equal.result if equal is not None and is_unequal else result
    strict = basis
    if result.params.pairing != "matched":
        params = replace(basis.params, pairing="matched")
        strict = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=basis)
    if equal is None:
        return Companions(None, (), strict)
    has_p = bool(np.isfinite(evidence["p_holm"]).any())
    ends = _ends(result, equal) if has_p else [equal.result]
    miss_rates = _miss_rates(evidence)

    def judged(at_end: Result) -> pd.DataFrame:
        return significance_table(at_end, miss_rates, has_intervals=is_unequal)

    tables = tuple(judged(at_end) for at_end in ends)
    of_equal = None
    if is_unequal:
        of_equal = tables[0] if len(ends) == 1 else judged(equal.result)
    return Companions(equal, tables, strict, of_equal)


def _ends(result: Result, alike: EqualAlarms) -> list[Result]:
    """The comparisons at equal false alarms that are worst for each system.

    The numbers are equal in these recordings; in others they would differ. By how much follows from
    the differences between recordings: the system at a disadvantage gets fewer false alarms, by
    `STANDARD_ERRORS` of the logarithm of their ratio, and the highest threshold that gives them.
    """
    equal, moved = alike.result, alike.moved
    n_target = count_alarms(equal.y if moved == "x" else equal.x)
    if not n_target:
        return [equal]
    other = "y" if moved == "x" else "x"
    n_fewer = max(1, int(n_target * np.exp(-STANDARD_ERRORS * _spread_of_alarms(equal) / n_target)))
    worst_for_moved = {f"threshold_{moved}": threshold_for(result, moved, n_fewer, "highest")}
    if has_scores(result, other):
        worst_for_other = {
            f"threshold_{moved}": threshold_for(result, moved, n_target, "lowest"),
            f"threshold_{other}": threshold_for(result, other, n_fewer, "highest"),
        }
    else:
        n_more = int(np.ceil(n_target**2 / n_fewer))
        worst_for_other = {f"threshold_{moved}": threshold_for(result, moved, n_more, "lowest")}
    return [with_thresholds(result, changed) for changed in (worst_for_other, worst_for_moved)]


def _spread_of_alarms(result: Result) -> float:
    """Standard error of the difference in false alarms, over recordings."""
    recording = result.dataset.frame_columns.recording
    apart = np.bincount(recording, weights=result.x.false_alarms - result.y.false_alarms)
    return float(np.sqrt((apart**2).sum()))


def _miss_rates(evidence: pd.DataFrame) -> list[Evidence]:
    rows = evidence[evidence["figure"] == MISS_RATE].to_dict("records")
    names = [field.name for field in fields(Evidence)]
    return [Evidence(**{name: row[name] for name in names}) for row in rows]
