"""Areas under the precision-recall curve, in the three common forms."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.metrics.detection.curves import DetectionCurve

# not i / 100: 0.57 differs in the last bit, and recalls are compared with exactly these
COCO_RECALLS: Final = np.linspace(0.0, 1.0, 101)
"""Recalls at which COCO reads precision."""
COCO_RECALLS.flags.writeable = False


def average_precision(curve: DetectionCurve) -> float:
    """Compute the area under the monotone precision-recall curve, 1 is best.

    ``sum over points of (r_i - r_{i-1}) * max over j >= i of p_j``: the step function of Pascal VOC
    since 2010. The result is 0 without detections and NaN if ``curve.why_undefined``.

    References
    ----------
    M. Everingham et al.: The Pascal Visual Object Classes challenge: a retrospective, IJCV 2015.
    """
    if curve.why_undefined:
        return np.nan
    gain = np.diff(curve.recall, prepend=0.0)
    return float((gain * _envelope(curve)).sum())


def average_precision_coco(curve: DetectionCurve) -> float:
    """Compute the mean of the best precision at 101 recalls, 1 is best (COCO, for one IoU).

    At each of 0, 0.01, ..., 1, this takes the largest precision at that recall or a larger one, or
    0 beyond the largest recall. There are three differences from COCO's tools. All detections
    count, whereas COCO takes 100 per picture. Equal scores are one point, whereas COCO takes them
    in file order. Regions absorb a detection from a share of 0.5 on, whereas COCO uses the IoU
    threshold. The result is 0 without detections and NaN if ``curve.why_undefined``.

    References
    ----------
    T.-Y. Lin et al.: Microsoft COCO: common objects in context, ECCV 2014; cocoapi.
    """
    if curve.why_undefined:
        return np.nan
    index = np.searchsorted(curve.recall, COCO_RECALLS, side="left")
    is_reached = index < len(curve)
    return float(_envelope(curve)[index[is_reached]].sum() / len(COCO_RECALLS))


def pr_auc(curve: DetectionCurve) -> float:
    """Compute the area under the precision-recall curve with non-linear interpolation, 1 is best.

    Between two points, true positives increase one by one, and false positives increase by the
    local skew ``(fp_b - fp_a) / (tp_b - tp_a)`` for each. Trapezoids join these steps, because a
    straight line between two points would be too optimistic. The area ends at the largest recall.
    The result is 0 without detections and NaN if ``curve.why_undefined``.

    References
    ----------
    J. Davis, M. Goadrich: The relationship between precision-recall and ROC curves, ICML 2006.
    """
    if curve.why_undefined:
        return np.nan
    tp, before, after = _steps(curve)
    with np.errstate(invalid="ignore"):
        left = (tp - 1) / (tp - 1 + before)
    right = tp / (tp + after)
    # 0 of 0: nothing is detected yet, so take the precision on the way to the first pedestrian
    left = np.where(tp - 1 + before == 0, right, left)
    return float((0.5 * (left + right)).sum() / curve.n_truth)


def _steps(curve: DetectionCurve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each true positive with the false positives before and after its step."""
    tp_at = np.concatenate([[0], curve.tp])
    fp_at = np.concatenate([[0], curve.fp]).astype(float)
    tp = np.arange(1, tp_at[-1] + 1)
    b = np.searchsorted(tp_at, tp, side="left")  # first point with at least that many
    a = b - 1  # last point with fewer
    skew = (fp_at[b] - fp_at[a]) / (tp_at[b] - tp_at[a])
    after = fp_at[a] + skew * (tp - tp_at[a])
    return tp, after - skew, after


def _envelope(curve: DetectionCurve) -> np.ndarray:
    """Return the largest precision at each point's recall or a larger one, (n_points,)."""
    best: np.ndarray = np.maximum.accumulate(curve.precision[::-1])[::-1]
    return best
