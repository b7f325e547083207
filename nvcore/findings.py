"""What is wrong or suspicious in the inputs, as `Finding` objects.

Readers, the dataset builder and the audit report through the same type, so that the command line
and the dashboard show a single list, worst first.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Literal

import numpy as np


class Severity(StrEnum):
    """How bad a finding is: an error makes measures wrong, a warning may, a note does not."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


_ORDER = {Severity.ERROR: 0, Severity.WARNING: 1, Severity.NOTE: 2}


@dataclass(frozen=True, eq=False)
class Cases:
    """Every place that a finding concerns, as rows of a table of the audited dataset.

    `nvcore.tables.finding_entries` says recording, frame and box of each.

    Attributes
    ----------
    table
        Which table: ``boxes``, ``frames`` or ``left_out``.
    rows
        Rows of it; int, shape (n,).
    """

    table: Literal["boxes", "frames", "left_out"]
    rows: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong or suspicious in the inputs.

    Attributes
    ----------
    severity
        `error`: the measures are wrong until it is fixed; `warning`: they may be; `note`: good to
        know.
    code
        Short stable name in kebab case, such as ``duplicate-track``.
    subject
        What it is about: ``truth`` or the name of a system.
    count
        How many rows, frames or recordings it concerns.
    message
        What was found, in a sentence.
    advice
        What to do about it, in a sentence.
    file
        File in which it was first seen; empty where no single file is to blame.
    example
        The first case: line, recording, frame.
    suggestion
        Corrections, each with its key in the session file, such as
        ``(("offset_frames", -2.0),)``, for a page that offers to apply them; empty: none.
    cases
        All places that it concerns; None: an input as a whole, or not known.
    """

    severity: Severity
    code: str
    subject: str
    count: int
    message: str
    advice: str
    file: str = ""
    example: str = ""
    suggestion: tuple[tuple[str, float], ...] = ()
    cases: Cases | None = field(default=None, compare=False, repr=False)


def worst_first(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings sorted by severity, the order within one severity kept."""
    return tuple(sorted(findings, key=lambda finding: _ORDER[finding.severity]))
