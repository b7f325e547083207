"""Detection curves of X and Y with the operating points in use."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
import plotly.graph_objects as go

from nvcore.curves import DetectionCurve
from nvcore.figures.style import (
    DASH,
    LOOK,
    SYMBOL,
    axis,
    click_markers,
    count_text,
    empty_figure,
    layout,
    steady_marker,
    system_label,
)
from nvcore.palette import Theme

CurveKind = Literal["miss_rate", "precision_recall", "roc", "roc_windows", "f1"]

MAX_POINTS: Final = 600
"""Points of a curve that are drawn and can be clicked, evenly over the axis."""
FPPI_TICKS: Final = (0.001, 0.01, 0.1, 1.0, 10.0)
RATE_TICKS: Final = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
MOST_LOW_RATE: Final = 0.1
"""The axis of miss rates reaches down to this at least, so that a flat curve looks flat."""
MARKER_PX: Final = 13


@dataclass(frozen=True)
class _Kind:
    title: str
    x: str
    y: str
    x_title: str
    y_title: str
    x_log: bool = False
    y_log: bool = False


KINDS: Final[dict[CurveKind, _Kind]] = {
    "miss_rate": _Kind(
        "Miss rate against false positives", "fppi", "miss_rate", "false positives per image",
        "miss rate (0 is best)", x_log=True, y_log=True,
    ),
    "precision_recall": _Kind(
        "Precision against recall", "recall", "precision", "recall (1 is best)",
        "precision (1 is best)",
    ),
    "roc": _Kind(
        "Detection rate against false positives", "fppi", "recall", "false positives per image",
        "detection rate (1 is best)", x_log=True,
    ),
    "roc_windows": _Kind(
        "Detection rate against false positives per window", "fppw", "recall",
        "false positives per window", "detection rate (1 is best)", x_log=True,
    ),
    "f1": _Kind("F1 against the threshold", "threshold", "f1", "score threshold", "F1 (1 is best)"),
}  # fmt: skip


def curve_plot(
    curves: Sequence[DetectionCurve],
    thresholds: Sequence[float | None],
    kind: CurveKind,
    *,
    theme: Theme,
    summaries: Sequence[str] = ("", ""),
    windows_per_image: float | None = None,
) -> go.Figure:
    """Curves of X and Y; a large mark at the threshold in use.

    A click gives the threshold: `customdata` is the pair of the system's letter and the score.

    Parameters
    ----------
    curves
        Of X and Y (`nvcore.curves.detection_curve`).
    thresholds
        Thresholds in use of X and Y; None: every detection counts.
    summaries
        What the legend says behind the names, such as the log-average miss rates.
    windows_per_image
        For false positives per window (`nvcore.windows`).
    """
    of, look = KINDS[kind], LOOK[theme]
    lines, marks, clicks = [], [], []
    for letter, curve, threshold, summary in zip("xy", curves, thresholds, summaries, strict=False):
        x, y, at = _drawn(curve, of, windows_per_image)
        name = system_label(letter, curve.system) + (f", {summary}" if summary else "")
        text = [_text(curve, letter, i) for i in at]
        lines.append(
            go.Scatter(
                x=x, y=y, mode="lines" if curve.is_ranked else "markers", hoverinfo="skip",
                line={"color": look.of(letter), "width": 2.4, "dash": DASH[letter]},
                marker={"color": look.of(letter), "symbol": SYMBOL[letter], "size": 9}, name=name,
            )
        )  # fmt: skip
        data = [[letter, float(curve.threshold[i])] for i in at]
        clicks.append(
            click_markers(
                x=x, y=y, customdata=data, text=text, hovertemplate="%{text}<extra></extra>",
                name=f"{letter.upper()}, points",
            )
        )  # fmt: skip
        marks += _operating_point(curve, of, threshold, letter, windows_per_image, theme)
    if not any(len(line.x) for line in lines):
        return empty_figure(_why_empty(curves, kind), theme=theme, height=300)
    return go.Figure(
        [*lines, *marks, *clicks],
        layout(
            theme,
            title=of.title,
            subtitle=_extent(curves[0]),
            height=420,
            **_axes(of, lines, theme),
        ),
    )


def _values(curve: DetectionCurve, name: str, windows: float | None) -> np.ndarray:
    if name == "fppw":
        return np.full(len(curve), np.nan) if windows is None else curve.fppw(windows)
    values: np.ndarray = getattr(curve, name)
    return values


def _drawn(
    curve: DetectionCurve, of: _Kind, windows: float | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both coordinates of the points drawn, and their rows in the curve."""
    x, y = _values(curve, of.x, windows), _values(curve, of.y, windows)
    is_drawn = np.isfinite(x) & np.isfinite(y)
    for values, is_log in ((x, of.x_log), (y, of.y_log)):
        if is_log:
            is_drawn &= values > 0
    rows = np.flatnonzero(is_drawn)
    if len(rows) > MAX_POINTS:
        along = np.log(x[rows]) if of.x_log else x[rows]
        span = np.ptp(along) or 1.0
        column = np.floor((along - along.min()) / span * (MAX_POINTS - 2)).astype(np.int64)
        is_last = np.concatenate([column[1:] != column[:-1], [True]])
        is_last[0] = True
        rows = rows[is_last]
    return x[rows], y[rows], rows


