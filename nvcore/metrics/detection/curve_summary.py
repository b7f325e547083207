"""Measures of a detection curve, and measures at the current threshold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nvcore.metrics.detection.average_precision import (
    average_precision,
    average_precision_coco,
    pr_auc,
)
from nvcore.metrics.detection.curves import DetectionCurve
from nvcore.metrics.detection.miss_rate import (
    FPPI_REFERENCES,
    explain_range,
    explain_zero,
    log_average_miss_rate,
    miss_rate_at,
)


@dataclass(frozen=True)
class CurveSummary:
    """Measures of one system under one protocol, labelled by `nvcore.comparison.measures`.

    Attributes
    ----------
    log_average_miss_rate
        Averaged over FPPI from 0.01 to 1, 0 is best.
    average_precision_coco, average_precision, pr_auc
        Mean over 101 recalls, area under the monotone curve, and area by Davis and Goadrich; 1 is
        best.
    best_f1, best_f1_threshold
        Largest F1 and the score at which it is reached.
    recall, precision, f1, fppi
        Values at the current threshold.
    n_absorbed
        Number of detections at the current threshold that ignored boxes absorb, so that they are
        neither right nor wrong.
    n_zero_references
        Number of the log-average miss rate's nine references at which nobody is missed. One such
        reference makes the rate 0.
    notes
        Remarks on the log-average miss rate: why it is 0, and the substitutes for the miss rate at
        references that the curve does not reach.
    why_undefined
        Reason why areas and averages are undefined (NaN), or None.
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
    """Compute all measures of a curve, NaN if undefined.

    Parameters
    ----------
    threshold
        Current threshold; None: every detection counts.
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
