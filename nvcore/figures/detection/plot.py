"""Detection curves of X and Y with the operating points in use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.detection.curves import DetectionCurve
from nvcore.figures.detection.kinds import KINDS, ON_AXES, CurveChart, CurveKind
from nvcore.figures.detection.points import CurvePoints
from nvcore.figures.marks import HOVER, click_markers, marks, system_marker
from nvcore.figures.rate_axis import LogScale, decades, log_scale
from nvcore.figures.style import LOOK, axis, begins_at, draw, empty_figure, plain, system_label
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.published import PublishedPoint
from nvcore.wording import count_text

FPPI_RANGE: Final = (0.001, 1.0)
"""The axis of false positives per image reaches so far at least."""
RATE_TICKS: Final = (
    *(0.001, 0.002, 0.005, 0.01, 0.02, 0.05),
    *(0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0),
)
MOST_LOW_RATE: Final = 0.5
"""The axis of miss rates reaches down to this at least, so that a flat curve looks flat."""
UNIT_RANGE: Final = (-0.02, 1.02)
"""Of axes from 0 to 1: marks at the ends are whole, and labels do not touch."""
TO_CLICK: Final = "click a curve to set its threshold"
MARKER_PX: Final = 13
PUBLISHED_PX: Final = 12
PUBLISHED_SYMBOLS: Final = ("star", "triangle-up", "square", "cross", "x", "pentagon")
ZERO_PX: Final = 11


def curve_plot(
    curves: Sequence[DetectionCurve],
    thresholds: Sequence[float | None],
    kind: CurveKind,
    *,
    theme: Theme,
    objects: Objects,
    summaries: Sequence[str] = ("", ""),
    windows_per_image: float | None = None,
    hint: str = TO_CLICK,
    published: Sequence[PublishedPoint] = (),
) -> go.Figure:
    """Curves of X and Y; a large mark at the threshold in use.

    What a logarithmic axis cannot show, such as 0, stands at its edge, where the tick says so; a
    hollow mark stands where a miss rate gets there. A click gives the threshold: `customdata` is
    the pair of the system's letter and the score.

    Parameters
    ----------
    curves
        Of X and Y (`nvcore.detection.curves.detection_curve`).
    thresholds
        Thresholds in use of X and Y; None: every detection counts.
    summaries
        What the legend says behind the names (`legend_text`).
    windows_per_image
        For false positives per window (`nvcore.detection.windows`).
    hint
        Last part of the subtitle.
    published
        Points of others; those of which the kind of curve needs more than is known are not drawn.
    """
    of = KINDS[kind]
    why_empty = _why_empty(curves, kind, windows_per_image)
    if why_empty:
        return empty_figure(why_empty, theme=theme, height=300)
    points = [CurvePoints.along(curve, of, windows_per_image) for curve in curves]
    used = [
        CurvePoints.at(curve, threshold, of, windows_per_image)
        for curve, threshold in zip(curves, thresholds, strict=False)
    ]
    others = {point.name: CurvePoints.published(point, of) for point in published}
    x_scale, y_scale = _scales(of, [*points, *used, *others.values()])
    traces: list[list[go.Scatter]] = [[], [], [], []]
    for i, letter in enumerate("xy"[: len(curves)]):
        line = points[i].placed(x_scale, y_scale).thinned(is_log=of.x_log)
        label, why = system_label(letter, curves[i].system), _why_no_line(curves[i], kind)
        name = ", ".join(filter(None, (label, why, summaries[i])))
        traces[0].append(_line(line, letter, name, theme, is_line=curves[i].is_ranked))
        if y_scale is not None:
            traces[1] += _first_zero(line, letter, y_scale, theme)
        traces[2] += _in_use(used[i].placed(x_scale, y_scale), letter, theme, of)
        clicks, texts = line.clicked(letter), line.texts(letter, of)
        label = f"{letter.upper()}, points"
        traces[3].append(click_markers(line.x, line.y, texts, customdata=clicks, name=label))
    traces.append(_published(others, x_scale, y_scale, of, theme))
    return draw(
        list(chain.from_iterable(traces)),
        theme,
        title=of.title,
        subtitle=_extent(curves, used, hint, objects),
        height=420,
        **_axes(of, x_scale, y_scale, theme),
    )


def _line(
    points: CurvePoints, letter: str, name: str, theme: Theme, *, is_line: bool
) -> go.Scatter:
    color = LOOK[theme].of(letter)
    # a line of a single point cannot be seen, and nothing at all would not be in the legend
    is_line = is_line and len(points.x) > 1
    return go.Scatter(
        x=points.x if len(points.x) else [None],
        y=points.y if len(points.x) else [None],
        mode="lines" if is_line else "markers",
        hoverinfo="skip",
        name=name,
        showlegend=True,
        line={"color": color, "width": 2.4, "dash": LOOK[theme].dash(letter)},
        marker={"color": color, "symbol": LOOK[theme].symbol(letter), "size": 9},
        cliponaxis=False,
    )


def _first_zero(
    points: CurvePoints, letter: str, scale: LogScale, theme: Theme
) -> list[go.Scatter]:
    """A hollow mark where a curve gets to the lower edge."""
    on_edge = np.flatnonzero(points.y == scale.edge)[:1]
    marker = {
        "color": LOOK[theme].of(letter),
        "size": ZERO_PX,
        "symbol": f"{LOOK[theme].symbol(letter)}-open",
        "line": {"width": 2},
    }
    still = {"hoverinfo": "skip", "showlegend": False, "cliponaxis": False, "marker": marker}
    name = f"{letter.upper()} at the edge"
    return [
        go.Scatter(
            x=points.x[on_edge],
            y=points.y[on_edge],
            mode="markers",
            name=name,
            **still,
        )
        for _ in on_edge
    ]


def _in_use(points: CurvePoints, letter: str, theme: Theme, of: CurveChart) -> list[go.Scatter]:
    """A large mark at the threshold in use; none where a measure is undefined."""
    marker = system_marker(letter, MARKER_PX, theme, rim=2)
    return [
        marks(
            points.x,
            points.y,
            points.texts(letter, of),
            hover="in use: " + HOVER,
            customdata=points.clicked(letter),
            name=f"{letter.upper()} as set",
            showlegend=False,
            cliponaxis=False,
            marker=marker,
        )
        for _ in points.x
    ]


def _published(
    others: Mapping[str, CurvePoints],
    x_scale: LogScale | None,
    y_scale: LogScale | None,
    of: CurveChart,
    theme: Theme,
) -> list[go.Scatter]:
    """A star for each published point that this kind of curve can show, in the legend by name."""
    line = {"color": LOOK[theme].surface, "width": 1}
    symbols = PUBLISHED_SYMBOLS
    traces = []
    for i, (name, point) in enumerate(others.items()):
        if not len(point.x):
            continue
        marker = {
            "color": LOOK[theme].ink,
            "size": PUBLISHED_PX,
            "symbol": symbols[i % len(symbols)],
            "line": line,
        }
        at = point.placed(x_scale, y_scale)
        text = f"{plain(name)}, as published<br>{ON_AXES[of.x]} {float(point.x[0]):.3g}, "
        text += f"{ON_AXES[of.y]} {float(point.y[0]):.3g}"
        label = f"{plain(name)} (published)"
        traces.append(marks(at.x, at.y, [text], name=label, showlegend=True, marker=marker))
    return traces


def _extent(
    curves: Sequence[DetectionCurve], used: Sequence[CurvePoints], hint: str, objects: Objects
) -> str:
    counted = (
        f"{count_text(curves[0].n_truth, objects.singular, objects.plural)} in "
        f"{count_text(curves[0].n_images, 'image')}"
    )
    letters = [letter for letter, points in zip("XY", used, strict=False) if len(points.x)]
    parts = [counted]
    if letters:
        which = "thresholds" if len(letters) > 1 else f"threshold of {letters[0]}"
        parts.append(f"large mark{'s' * (len(letters) > 1)}: {which} in use")
    if hint != TO_CLICK or any(np.isfinite(curve.threshold).any() for curve in curves):
        parts.append(hint)
    return "; ".join(parts)


def _why_no_line(curve: DetectionCurve, kind: CurveKind) -> str:
    """For the legend, where a system has no curve."""
    if not len(curve):
        return "no detections"
    if curve.is_ranked:
        return ""
    if len(curve) > 1:
        return "points: some scores are missing"
    return f"no scores: F1 {curve.f1[0]:.3f}" if kind == "f1" else "no scores: a point"


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


def _scales(
    of: CurveChart, points: Sequence[CurvePoints]
) -> tuple[LogScale | None, LogScale | None]:
    """Of both axes; None: linear."""
    x, y = (np.concatenate([getattr(part, name) for part in points]) for name in "xy")
    x_scale = y_scale = None
    if of.x_log:
        least, most = FPPI_RANGE
        if of.x == "fppi":
            most = max(most, x.max(initial=most))
        else:
            least = x.min(initial=np.inf, where=x > 0)
            most = x.max(initial=0.0)
            least, most = (least, most) if most > 0 else (1e-6, 1e-3)
        ticks = decades(least, most)
        x_scale = log_scale(x, ticks, ticks[-1])
    if of.y_log:
        least = min(y.min(initial=1.0, where=y > 0), MOST_LOW_RATE)
        lowest = max((tick for tick in RATE_TICKS if tick <= least), default=RATE_TICKS[0])
        y_scale = log_scale(y, [tick for tick in RATE_TICKS if tick >= lowest], 1.05)
    return x_scale, y_scale


def _axes(
    of: CurveChart, x_scale: LogScale | None, y_scale: LogScale | None, theme: Theme
) -> dict[str, Any]:
    x: dict[str, Any] = axis(theme, of.x_title)
    y: dict[str, Any] = axis(theme, of.y_title)
    if x_scale is not None:
        x |= x_scale.axis()
        if x_scale.edge_label:  # a line lower: in a narrow window it meets the lowest tick's
            x |= {"ticktext": [f"<br>{x_scale.edge_label}", *x["ticktext"][1:]], "tickangle": 0}
    elif of.x == "recall":
        x |= {"range": UNIT_RANGE}
    if y_scale is not None and not y_scale.edge_label:
        y["title"]["text"] += begins_at(y_scale.low)
    y |= {"range": UNIT_RANGE} if y_scale is None else y_scale.axis()
    return {"xaxis": x, "yaxis": y}
