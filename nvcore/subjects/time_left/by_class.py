"""Time left by the class of the urgent encounters."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from nvcore.common.wording import number
from nvcore.common.wording.footnotes import Footnotes
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import evidence_form
from nvcore.evidence.measures import Evidence
from nvcore.evidence.subgroups import class_groups
from nvcore.evidence.subgroups.table import judge_groups
from nvcore.metrics.encounter_classes import shown_class
from nvcore.report.words import difference_cell, interval_cell
from nvcore.subjects.time_left.steps import is_in_time, time_left_in

SHARE: Final = "in_time_by_unit"
IMPACT: Final = "mean_impact_kmh"
CLASS_HEAD: Final = (
    *("In time X", "In time Y", "X − Y", "95 % interval"),
    *("Impact X (km/h)", "Impact Y (km/h)", "X − Y", "95 % interval"),
)


class OfClass(NamedTuple):
    """Urgent encounters of one class: number, number confirmed in time by X and Y, and evidence."""

    name: str
    n_urgent: int
    in_time_x: int
    in_time_y: int
    share: Evidence
    impact: Evidence

    @property
    def label(self) -> str:
        """Name of the class with its number of urgent encounters."""
        return f"{shown_class(self.name)}, {self.n_urgent:,} urgent"

    def cells(self, notes: Footnotes) -> tuple[tuple[str, ...], str]:
        """Return the cells below `CLASS_HEAD`, and the marks of the row's footnotes."""
        share, share_mark = interval_cell(self.share, notes)
        impact, impact_mark = interval_cell(self.impact, notes)
        form = evidence_form(self.impact.figure)
        cells = (
            *(f"{self.in_time_x:,}", f"{self.in_time_y:,}", difference_cell(self.share), share),
            *(number(value, form) for value in (self.impact.x, self.impact.y)),
            *(difference_cell(self.impact), impact),
        )
        return cells, " ".join(dict.fromkeys(filter(None, (share_mark, impact_mark))))


def time_left_by_class(result: Result) -> tuple[OfClass, ...]:
    """Judge time left for each class of urgent encounters, including distant ones.

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
