"""Measures of detection curves."""

from __future__ import annotations

from operator import attrgetter
from typing import Final

from nvcore.comparison.measures.entry import (
    HIGHER,
    LOWER,
    AxisScale,
    Better,
    Inference,
    Measure,
    MeasureTable,
)
from nvcore.settings.stages import MATCH


def _of_curve(
    key: str,
    label: str,
    better: Better,
    form: str,
    rule: str = "",
    *,
    is_worsened_by_alarms: bool = True,
    inference: Inference | None = None,
) -> Measure:
    """Create a measure of the detection curve. Its key is the attribute of `CurveSummary`."""
    return Measure(
        key,
        label,
        form,
        better,
        stages=(MATCH,),
        is_worsened_by_alarms=is_worsened_by_alarms,
        of_curve=attrgetter(key),
        tables=(MeasureTable.DETECTION,),
        rule=rule,
        inference=inference,
    )


CURVE_MEASURES: Final[tuple[Measure, ...]] = (
    _of_curve(
        "log_average_miss_rate",
        "log-average miss rate",
        LOWER,
        ".2%",
        "lamr",
        inference=Inference(
            test="curve",
            scale=AxisScale(".1%", least=1.0, least_reach=1.0),
            form=".1%",
            noun="log-average miss rate",
        ),
    ),
    _of_curve(
        "average_precision_coco", "average precision (COCO, 101 recalls)", HIGHER, ".4f", "ap"
    ),
    _of_curve("average_precision", "average precision (area, monotone)", HIGHER, ".4f", "ap_area"),
    _of_curve("pr_auc", "area under precision-recall (Davis, Goadrich)", HIGHER, ".4f", "pr_auc"),
    _of_curve("best_f1", "best F1 over all thresholds", HIGHER, ".4f"),
    _of_curve(
        "recall", "recall at the threshold", HIGHER, ".4f", "recall", is_worsened_by_alarms=False
    ),
    _of_curve("precision", "precision at the threshold", HIGHER, ".4f", "precision"),
    _of_curve("f1", "F1 at the threshold", HIGHER, ".4f", "f1"),
    _of_curve("fppi", "false positives per image at the threshold", LOWER, ".4f", "fppi"),
    _of_curve(
        "n_absorbed",
        "detections absorbed by ignored boxes at the threshold",
        "",
        "d",
        is_worsened_by_alarms=False,
    ),
)
