"""Values that mean something else in each format: occlusion, distance, detectability."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.findings import Finding, Severity
from nvcore.inputs.readers.base import Lines, Role
from nvcore.schema import UNKNOWN_OCCLUSION

PARTIAL_OCCLUSION: Final = 0.35
"""Occluded share up to which an occlusion is partial (Caltech's limit)."""


def levels_of_visible_share(visible: np.ndarray) -> np.ndarray:
    """Levels from the visible share in [0, 1]; UNKNOWN_OCCLUSION where it is NaN or outside."""
    occluded = 1 - visible
    level = np.where(occluded <= 0, 0, np.where(occluded <= PARTIAL_OCCLUSION + 1e-9, 1, 2))
    is_known = (visible >= 0) & (visible <= 1)
    return np.where(is_known, level, UNKNOWN_OCCLUSION).astype(np.int8)


def levels_of_numbers(values: np.ndarray) -> np.ndarray:
    """Levels 0, 1, 2 kept; UNKNOWN_OCCLUSION for everything else, NaN too."""
    is_known = np.isin(values, (0.0, 1.0, 2.0))
    return np.where(is_known, values, UNKNOWN_OCCLUSION).astype(np.int8)


def level_of_words(words: str) -> int:
    """Level of JAAD's words (none, part, full) and FLIR's (``no_(fully_visible)``, ...).

    Examples
    --------
    >>> [*map(level_of_words, ["none", "partially_occluded", "full", "no_(fully_visible)", "?"])]
    [0, 1, 2, 0, -1]
    """
    lowered = words.strip().lower().replace(" ", "_")
    if lowered in ("0", "1", "2"):
        return int(lowered)
    if lowered.startswith("no") or "fully_visible" in lowered:
        return 0
    if "part" in lowered:
        return 1
    is_heavy = any(word in lowered for word in ("difficult", "heav", "full", "complete"))
    return 2 if is_heavy else UNKNOWN_OCCLUSION


def odd_levels(values: np.ndarray, lines: Lines, role: Role) -> list[Finding]:
    """Finding about numbers that are no level: neither 0, 1, 2, nor -1 or NaN for unknown."""
    return lines.finding(
        ~(np.isin(values, (0.0, 1.0, 2.0, -1.0)) | np.isnan(values)),
        "unknown-occlusion",
        "Levels of occlusion other than 0 (none), 1 (partial), 2 (heavy) are taken as unknown.",
        "Write the level as 0, 1 or 2, or leave it empty.",
        role=role,
        example=lambda row: f"{values[row]:g}",
    )


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


def checked_detectability(values: np.ndarray, lines: Lines) -> np.ndarray:
    """The values, each from 0 to 1 or unknown (NaN); float64, shape (n,).

    Raises
    ------
    FormatError
        With the line of the first that is outside.
    """
    return checked_numbers(values, lines, "detectability", high=1.0)


def checked_numbers(
    values: np.ndarray, lines: Lines, name: str, *, high: float = np.inf
) -> np.ndarray:
    """The values of a column, each from 0 to `high` or NaN; infinity is none.

    Raises
    ------
    FormatError
        With the line of the first that is outside.
    """
    is_good = np.isnan(values) | ((values >= 0) & (values <= high) & ~np.isinf(values))
    if not is_good.all():
        row = int(np.argmin(is_good))
        expected = f"from 0 to {high:g}" if np.isfinite(high) else "of 0 or more"
        raise lines.fault(row, f"expected a {name} {expected}, found {values[row]:g}")
    return values
