"""Comparisons beside the one as set, without which it may mislead: at equal false alarms, strict.

A system with a lower threshold detects more and has more false alarms, and false alarms near a
missed pedestrian raise similarity. So whatever a verdict claims has to hold where both systems have
equally many false alarms, and when boxes are paired strictly.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result, compare
from nvcore.detection.operating_point import threshold_with_alarms
from nvcore.evidence.measures import Evidence, significance_table
from nvcore.metrics.venn import MIN_DISCORDANT
from nvcore.scoring import SystemResult

UNEQUAL: Final = 1.5
"""Numbers of false alarms are unequal if the larger is more than this many times the smaller."""
LEAST_MORE: Final = MIN_DISCORDANT
"""A difference of fewer false alarms may be chance, as with encounters that one system detects."""
ALIKE: Final = 0.1
"""Without scores to set the systems alike, a system may have this share more false alarms."""

STRICT_KEYS: Final = ("mean_similarity", "saliency")
"""Measures that strict pairing changes."""
MISS_RATE: Final = "log_average_miss_rate"


@dataclass(frozen=True, eq=False)
class Companions:
    """The same two systems at equal false alarms, and paired strictly.

    Attributes
    ----------
    equal
        Both at equal false alarms; the result as set where it has them; None: no threshold gives
        them.
    moved
        System with another threshold in `equal`, ``x`` or ``y``; empty: neither.
    evidence
        Evidence of `equal`, p without intervals; None without `equal`.
    strict
        The comparison that the verdict rests on (`equal` where the one as set is unequal), with
        ``pairing="matched"``.
    """

    equal: Result | None
    moved: str
    evidence: pd.DataFrame | None
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
    moved = which_moves(result)
    equal = at_equal_alarms(result, moved)
    basis = equal if are_unequal(result) and equal is not None else result
    strict = basis
    if result.params.pairing != "matched":
        params = replace(basis.params, pairing="matched")
        strict = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=basis)
    if equal is None:
        return Companions(None, "", None, strict)
    if equal is result:
        return Companions(result, "", evidence, strict)
    of_equal = significance_table(equal, _miss_rates(evidence), has_intervals=False)
    return Companions(equal, moved, of_equal, strict)


def which_moves(result: Result) -> str:
    """System whose threshold is moved: of those with scores, the one with more false alarms.

    To raise a threshold is always possible; to lower it leads no further than the scores do.
    """
    movable = [letter for letter in "xy" if has_scores(result, letter)]
    return max(movable, key=lambda letter: count_alarms(result.system(letter)), default="")


def at_equal_alarms(result: Result, moved: str) -> Result | None:
    """Both systems with equally many false alarms, by the threshold of one; None: impossible."""
    n_x, n_y = count_alarms(result.x), count_alarms(result.y)
    if n_x == n_y:
        return result
    if not moved:
        return None
    n_target = n_y if moved == "x" else n_x
    name = result.system(moved).name
    threshold = threshold_with_alarms(result.dataset, name, result.params, n_target)
    changed: dict[str, Any] = {f"threshold_{moved}": threshold}
    params = replace(result.params, **changed)
    equal = compare(result.dataset, params, x=result.x.name, y=result.y.name, previous=result)
    return None if are_unequal(equal) else equal


def _miss_rates(evidence: pd.DataFrame) -> list[Evidence]:
    rows = evidence[evidence["figure"] == MISS_RATE].to_dict("records")
    names = [field.name for field in fields(Evidence)]
    return [Evidence(**{name: row[name] for name in names}) for row in rows]
