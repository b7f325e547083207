"""The measures of a detection curve, and those at the threshold in use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nvcore.detection.average_precision import average_precision, average_precision_coco, pr_auc
from nvcore.detection.curves import DetectionCurve
from nvcore.detection.miss_rate import (
    FPPI_REFERENCES,
    explain_range,
    explain_zero,
    log_average_miss_rate,
    miss_rate_at,
)


@dataclass(frozen=True)
class CurveSummary:
    """Measures of one system under one protocol; tables name them by `nvcore.measures`.

    Attributes
    ----------
    log_average_miss_rate
        Over FPPI from 0.01 to 1, 0 is best.
    average_precision_coco, average_precision, pr_auc
        101 recalls; area under the monotone curve; area by Davis and Goadrich. 1 is best.
    best_f1, best_f1_threshold
        Largest F1 and the score that attains it.
    recall, precision, f1, fppi
        At the threshold in use.
    n_absorbed
        Detections at the threshold in use that are neither right nor wrong: an ignored box
        absorbs them.
    n_zero_references
        At how many of the nine references of the log-average miss rate no one is missed; one such
        reference makes it 0.
    notes
        What the log-average miss rate alone does not show: why it is 0, and what replaces the
        miss rate where the curve does not reach the references.
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
    n_absorbed: int
    n_zero_references: int
    notes: tuple[str, ...]
    why_undefined: str | None


def summarise_curve(curve: DetectionCurve, threshold: float | None) -> CurveSummary:
    """All measures of a curve; undefined ones are NaN.

    Parameters
    ----------
    threshold
        In use; None: every detection counts.
    """
    point = curve.at(threshold)
    rates = miss_rate_at(curve, FPPI_REFERENCES)
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
        n_absorbed=curve.n_absorbed(threshold),
        n_zero_references=int(np.count_nonzero(rates == 0)),
        notes=tuple(filter(None, (explain_zero(rates), *explain_range(curve, rates)))),
        why_undefined=curve.why_undefined,
    )
