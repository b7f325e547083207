"""The kinds of detection curves: what stands on their axes, and what their legends say."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from nvcore.detection.curve_summary import CurveSummary
from nvcore.detection.miss_rate import FPPI_REFERENCES
from nvcore.wording import number

CurveKind = Literal["miss_rate", "precision_recall", "roc", "roc_windows", "f1"]


@dataclass(frozen=True)
class CurveChart:
    """Title, measures on the axes with their titles, what a point says; which are logarithmic."""

    title: str
    x: str
    y: str
    x_title: str
    y_title: str
    hover: str
    x_log: bool = False
    y_log: bool = False


KINDS: Final[dict[CurveKind, CurveChart]] = {
    "miss_rate": CurveChart(
        "Miss rate against false positives",
        "fppi",
        "miss_rate",
        "false positives per image",
        "miss rate (0 is best)",
        "miss rate {miss_rate:.3f}, {fppi:.3g} false positives per image<br>"
        "precision {precision:.3f}",
        x_log=True,
        y_log=True,
    ),
    "precision_recall": CurveChart(
        "Precision against recall",
        "recall",
        "precision",
        "recall (1 is best)",
        "precision (1 is best)",
        "recall {recall:.3f}, precision {precision:.3f}<br>{fppi:.3g} false positives per image",
    ),
    "roc": CurveChart(
        "Detection rate against false positives",
        "fppi",
        "recall",
        "false positives per image",
        "detection rate (1 is best)",
        "detection rate {recall:.3f}, {fppi:.3g} false positives per image<br>"
        "precision {precision:.3f}",
        x_log=True,
    ),
    "roc_windows": CurveChart(
        "Detection rate against false positives per window",
        "fppw",
        "recall",
        "false positives per window",
        "detection rate (1 is best)",
        "detection rate {recall:.3f}, {fppw:.3g} false positives per window<br>"
        "{fppi:.3g} false positives per image, precision {precision:.3f}",
        x_log=True,
    ),
    "f1": CurveChart(
        "F1 against the threshold",
        "threshold",
        "f1",
        "score threshold",
        "F1 (1 is best)",
        "F1 {f1:.3f}<br>recall {recall:.3f}, precision {precision:.3f}<br>"
        "{fppi:.3g} false positives per image",
    ),
}

ON_AXES: Final = {
    "recall": "recall",
    "miss_rate": "miss rate",
    "precision": "precision",
    "fppi": "false positives per image",
    "fppw": "false positives per window",
}


def legend_text(summary: CurveSummary, kind: CurveKind) -> str:
    """The measure that belongs to a kind of curve, for its legend, with why it is 0."""
    if summary.why_undefined is not None:
        return ""
    if kind == "precision_recall":
        return f"AP {summary.average_precision_coco:.3f}"
    if kind == "f1":
        return "" if np.isnan(summary.best_f1) else f"best {summary.best_f1:.3f}"
    if kind != "miss_rate":
        return ""
    n_zero, n = summary.n_zero_references, len(FPPI_REFERENCES)
    if not n_zero:
        return f"LAMR {number(summary.log_average_miss_rate, '.1%')}"
    why = "nothing missed" if n_zero == n else f"0 at {n_zero} of {n} references"
    return f"LAMR 0 % ({why})"
