"""The figures of a detection curve, and those at the threshold in use, for a table."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from nvcore.average_precision import average_precision, average_precision_coco, pr_auc
from nvcore.curves import DetectionCurve
from nvcore.miss_rate import log_average_miss_rate


@dataclass(frozen=True)
class CurveSummary:
    """Figures of one system under one protocol.

    Attributes
    ----------
    log_average_miss_rate
        Over FPPI from 0.01 to 1, 0 is best.
    average_precision_coco, average_precision, pr_auc
        101 recalls; area under the monotone curve; area by Davis and Goadrich. 1 is best.
    best_f1, best_f1_threshold
        Largest F1 and the score at which it stands.
    recall, precision, f1, fppi
        At the threshold in use.
    why_undefined
        Why areas and averages are undefined (NaN); None where they are defined.
    """

    log_average_miss_rate: float
    average_precision_coco: float
    average_precision: float
    pr_auc: float
    best_f1: float
    best_f1_threshold: float
    recall: float
    precision: float
    f1: float
    fppi: float
    why_undefined: str | None


SUMMARY_ROWS: Final = (
    ("log_average_miss_rate", "log-average miss rate", "lower", ".2%"),
    ("average_precision_coco", "average precision (COCO, 101 recalls)", "higher", ".4f"),
    ("average_precision", "average precision (area, monotone)", "higher", ".4f"),
    ("pr_auc", "area under precision-recall (Davis, Goadrich)", "higher", ".4f"),
    ("best_f1", "best F1 over all thresholds", "higher", ".4f"),
    ("recall", "recall at the threshold", "higher", ".4f"),
    ("precision", "precision at the threshold", "higher", ".4f"),
    ("f1", "F1 at the threshold", "higher", ".4f"),
    ("fppi", "false positives per image at the threshold", "lower", ".4f"),
)
"""Attribute, what it is called, which way is better, and its format."""


def summarise_curve(curve: DetectionCurve, threshold: float | None) -> CurveSummary:
    """All figures of a curve; undefined ones are NaN.

    Parameters
    ----------
    threshold
        In use; None: every detection counts.
    """
    point = curve.at(threshold)
    f1 = curve.f1
    best = int(np.nanargmax(f1)) if np.isfinite(f1).any() else None
    return CurveSummary(
        log_average_miss_rate=log_average_miss_rate(curve),
        average_precision_coco=average_precision_coco(curve),
        average_precision=average_precision(curve),
        pr_auc=pr_auc(curve),
        best_f1=np.nan if best is None else float(f1[best]),
        best_f1_threshold=np.nan if best is None else float(curve.threshold[best]),
        recall=point.recall,
        precision=point.precision,
        f1=point.f1,
        fppi=point.fppi,
        why_undefined=curve.why_undefined,
    )
