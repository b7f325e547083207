"""Survey of all stability maps in one table: the settings that affect the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
import pandas as pd

from nvcore.common.errors import InputError
from nvcore.common.progress import Progress, no_progress, part_of
from nvcore.comparison.compare import Result
from nvcore.evidence.stability.axes import Plane
from nvcore.evidence.stability.map import StabilityMap, map_stability
from nvcore.evidence.stability.notes import CRITERIA, PLANES, nearest_text, share_text, winner_text
from nvcore.evidence.stability.scores import Criterion

SURVEY_PLANES: Final = tuple(plane for plane in PLANES if plane != "edge-weight")
"""Planes that together contain every setting that a map can change."""
NOTHING: Final = "–"
SURVEY_COLUMNS: Final = ("plane", "criterion", "settings", "by", "verdict", "share", "nearest")


@dataclass(frozen=True, eq=False)
class SurveyRow:
    """Stability map, or the reason for having none.

    Attributes
    ----------
    plane, criterion
        Identifiers of the map.
    stability
        The map, or None if these data do not allow it.
    why_not
        Reason for having no map, else empty.
    """

    plane: Plane
    criterion: Criterion
    stability: StabilityMap | None
    why_not: str = ""

    @property
    def is_dependent(self) -> bool:
        """True if there is a map and the criterion depends on any of its settings."""
        return self.stability is not None and any(self.stability.is_moved_by)


def survey_stability(
    result: Result, *, executor: Executor | None = None, progress: Progress = no_progress
) -> tuple[SurveyRow, ...]:
    """Compute the map of each plane in `SURVEY_PLANES` by every criterion (`map_stability`)."""
    maps, rows = [*product(SURVEY_PLANES, CRITERIA)], []
    for number, (plane, criterion) in enumerate(maps):
        part = part_of(progress, number / len(maps), (number + 1) / len(maps))
        try:
            stability = map_stability(result, plane, criterion, executor=executor, progress=part)
        except InputError as error:
            rows.append(SurveyRow(plane, criterion, None, str(error)))
        else:
            rows.append(SurveyRow(plane, criterion, stability))
    return tuple(rows)


def survey_table(survey: Sequence[SurveyRow]) -> pd.DataFrame:
    """Describe each map in words, one row per map.

    Returns
    -------
    Columns `SURVEY_COLUMNS`, texts: the settings, the criterion, the verdict as analysed, the share
    of the plausible range in which it holds, and the nearest setting that overturns it.
    """
    rows = []
    for row in survey:
        stability, verdict, nearest = row.stability, NOTHING, row.why_not
        if stability is not None:
            verdict = winner_text(row.criterion, stability.verdict, stability.present_difference)
            nearest = nearest_text(stability) if row.is_dependent else NOTHING
        settings, by = PLANES[row.plane], CRITERIA[row.criterion]
        rows.append((row.plane, row.criterion, settings, by, verdict, held_text(row), nearest))
    return pd.DataFrame(rows, columns=list(SURVEY_COLUMNS))


def held_text(row: SurveyRow) -> str:
    """Describe in a few words the share of the plausible range in which the verdict holds."""
    if row.stability is None:
        return "no such map"
    if row.stability.verdict == "undefined":
        return "undefined"
    if not row.is_dependent:
        return "does not depend on them"
    if np.isnan(row.stability.share_held):
        return "undefined there"
    return share_text(row.stability.share_held)
