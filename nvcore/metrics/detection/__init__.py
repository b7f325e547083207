"""Benchmarks: curves, miss rate, average precision, operating points, application of protocols."""

from nvcore.metrics.detection.average_precision import (
    average_precision,
    average_precision_coco,
    pr_auc,
)
from nvcore.metrics.detection.curve_summary import CurveSummary, summarise_curve
from nvcore.metrics.detection.curves import (
    CurvePoint,
    DetectionCurve,
    curve_table,
    detection_curve,
    detection_outcomes,
)
from nvcore.metrics.detection.filtered_truth import (
    FilteredTruth,
    filter_detections,
    filter_truth,
    known_tags,
)
from nvcore.metrics.detection.miss_rate import log_average_miss_rate, miss_rate_at
from nvcore.metrics.detection.operating_point import (
    OperatingPoint,
    SameOperatingPoint,
    false_alarm_curve,
    operating_point,
    same_operating_point,
    score_histogram,
    threshold_for,
)
from nvcore.metrics.detection.windows import WindowGrid, scale_steps, windows_per_image

__all__ = [
    "CurvePoint",
    "CurveSummary",
    "DetectionCurve",
    "FilteredTruth",
    "OperatingPoint",
    "SameOperatingPoint",
    "WindowGrid",
    "average_precision",
    "average_precision_coco",
    "curve_table",
    "detection_curve",
    "detection_outcomes",
    "false_alarm_curve",
    "filter_detections",
    "filter_truth",
    "known_tags",
    "log_average_miss_rate",
    "miss_rate_at",
    "operating_point",
    "pr_auc",
    "same_operating_point",
    "scale_steps",
    "score_histogram",
    "summarise_curve",
    "threshold_for",
    "windows_per_image",
]
