"""Detection curves of X and Y with the operating points in use."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, Final, Literal

import numpy as np
import plotly.graph_objects as go

from nvcore.detection.curve_summary import CurveSummary
from nvcore.detection.curves import DetectionCurve
from nvcore.detection.miss_rate import FPPI_REFERENCES
from nvcore.figures.marks import HOVER, click_markers, marks, steady_marker, system_marker
from nvcore.figures.rate_axis import LogScale, decades, log_scale
from nvcore.figures.style import LOOK, axis, draw, empty_figure, plain, system_label
from nvcore.palette import Theme
from nvcore.published import PublishedPoint
from nvcore.wording import count_text

CurveKind = Literal["miss_rate", "precision_recall", "roc", "roc_windows", "f1"]

MAX_POINTS: Final = 600
"""Points of a curve that are drawn and can be clicked, evenly over the axis."""
FPPI_RANGE: Final = (0.001, 10.0)
"""The axis of false positives per image reaches so far at least."""
RATE_TICKS: Final = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0)
MOST_LOW_RATE: Final = 0.1
"""The axis of miss rates reaches down to this at least, so that a flat curve looks flat."""
UNIT_RANGE: Final = (-0.02, 1.02)
"""Of axes from 0 to 1: marks at the ends are whole, and labels do not touch."""
TO_CLICK: Final = "click a curve to set its threshold"
POINT: Final = ("threshold", "recall", "miss_rate", "precision", "f1", "fppi")
"""What is known of every point of a curve."""
MARKER_PX: Final = 13
PUBLISHED_PX: Final = 12
PUBLISHED_SYMBOLS: Final = ("star", "triangle-up", "square", "cross", "x", "pentagon")
ZERO_PX: Final = 11


@dataclass(frozen=True)
class _Kind:
    title: str
    x: str
    y: str
    x_title: str
    y_title: str
    hover: str
    x_log: bool = False
    y_log: bool = False


KINDS: Final[dict[CurveKind, _Kind]] = {
    "miss_rate": _Kind(
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
    "precision_recall": _Kind(
        "Precision against recall",
        "recall",
        "precision",
        "recall (1 is best)",
        "precision (1 is best)",
        "recall {recall:.3f}, precision {precision:.3f}<br>{fppi:.3g} false positives per image",
    ),
    "roc": _Kind(
        "Detection rate against false positives",
        "fppi",
        "recall",
        "false positives per image",
        "detection rate (1 is best)",
        "detection rate {recall:.3f}, {fppi:.3g} false positives per image<br>"
        "precision {precision:.3f}",
        x_log=True,
    ),
    "roc_windows": _Kind(
        "Detection rate against false positives per window",
        "fppw",
        "recall",
        "false positives per window",
        "detection rate (1 is best)",
        "detection rate {recall:.3f}, {fppw:.3g} false positives per window<br>"
        "{fppi:.3g} false positives per image, precision {precision:.3f}",
        x_log=True,
    ),
    "f1": _Kind(
        "F1 against the threshold",
        "threshold",
        "f1",
        "score threshold",
        "F1 (1 is best)",
        "F1 {f1:.3f}<br>recall {recall:.3f}, precision {precision:.3f}<br>"
        "{fppi:.3g} false positives per image",
    ),
}


_ON_AXES: Final = {
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
        return f"LAMR {summary.log_average_miss_rate:.1%}"
    why = "nobody missed" if n_zero == n else f"0 at {n_zero} of {n} references"
    return f"LAMR 0% ({why})"


def curve_plot(
    curves: Sequence[DetectionCurve],
    thresholds: Sequence[float | None],
    kind: CurveKind,
    *,
    theme: Theme,
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
    points = [_Points.along(curve, of, windows_per_image) for curve in curves]
    used = [
        _Points.at(curve, threshold, of, windows_per_image)
        for curve, threshold in zip(curves, thresholds, strict=False)
    ]
    others = {point.name: _Points.published(point, of) for point in published}
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
        subtitle=_extent(curves, used, hint),
        height=420,
        **_axes(of, x_scale, y_scale, theme),
    )


@dataclass(frozen=True, eq=False)
class _Points:
    """Points of one system that can be drawn: where they are, and their values."""

    x: np.ndarray
    y: np.ndarray
    values: Mapping[str, np.ndarray]

    @classmethod
    def along(cls, curve: DetectionCurve, of: _Kind, windows: float | None) -> _Points:
        values = {name: getattr(curve, name) for name in POINT}
        return cls._drawable(values, of, windows)

    @classmethod
    def at(
        cls, curve: DetectionCurve, threshold: float | None, of: _Kind, windows: float | None
    ) -> _Points:
        point = curve.at(threshold)
        values = {name: np.array([getattr(point, name)]) for name in POINT}
        return cls._drawable(values, of, windows)

    @classmethod
    def published(cls, point: PublishedPoint, of: _Kind) -> _Points:
        values = {name: np.array([value]) for name, value in point.values().items()}
        nothing = np.array([np.nan])
        points = cls(values.get(of.x, nothing), values.get(of.y, nothing), values)
        return points.rows(np.flatnonzero(np.isfinite(points.x) & np.isfinite(points.y)))

    @classmethod
    def _drawable(cls, values: dict[str, np.ndarray], of: _Kind, windows: float | None) -> _Points:
        values["fppw"] = values["fppi"] / (np.nan if windows is None else windows)
        points = cls(values[of.x], values[of.y], values)
        return points.rows(np.flatnonzero(np.isfinite(points.x) & np.isfinite(points.y)))

    def rows(self, rows: np.ndarray) -> _Points:
        values = {name: column[rows] for name, column in self.values.items()}
        return _Points(self.x[rows], self.y[rows], values)

    def placed(self, x_scale: LogScale | None, y_scale: LogScale | None) -> _Points:
        return replace(
            self,
            x=self.x if x_scale is None else x_scale.place(self.x),
            y=self.y if y_scale is None else y_scale.place(self.y),
        )

    def thinned(self, *, is_log: bool) -> _Points:
        """At most `MAX_POINTS` and the first."""
        if len(self.x) <= MAX_POINTS:
            return self
        along = np.log(self.x) if is_log else self.x
        span = np.ptp(along) or 1.0
        column = np.floor((along - along.min()) / span * (MAX_POINTS - 2)).astype(np.int64)
        is_last = np.concatenate([column[1:] != column[:-1], [True]])
        is_last[0] = True
        return self.rows(np.flatnonzero(is_last))

    def texts(self, letter: str, of: _Kind) -> list[str]:
        texts = []
        for i, threshold in enumerate(self.values["threshold"]):
            score = f"score ≥ {threshold:.4g}" if np.isfinite(threshold) else "without scores"
            values = {name: float(column[i]) for name, column in self.values.items()}
            texts.append(f"{letter.upper()}, {score}<br>{of.hover.format(**values)}")
        return texts

    def clicked(self, letter: str) -> list[list[str | float | None]]:
        """The system and its score, None where there is none to set."""
        scores = self.values["threshold"]
        return [[letter, float(score) if np.isfinite(score) else None] for score in scores]


def _line(points: _Points, letter: str, name: str, theme: Theme, *, is_line: bool) -> go.Scatter:
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


def _first_zero(points: _Points, letter: str, scale: LogScale, theme: Theme) -> list[go.Scatter]:
    """A hollow mark where a curve gets to the lower edge."""
    on_edge = np.flatnonzero(points.y == scale.edge)[:1]
    marker = steady_marker(
        color=LOOK[theme].of(letter),
        size=ZERO_PX,
        symbol=f"{LOOK[theme].symbol(letter)}-open",
        line={"width": 2},
    )
    still = {"hoverinfo": "skip", "showlegend": False, "cliponaxis": False}
    name = f"{letter.upper()} at the edge"
    return [
        go.Scatter(
            x=points.x[on_edge], y=points.y[on_edge], mode="markers", name=name, **still, **marker
        )
        for _ in on_edge
    ]


def _in_use(points: _Points, letter: str, theme: Theme, of: _Kind) -> list[go.Scatter]:
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
            **marker,
        )
        for _ in points.x
    ]


def _published(
    others: Mapping[str, _Points],
    x_scale: LogScale | None,
    y_scale: LogScale | None,
    of: _Kind,
    theme: Theme,
) -> list[go.Scatter]:
    """A star for each published point that this kind of curve can show, in the legend by name."""
    line = {"color": LOOK[theme].surface, "width": 1}
    symbols = PUBLISHED_SYMBOLS
    traces = []
    for i, (name, point) in enumerate(others.items()):
        if not len(point.x):
            continue
        marker = steady_marker(
            color=LOOK[theme].ink, size=PUBLISHED_PX, symbol=symbols[i % len(symbols)], line=line
        )
        at = point.placed(x_scale, y_scale)
        text = f"{plain(name)}, as published<br>{_ON_AXES[of.x]} {float(point.x[0]):.3g}, "
        text += f"{_ON_AXES[of.y]} {float(point.y[0]):.3g}"
        label = f"{plain(name)} (published)"
        traces.append(marks(at.x, at.y, [text], name=label, showlegend=True, **marker))
    return traces


def _extent(curves: Sequence[DetectionCurve], used: Sequence[_Points], hint: str) -> str:
    counted = (
        f"{count_text(curves[0].n_truth, 'pedestrian')} in "
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
        return "No pedestrian counts under this protocol."
    if kind == "roc_windows" and windows is None:
        return "Without a number of windows per image there are no false positives per window."
    if not any(len(curve) for curve in curves):
        return "There are no detections to draw."
    if kind == "f1" and not any(np.isfinite(curve.threshold).any() for curve in curves):
        return "There are no scores, so there is no threshold to change F1."
    return ""


def _scales(of: _Kind, points: Sequence[_Points]) -> tuple[LogScale | None, LogScale | None]:
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
    of: _Kind, x_scale: LogScale | None, y_scale: LogScale | None, theme: Theme
) -> dict[str, Any]:
    x: dict[str, Any] = axis(theme, of.x_title)
    y: dict[str, Any] = axis(theme, of.y_title)
    if x_scale is not None:
        x |= x_scale.axis()
    elif of.x == "recall":
        x |= {"range": UNIT_RANGE}
    y |= {"range": UNIT_RANGE} if y_scale is None else y_scale.axis()
    return {"xaxis": x, "yaxis": y}
