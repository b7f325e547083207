"""Figures of detection curves, with logarithmic axes and marked values for other curves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text, number
from nvcore.figures.marks import HOVER, click_markers, marks, rule, still_line
from nvcore.figures.style import LOOK, ChartLook, begins_at, plain, system_label, write
from nvcore.metrics.detection.curve_summary import CurveSummary
from nvcore.metrics.detection.curves import CurvePoint, DetectionCurve
from nvcore.metrics.detection.miss_rate import FPPI_REFERENCES
from nvcore.settings.objects import Objects
from nvcore.settings.published import PublishedPoint

CurveKind = Literal["miss_rate", "precision_recall", "roc", "roc_windows", "f1"]


PER_IMAGE, PER_WINDOW = "false positives per image", "false positives per window"
MEASURES: Final = {
    "threshold": ("score threshold", ""),
    "recall": ("recall (1 is best)", "recall {:.3f}"),
    "miss_rate": ("miss rate (0 is best)", "miss rate {:.3f}"),
    "precision": ("precision (1 is best)", "precision {:.3f}"),
    "f1": ("F1 (1 is best)", "F1 {:.3f}"),
    "fppi": (PER_IMAGE, f"{{:.3g}} {PER_IMAGE}"),
    "fppw": (PER_WINDOW, f"{{:.3g}} {PER_WINDOW}"),
}
"""Title of the axis and hover text of each measure of a point."""
OF_ROC: Final = {"recall": ("detection rate (1 is best)", "detection rate {:.3f}")}
"""The same in curves of the detection rate, as recall is called there."""


@dataclass(frozen=True)
class CurveChart:
    """Title of a kind of curve, measures of its axes, and measures in each line of hover texts."""

    title: str
    x: str
    y: str
    hover: tuple[str, ...]

    @property
    def measures(self) -> dict[str, tuple[str, str]]:
        """Title and hover text of each measure."""
        return MEASURES | (OF_ROC if self.y == "recall" else {})


ROC: Final = "Detection rate against false positives"
KINDS: Final[dict[CurveKind, CurveChart]] = {
    "miss_rate": CurveChart(
        "Miss rate against false positives", "fppi", "miss_rate", ("miss_rate fppi", "precision")
    ),
    "precision_recall": CurveChart(
        "Precision against recall", "recall", "precision", ("recall precision", "fppi")
    ),
    "roc": CurveChart(ROC, "fppi", "recall", ("recall fppi", "precision")),
    "roc_windows": CurveChart(
        f"{ROC} per window", "fppw", "recall", ("recall fppw", "fppi precision")
    ),
    "f1": CurveChart(
        "F1 against the threshold", "threshold", "f1", ("f1", "recall precision", "fppi")
    ),
}
MAX_POINTS: Final = 600
"""Maximum number of points of a curve that are drawn and clickable, evenly over the axis."""
FPPI_RANGE: Final = (0.001, 1.0)
"""Least range of the axis of false positives per image."""
RATE_TICKS: Final = (
    *(0.001, 0.002, 0.005, 0.01, 0.02, 0.05),
    *(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0),
)
MOST_LOW_RATE: Final = 0.5
"""Highest lower end of the axis of miss rates, so that a flat curve looks flat."""
UNIT_RANGE: Final = (-0.02, 1.02)
"""Range of axes from 0 to 1, with room for whole marks and labels at the ends."""
TO_CLICK: Final = "click a curve to set its threshold"
IN_USE_PX: Final = 13
PUBLISHED_PX: Final = 12
PUBLISHED_SYMBOLS: Final = ("star", "triangle-up", "square", "cross", "x", "pentagon")
EDGE_SHARE: Final = 0.09
"""Share of a logarithmic axis between its lowest tick and the edge."""
MARGIN_SHARE: Final = 0.02
"""Share of a logarithmic axis that is left free at its low end for whole marks and labels."""


@dataclass(frozen=True)
class LogScale:
    """A logarithmic axis of rates: its lowest tick, the place of values below it, and settings.

    If values stand at the edge, it is labelled "0", or "< 0.001" if some are not 0.
    """

    low: float
    edge: float
    axis: dict[str, Any]
    has_edge: bool

    def place(self, values: pd.Series) -> pd.Series:
        """Return the positions at which values are drawn."""
        return values.mask(values < self.low * (1 - 1e-9), self.edge)


def log_scale(values: np.ndarray, ticks: Sequence[float], high: float) -> LogScale:
    """Return the axis with these ticks and upper end for values of 0 or more.

    Examples
    --------
    >>> log_scale(np.array([0.0, 0.5]), (0.01, 0.1, 1.0), 1.0).axis["ticktext"]
    ['0', '0.01', '0.1', '1']
    >>> log_scale(np.array([0.0, 0.001]), (0.1, 1.0), 1.0).axis["ticktext"]
    ['< 0.1', '0.1', '1']
    """
    low = ticks[0]
    labels = [f"{t:g}" if t > 0.00099 else f"{t:.0e}".replace("e-0", "e-") for t in ticks]
    edge = float(low * (low / high) ** EDGE_SHARE)
    below = values[values < low * (1 - 1e-9)]
    if len(below):
        ticks, labels = [edge, *ticks], [f"< {labels[0]}" if below.any() else "0", *labels]
    ends = [math.log10(ticks[0] * (low / high) ** MARGIN_SHARE), math.log10(high)]
    axis = {"type": "log", "range": ends, "tickvals": [*ticks], "ticktext": labels}
    return LogScale(low, edge, axis, len(below) > 0)


def _decades(low: float, high: float) -> tuple[float, ...]:
    """Return powers of ten that hold both ends, both positive, in between."""
    first, last = math.floor(math.log10(low) + 1e-9), math.ceil(math.log10(high) - 1e-9)
    # 10.0**-4 is not 1e-4, and a tick beyond the end has no label
    return tuple(float(f"1e{power}") for power in range(first, max(last, first + 1) + 1))


def mark_value(
    figure: go.Figure,
    x: float,
    text: str,
    look: ChartLook,
    *,
    name: str,
    left_from: float,
    y: float = 1,
    colour: str = "ink",
    **looks: Any,
) -> None:
    """Draw a line over the whole height at `x`, with a text beside it at the height `y`, 0 to 1.

    Above `left_from` the text stands left of the line.
    """
    shade = getattr(look, colour)
    rule(figure, "x", x, color=shade, name=name, **looks)
    anchor, shift = ("right", -4) if x > left_from else ("left", 4)
    place = {"x": x, "xanchor": anchor, "xshift": shift}
    place |= {"y": y, "yref": "paper", "yanchor": "top" if y > 0.5 else "bottom"}
    write(figure, text, size=11, color=shade, **place)


def legend_text(summary: CurveSummary, kind: CurveKind) -> str:
    """Return the measure that belongs to a kind of curve for its legend, with why it is 0."""
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


def curve_plot(
    curves: Sequence[DetectionCurve],
    thresholds: Sequence[float | None],
    kind: CurveKind,
    *,
    theme: Theme,
    objects: Objects,
    summaries: Sequence[CurveSummary | None] = (None, None),
    windows_per_image: float | None = None,
    hint: str = TO_CLICK,
    published: Sequence[PublishedPoint] = (),
) -> go.Figure:
    """Draw detection curves of X and Y with a large mark at the threshold in use.

    Values that a logarithmic axis cannot show, such as 0, stand at its edge, which has a tick of
    its own. A hollow mark stands where a miss rate gets there. A click gives the threshold:
    `customdata` is the pair of the system's letter and the score.

    Parameters
    ----------
    curves
        Of X and Y (`nvcore.metrics.detection.curves.detection_curve`).
    thresholds
        Thresholds in use of X and Y; None: every detection counts.
    summaries
        Of the curves, whose measure then stands in the legend.
    windows_per_image
        For false positives per window (`nvcore.metrics.detection.windows`).
    hint
        Last part of the subtitle; empty: there is none.
    published
        Published points of others. A point without the measures of this kind of curve is left out.
    """
    look, of = LOOK[theme], KINDS[kind]
    if why_empty := _why_empty(curves, kind, windows_per_image):
        return look.empty(why_empty, height=300)
    lines = [_points(_values(curve, windows_per_image), of) for curve in curves]
    used = [
        _points(_values(curve.at(threshold), windows_per_image), of)
        for curve, threshold in zip(curves, thresholds, strict=False)
    ]
    others = {point.name: _points(point.values(), of) for point in published}
    tables = [*lines, *used, *others.values()]
    scales = _scales(of, *(np.concatenate([table[name] for table in tables]) for name in "xy"))
    for table, (name, scale) in product(tables, scales.items()):
        table[name] = scale.place(table[name])
    lines = [_thinned(points, is_log="x" in scales) for points in lines]
    layers = [
        _of_system(letter, kind, curve, summary, points, point, scales, look)
        for letter, curve, summary, points, point in zip(
            "xy", curves, summaries, lines, used, strict=False
        )
    ]
    traces = [trace for layer in zip(*layers, strict=True) for trace in layer if trace is not None]
    for i, (name, point) in enumerate(others.items()):
        if len(point):
            symbol = PUBLISHED_SYMBOLS[i % len(PUBLISHED_SYMBOLS)]
            traces.append(_published(plain(name), point, of, symbol, look))
    extent = f"{count_text(curves[0].n_truth, objects.singular, objects.plural)} in "
    extent += count_text(curves[0].n_images, "image")
    letters = [letter for letter, point in zip("XY", used, strict=False) if len(point)]
    if letters:
        which = "s: thresholds" if len(letters) > 1 else f": threshold of {letters[0]}"
        extent += f"; large mark{which} in use"
    if hint != TO_CLICK or any(np.isfinite(curve.threshold).any() for curve in curves):
        extent += f"; {hint}" if hint else ""
    axes = _axes(of, scales, look)
    return look.draw(traces, title=of.title, subtitle=extent, height=420, **axes)


def _why_empty(curves: Sequence[DetectionCurve], kind: CurveKind, windows: float | None) -> str:
    if not curves or not curves[0].n_truth:
        return "No box of the truth counts under this protocol."
    if kind == "roc_windows" and windows is None:
        return "Without a number of windows per image there are no false positives per window."
    if not any(len(curve) for curve in curves):
        return "There are no detections to draw."
    if kind == "f1" and not any(np.isfinite(curve.threshold).any() for curve in curves):
        return "There are no scores, so there is no threshold to change F1."
    return ""


def _values(of: DetectionCurve | CurvePoint, windows: float | None) -> dict[str, Any]:
    """Return the measures of all points of a curve, or of one."""
    known = {name: getattr(of, name) for name in MEASURES if name != "fppw"}
    return {**known, "fppw": of.fppi / (windows or np.nan)}


def _points(values: Mapping[str, Any], of: CurveChart) -> pd.DataFrame:
    """Return the points that can be drawn, with their place in the columns x and y."""
    columns = {name: np.atleast_1d(value) for name, value in values.items()}
    points = pd.DataFrame(columns, dtype=float).reindex(columns=[*MEASURES])
    points[["x", "y"]] = points[[of.x, of.y]].to_numpy()
    drawn: pd.DataFrame = points[np.isfinite(points[["x", "y"]].to_numpy()).all(axis=1)]
    return drawn


def _thinned(points: pd.DataFrame, *, is_log: bool) -> pd.DataFrame:
    """Return at most `MAX_POINTS` points and the first."""
    if len(points) <= MAX_POINTS:
        return points
    along = np.log(points["x"].to_numpy()) if is_log else points["x"].to_numpy()
    column = np.floor((along - along.min()) / (np.ptp(along) or 1.0) * (MAX_POINTS - 2))
    is_last = np.append(np.diff(column) != 0, True)
    is_last[0] = True
    return points[is_last]


def _scales(of: CurveChart, x: np.ndarray, y: np.ndarray) -> dict[str, LogScale]:
    """Return the scales of logarithmic axes for the values of all points."""
    scales = {}
    if of.x in {"fppi", "fppw"}:
        least, most = FPPI_RANGE
        if of.x == "fppi":
            most = max(most, x.max(initial=most))
        elif (x > 0).any():
            least, most = x.min(initial=np.inf, where=x > 0), x.max()
        else:
            least, most = 1e-6, 1e-3
        ticks = _decades(least, most)
        scales["x"] = log_scale(x, ticks, ticks[-1])
    if of.y == "miss_rate":
        least = min(y.min(initial=1.0, where=y > 0), MOST_LOW_RATE)
        lowest = max((tick for tick in RATE_TICKS if tick <= least), default=RATE_TICKS[0])
        scales["y"] = log_scale(y, [tick for tick in RATE_TICKS if tick >= lowest], 1.05)
    return scales


def _axes(of: CurveChart, scales: Mapping[str, LogScale], look: ChartLook) -> dict[str, Any]:
    x, y = (look.axis(of.measures[name][0], can_zoom=True) for name in (of.x, of.y))
    y["range"] = UNIT_RANGE
    if "x" in scales:
        x |= scales["x"].axis
        if scales["x"].has_edge:  # a line lower: in a narrow window it meets the lowest tick's
            x |= {"ticktext": [f"<br>{x['ticktext'][0]}", *x["ticktext"][1:]], "tickangle": 0}
    elif of.x == "recall":
        x["range"] = UNIT_RANGE
    if "y" in scales:
        y |= scales["y"].axis
        if not scales["y"].has_edge:
            y["title"]["text"] += begins_at(scales["y"].low)
    return {"xaxis": x, "yaxis": y}


def _legend(
    letter: str, curve: DetectionCurve, kind: CurveKind, summary: CurveSummary | None
) -> str:
    """Return a system's text in the legend. It says why there is no curve."""
    why = ""
    if not len(curve):
        why = "no detections"
    elif not curve.is_ranked:
        why = f"no scores: F1 {curve.f1[0]:.3f}" if kind == "f1" else "no scores: a point"
        why = "points: some scores are missing" if len(curve) > 1 else why
    measure = legend_text(summary, kind) if summary else ""
    return ", ".join(filter(None, (system_label(letter, curve.system), why, measure)))


