"""Comparisons beside the one as set, without which it may mislead: at equal false alarms, strict.

A system with a lower threshold detects more and has more false alarms, and false alarms near a
missed pedestrian raise similarity. So whatever a verdict claims has to hold where both systems have
equally many false alarms, and when boxes are paired strictly.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Final, Literal

import numpy as np
import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.detection.operating_point import threshold_with_alarms
from nvcore.evidence.measures import Evidence, significance_table
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.metrics.venn import MIN_DISCORDANT
from nvcore.scoring import SystemResult

UNEQUAL: Final = 1.5
"""Numbers of false alarms are unequal if the larger is more than this many times the smaller."""
LEAST_MORE: Final = MIN_DISCORDANT
"""A difference of fewer false alarms may be chance, as with encounters that one system detects."""

STRICT_KEYS: Final = ("mean_similarity", "saliency")
"""Measures that strict pairing changes."""
ENDS: Final[tuple[Literal["lowest", "highest"], ...]] = ("lowest", "highest")
MISS_RATE: Final = "log_average_miss_rate"


@dataclass(frozen=True, eq=False)
class Companions:
    """The same two systems at equal false alarms, and paired strictly.

    A number of false alarms holds for a range of thresholds. A claim has to hold at both ends of
    it, since the other system's threshold may be anywhere in its own range.

    Attributes
    ----------
    equal
        Both at equal false alarms, the threshold about as low as these allow; None: no threshold
        gives them, or it is not asked: X and Y are set alike, and no difference could be claimed.
    moved
        System with another threshold in `equal`, ``x`` or ``y``; empty: neither.
    evidence
        Evidence at the lowest and at the highest such threshold: p without intervals. Empty
        without `equal`.
    strict
        The comparison that the verdict rests on (`equal` where the one as set is unequal), with
        ``pairing="matched"``.
    """

    equal: Result | None
    moved: str
    evidence: tuple[pd.DataFrame, ...]
    strict: Result


def count_alarms(system: SystemResult) -> int:
    """False alarms of a system, 0 is best."""
    return int(system.false_alarms.sum())


def are_unequal(result: Result) -> bool:
    """Whether X and Y are set to different operating points, so that neither can be preferred."""
    fewer, more = sorted(count_alarms(system) for _, system in result.sides)
    return more > UNEQUAL * fewer and more - fewer >= LEAST_MORE


def has_scores(result: Result, letter: str) -> bool:
    """Whether a threshold could move this system."""
    return bool(np.isfinite(result.dataset.system(result.system(letter).name).score).any())


def find_companions(result: Result, evidence: pd.DataFrame) -> Companions:
    """The companions of a comparison, made from its own stages.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result; its miss rate does not depend on
        thresholds and is taken over.
    """
    is_unequal = are_unequal(result)
    has_candidates = bool((evidence["p_holm"] <= SIGNIFICANT).any())
    moved = which_moves(result) if is_unequal or has_candidates else ""
    equal = _at_equal_alarms(result, moved, "round") if moved else None
    if equal is not None and are_unequal(equal):
        equal = None
    basis = equal if equal is not None and is_unequal else result
    strict = basis
    if result.params.pairing != "matched":
        params = replace(basis.params, pairing="matched")
        strict = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=basis)
    if equal is None:
        return Companions(None, "", (), strict)
    has_p = bool(np.isfinite(evidence["p_holm"]).any())
    ends = [_at_equal_alarms(result, moved, end) for end in ENDS] if has_p else [equal]
    tables = [
        significance_table(at_end, _miss_rates(evidence), has_intervals=False) for at_end in ends
    ]
    return Companions(equal, moved, tuple(tables), strict)


def which_moves(result: Result) -> str:
    """System whose threshold is moved: of those with scores, the one with more false alarms.

    To raise a threshold is always possible; to lower it leads no further than the scores do.
    """
    movable = [letter for letter in "xy" if has_scores(result, letter)]

    def size(letter: str) -> tuple[int, int]:
        system = result.system(letter)
        return count_alarms(system), int(system.n_det.sum())

    return max(movable, key=size, default="")


def _at_equal_alarms(
    result: Result, moved: str, end: Literal["round", "lowest", "highest"]
) -> Result:
    """Both systems with equally many false alarms, at an end of the range of such thresholds."""
    n_target = count_alarms(result.y if moved == "x" else result.x)
    x, y = result.x.name, result.y.name
    name = result.system(moved).name
    threshold = threshold_with_alarms(result.dataset, name, result.params, n_target, end=end)
    changed: dict[str, Any] = {f"threshold_{moved}": threshold}
    params = replace(result.params, **changed)
    return compare(result.dataset, params, x=x, y=y, previous=result)


def _miss_rates(evidence: pd.DataFrame) -> list[Evidence]:
    rows = evidence[evidence["figure"] == MISS_RATE].to_dict("records")
    names = [field.name for field in fields(Evidence)]
    return [Evidence(**{name: row[name] for name in names}) for row in rows]
