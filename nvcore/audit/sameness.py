"""The same boxes given twice: as X and Y, or as ground truth and as a system."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.audit.boxes import repeated_rows
from nvcore.audit.cases import Audited
from nvcore.dataset import BoxColumns
from nvcore.findings import Finding, Severity

MIN_BOXES: Final = 20
"""Fewer boxes than this may be the same by chance."""
SAME_SHARE: Final = 0.95
"""Share of a system's boxes that are exactly the truth's from which on it is no chance."""


def audit_same_as_truth(audited: Audited) -> list[Finding]:
    """A system nearly all of whose boxes are exactly those of the ground truth."""
    boxes, truth = audited.boxes, audited.dataset.truth
    n = len(boxes)
    if n < MIN_BOXES:
        return []
    both = tuple(
        np.concatenate(pair) for pair in zip(_columns(truth), _columns(boxes), strict=True)
    )
    repeats = repeated_rows(np.arange(len(truth) + n), both)
    repeats = repeats[repeats >= len(truth)]
    if len(repeats) < SAME_SHARE * n:
        return []
    # a system's box that repeats its own must not pass for one of the truth
    n_doubles = len(repeated_rows(np.arange(n), _columns(boxes)))
    n_same, n_different = len(repeats) - n_doubles, n - n_doubles
    if n_same < max(MIN_BOXES, SAME_SHARE * n_different):
        return []
    return [
        audited.finding(
            Severity.WARNING,
            "same-boxes",
            repeats - len(truth),
            f"{n_same:,} of {n_different:,} boxes are exactly those of the ground truth.",
            "Check whether the ground truth was given as a system, or the ground truth made from "
            "this system's detections: no detector draws the very same boxes.",
            count=n_same,
        )
    ]


def audit_same_systems(x: Audited, y: Audited, counting: tuple[BoxColumns, ...]) -> list[Finding]:
    """X and Y with the very same boxes in the same frames.

    Parameters
    ----------
    counting
        The detections of X and of Y that pass their thresholds: one file at two thresholds is a
        comparison, too.
    """
    of_x, of_y = counting
    if len(of_x) != len(of_y) or len(of_x) < MIN_BOXES:
        return []
    if not np.array_equal(of_x.offsets, of_y.offsets):
        return []
    in_x, in_y = (
        np.stack(columns)[:, np.lexsort(columns[::-1])]
        for columns in (_columns(of_x), _columns(of_y))
    )
    if not np.array_equal(in_x, in_y):
        return []
    return [
        x.finding(
            Severity.WARNING,
            "same-boxes",
            np.arange(1),
            f"{x.name} and {y.name} have exactly the same {len(of_x):,} boxes.",
            "Check whether the same file was given twice: the comparison cannot tell the two "
            "apart.",
            count=len(of_x),
        )
    ]


def _columns(boxes: BoxColumns) -> tuple[np.ndarray, ...]:
    return boxes.frame_index, boxes.x, boxes.y, boxes.w, boxes.h