def _operating_point(
    curve: DetectionCurve,
    of: _Kind,
    threshold: float | None,
    letter: str,
    windows: float | None,
    theme: Theme,
) -> list[go.Scatter]:
    """A large mark at the threshold in use; none where the axes cannot show it."""
    limit = -np.inf if threshold is None else threshold
    row = int(np.searchsorted(-curve.threshold, -limit, side="right")) - 1
    if row < 0:
        return []
    x, y = _values(curve, of.x, windows)[row], _values(curve, of.y, windows)[row]
    if not (np.isfinite(x) and np.isfinite(y)) or (of.x_log and x <= 0) or (of.y_log and y <= 0):
        return []
    look = LOOK[theme]
    marker = steady_marker(
        color=look.of(letter), size=MARKER_PX, symbol=SYMBOL[letter],
        line={"width": 2, "color": look.surface},
    )  # fmt: skip
    return [
        go.Scatter(
            x=[x], y=[y], mode="markers", name=f"{letter.upper()} as set", showlegend=False,
            text=[_text(curve, letter, row)], hovertemplate="in use: %{text}<extra></extra>",
            customdata=[[letter, float(curve.threshold[row])]], **marker,
        )
    ]  # fmt: skip


def _text(curve: DetectionCurve, letter: str, row: int) -> str:
    # of this point only: the curve's own properties are arrays of all its points
    tp, fp = int(curve.tp[row]), int(curve.fp[row])
    precision = tp / (tp + fp) if tp + fp else float("nan")
    recall, fppi = tp / max(curve.n_truth, 1), fp / max(curve.n_images, 1)
    return (
        f"{letter.upper()}, score ≥ {curve.threshold[row]:.4g}<br>recall {recall:.3f}, precision "
        f"{precision:.3f}<br>{fppi:.3g} false positives per image"
    )


def _extent(curve: DetectionCurve) -> str:
    return (
        f"{count_text(curve.n_truth, 'pedestrian')} in {count_text(curve.n_images, 'image')}; "
        "large marks: thresholds in use; click a curve to set its threshold"
    )


def _why_empty(curves: Sequence[DetectionCurve], kind: CurveKind) -> str:
    if kind == "roc_windows":
        return "Give the number of windows per image to see false positives per window."
    if not curves or not curves[0].n_truth:
        return "No pedestrian counts under this protocol."
    return "There are no detections to draw, or none of them is a false positive."


def _axes(of: _Kind, lines: Sequence[go.Scatter], theme: Theme) -> dict[str, Any]:
    x: dict[str, Any] = axis(theme, of.x_title)
    y: dict[str, Any] = axis(theme, of.y_title) | {"range": [0, 1.02]}
    if of.x == "recall":
        x |= {"range": [0, 1.02]}
    elif of.x == "fppi":
        x |= _log_axis(FPPI_TICKS, FPPI_TICKS[0], FPPI_TICKS[-1])
    elif of.x_log:
        x |= {"type": "log", "exponentformat": "e", "dtick": 1}
    if of.y_log:
        least = min((line.y.min() for line in lines if len(line.y)), default=RATE_TICKS[0])
        below = [tick for tick in RATE_TICKS if tick <= least] or [RATE_TICKS[0]]
        y |= _log_axis(RATE_TICKS, min(below[-1], MOST_LOW_RATE), 1.05)
    return {"xaxis": x, "yaxis": y}


def _log_axis(ticks: Sequence[float], low: float, high: float) -> dict[str, Any]:
    return {
        "type": "log", "range": [math.log10(low), math.log10(high)], "tickvals": list(ticks),
        "ticktext": [f"{tick:g}" for tick in ticks],
    }  # fmt: skip
