"""Time left by the class of the urgent encounters."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from nvcore.comparison import Result
from nvcore.evidence.measures import Evidence
from nvcore.evidence.subgroup_table import judge_groups
from nvcore.evidence.subgroups import class_groups
from nvcore.time_left.steps import is_in_time, time_left_in

SHARE: Final = "in_time_by_unit"
IMPACT: Final = "mean_impact_kmh"


class OfClass(NamedTuple):
    """The urgent encounters of a class: how many, confirmed in time by X and Y, and evidence."""

    name: str
    n_urgent: int
    in_time_x: int
    in_time_y: int
    share: Evidence
    impact: Evidence


def time_left_by_class(result: Result) -> tuple[OfClass, ...]:
    """Time left for each class that urgent encounters have; distant ones count, too.

    An encounter of several classes is in each of them.
    """
    groups = class_groups(result, time_left_in(result).is_urgent)
    judged = judge_groups(result, groups, (SHARE, IMPACT))
    rows = []
    for group in groups:
        x, y = (
            int(np.count_nonzero(group.is_member & is_in_time(system)))
            for _, system in result.sides
        )
        n = int(np.count_nonzero(group.is_member))
        evidence = judged[group.group]
        rows.append(OfClass(group.group, n, x, y, evidence[SHARE], evidence[IMPACT]))
    return tuple(rows)