def _of_system(
    letter: str,
    kind: CurveKind,
    curve: DetectionCurve,
    summary: CurveSummary | None,
    points: pd.DataFrame,
    in_use: pd.DataFrame,
    scales: Mapping[str, LogScale],
    look: ChartLook,
) -> tuple[go.Scatter | None, ...]:
    """Return a system's curve, its first point at the lower edge, the point in use, and clicks."""
    of, name = KINDS[kind], _legend(letter, curve, kind, summary)
    # a line of a single point cannot be seen, and nothing at all would not be in the legend
    line = still_line(
        points["x"] if len(points) else [None],
        points["y"] if len(points) else [None],
        name,
        mode="lines" if curve.is_ranked and len(points) > 1 else "markers",
        showlegend=True,
        line=look.line(letter),
        marker={"color": look.of(letter), "symbol": look.symbol(letter), "size": 9},
        cliponaxis=False,
    )
    at_edge = in_sight = None
    first = points[points["y"] == scales["y"].edge].head(1) if "y" in scales else points.head(0)
    if len(first):
        symbol, name = f"{look.symbol(letter)}-open", f"{letter.upper()} at the edge"
        marker = {"color": look.of(letter), "symbol": symbol, "size": 11, "line": {"width": 2}}
        looks = {"mode": "markers", "cliponaxis": False, "marker": marker}
        at_edge = still_line(first["x"], first["y"], name, **looks)
    if len(in_use):  # not where a measure is undefined
        in_sight = marks(
            **_told(in_use, letter, of),
            hover="in use: " + HOVER,
            name=f"{letter.upper()} as set",
            showlegend=False,
            cliponaxis=False,
            marker=look.marker(letter, IN_USE_PX, rim=2),
        )
    clicks = click_markers(**_told(points, letter, of), name=f"{letter.upper()}, points")
    return line, at_edge, in_sight, clicks


