"""Proximity by distance where only some of the compared boxes have one."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.audit.cases import Audited
from nvcore.findings import Finding, Severity
from nvcore.params import Params

SHARE_APART: Final = 0.5
"""Difference of the shares without distance from which on two sources are weighted unlike."""


def audit_weighting(truth: Audited, x: Audited, y: Audited, params: Params) -> list[Finding]:
    """X, Y and truth weighted by different rules, because one of them lacks distances.

    Only with proximity by distance. A box without a distance is weighted by its height, so that a
    false alarm of one system may weigh more than the same one of the other.
    """
    if params.proximity != "distance":
        return []
    without = [(one, np.flatnonzero(np.isnan(one.boxes.distance_m))) for one in (truth, x, y)]
    shares = [len(rows) / len(one.boxes) if len(one.boxes) else np.nan for one, rows in without]
    least = np.nanmin(shares, initial=1.0)
    return [
        one.finding(
            Severity.WARNING,
            "mixed-weighting",
            rows,
            f"{share:.0%} of the boxes have no distance and are weighted by their height, the "
            f"others by metres; of the truth, X and Y the least is {least:.0%}.",
            "Compare with --proximity height, which all boxes have, or give the distances.",
        )
        for (one, rows), share in zip(without, shares, strict=True)
        if share - least >= SHARE_APART
    ]
