"""The comparison that a verdict is about."""

from __future__ import annotations

import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.companions import Companions
from nvcore.evidence.operating_points import are_unequal


def comparison_shown(
    result: Result, evidence: pd.DataFrame | None, companions: Companions | None
) -> tuple[Result, pd.DataFrame | None]:
    """The comparison that the verdict is about, and its evidence; None: it supports nothing.

    Where X and Y are set to different operating points that is the one at equal false alarms.
    """
    if not are_unequal(result):
        return result, evidence
    if companions is None or companions.equal is None:
        return result, None
    return companions.equal.result, companions.evidence