def _told(points: pd.DataFrame, letter: str, of: CurveChart) -> dict[str, Any]:
    """Return places, texts and clicks of marks. A click sets a score, or None if there is none."""
    texts, clicked = [], []
    for row in points.to_dict("records"):
        score = row["threshold"] if np.isfinite(row["threshold"]) else None
        where = "without scores" if score is None else f"score ≥ {score:.4g}"
        lines = (
            ", ".join(of.measures[name][1].format(row[name]) for name in names.split())
            for names in of.hover
        )
        texts.append("<br>".join((f"{letter.upper()}, {where}", *lines)))
        clicked.append([letter, score])
    return {"x": points["x"], "y": points["y"], "texts": texts, "customdata": clicked}


def _published(
    name: str, point: pd.DataFrame, of: CurveChart, symbol: str, look: ChartLook
) -> go.Scatter:
    """Return a mark for a published point, in the legend by name."""
    x, y = point[of.x].iloc[0], point[of.y].iloc[0]
    x_word, y_word = (MEASURES[measure][0].partition(" (")[0] for measure in (of.x, of.y))
    text = f"{name}, as published<br>{x_word} {x:.3g}, {y_word} {y:.3g}"
    rim, label = {"color": look.surface, "width": 1}, f"{name} (published)"
    marker = {"color": look.ink, "size": PUBLISHED_PX, "symbol": symbol, "line": rim}
    return marks(point["x"], point["y"], [text], name=label, showlegend=True, marker=marker)
