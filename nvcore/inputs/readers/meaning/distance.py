"""Distances, of which 0 and negative ones say that it is not known."""

from __future__ import annotations

import numpy as np

from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import Lines, Role


def known_distances(metres: np.ndarray) -> np.ndarray:
    """The distances in metres; NaN where the files say 0, -1, -1000 or the like; shape (n,)."""
    with np.errstate(invalid="ignore"):
        return np.where(metres > 0, metres, np.nan)


def odd_distances(metres: np.ndarray, lines: Lines, role: Role) -> list[Finding]:
    """A note on distances that are not above 0."""
    with np.errstate(invalid="ignore"):
        is_odd = metres <= 0
    return lines.finding(
        is_odd,
        "unknown-distance",
        "Distances of 0 or less are taken as unknown.",
        "Leave distances empty that are not known.",
        role=role,
        example=lambda row: f"{metres[row]:g} m",
        severity=Severity.NOTE,
    )
