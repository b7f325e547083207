"""All maps at once: on which settings the verdict depends, and on which it does not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.errors import InputError
from nvcore.progress import Progress
from nvcore.stability.axes import Plane
from nvcore.stability.map import StabilityMap, map_stability
from nvcore.stability.scores import Criterion
from nvcore.stability.words import CRITERIA, PLANES, nearest_text, share_text, winner_text

SURVEY_PLANES: Final[tuple[Plane, ...]] = (
    "alpha-midpoint", "thresholds", "matching", "edge-weight-alpha",
)  # fmt: skip
"""Every setting that a map moves is in one of them."""
NOTHING: Final = "–"
STEPS: Final = 1000
"""Steps of progress of one map."""
SURVEY_COLUMNS: Final = ("plane", "criterion", "settings", "by", "verdict", "share", "nearest")


@dataclass(frozen=True, eq=False)
class SurveyRow:
    """One map, or why there is none.

    Attributes
    ----------
    plane, criterion
        Which map.
    found
        None if these data have no such map.
    why_not
        In words; empty if there is one.
    """

    plane: Plane
    criterion: Criterion
    stability: StabilityMap | None
    why_not: str = ""

    @property
    def is_dependent(self) -> bool:
        """Whether there is a map, and any of its settings enters into the criterion."""
        return self.stability is not None and any(self.stability.is_moved_by)


def survey_stability(
    result: Result,
    *,
    executor: Executor | None = None,
    progress: Progress | None = None,
    is_cancelled: Callable[[], bool] | None = None,
) -> tuple[SurveyRow, ...]:
    """The maps of `SURVEY_PLANES` by every criterion; parameters as of `map_stability`.

    Raises
    ------
    concurrent.futures.CancelledError
        If `is_cancelled` said so.
    """
    wanted: list[tuple[Plane, Criterion]] = [(p, c) for p in SURVEY_PLANES for c in CRITERIA]
    rows = []
    for number, (plane, criterion) in enumerate(wanted):

        def tell(done: int, total: int, before: int = number) -> None:
            if progress is not None:
                progress(before * STEPS + STEPS * done // total, len(wanted) * STEPS)

        try:
            stability = map_stability(
                result, plane, criterion, executor=executor, progress=tell,
                is_cancelled=is_cancelled,
            )  # fmt: skip
        except InputError as error:
            rows.append(SurveyRow(plane, criterion, None, str(error)))
        else:
            rows.append(SurveyRow(plane, criterion, stability))
    return tuple(rows)


def survey_table(survey: Sequence[SurveyRow]) -> pd.DataFrame:
    """The maps in words, one row each.

    Returns
    -------
    Columns `SURVEY_COLUMNS`, texts: the settings, what is compared, the verdict as analysed, in
    which share of the plausible range it holds, and the nearest setting that overturns it.
    """
    rows = []
    for row in survey:
        stability, verdict, nearest = row.stability, NOTHING, row.why_not
        if stability is not None:
            verdict = winner_text(row.criterion, stability.verdict, stability.present_difference)
            nearest = nearest_text(stability) if row.is_dependent else NOTHING
        rows.append((
            row.plane, row.criterion, PLANES[row.plane], CRITERIA[row.criterion], verdict,
            held_text(row), nearest,
        ))  # fmt: skip
    return pd.DataFrame(rows, columns=list(SURVEY_COLUMNS))


def held_text(one: SurveyRow) -> str:
    """In which share of the plausible range the verdict holds, in a few words."""
    if one.stability is None:
        return "no such map"
    if one.stability.verdict == "undefined":
        return "undefined"
    if not one.is_dependent:
        return "does not depend on them"
    if np.isnan(one.stability.share_held):
        return "undefined there"
    return share_text(one.stability.share_held)
