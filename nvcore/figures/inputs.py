"""Figures of the inputs: scores and false alarms by threshold, and the proximity weight."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text
from nvcore.dataset import Dataset
from nvcore.figures.marks import marks, rule
from nvcore.figures.style import EDGE_PX, HEADING_PX, LOOK, ChartLook, faded, system_label, write
from nvcore.metrics.proximity import in_use, sigmoid
from nvcore.metrics.proximity.borrowing import weighing_truth
from nvcore.settings.params import Params

SMALL_PX: Final = 180
"""Height of the figure in the sidebar."""
MAX_BOXES: Final = 200_000
"""Maximum number of boxes in the histogram of heights, taken evenly from all."""
LABEL_PX: Final = 30
"""Space above the plot for the label of the threshold."""
N_BINS: Final = 40
N_CURVES: Final = 4
"""Maximum number of sigmoids drawn if recordings differ in size."""


def score_plot(
    histogram: pd.DataFrame, *, letter: str, name: str, threshold: float | None, theme: Theme
) -> go.Figure:
    """Plot the scores of a system, those below the threshold pale.

    Parameters
    ----------
    histogram
        `nvcore.metrics.detection.operating_point.score_histogram`.
    letter
        "x" or "y".
    """
    look = LOOK[theme]
    if histogram.empty:
        return look.empty("The detections of this system have no scores.")
    low, high, n = (histogram[name].to_numpy() for name in ("low", "high", "n"))
    is_kept = (low + high) / 2 >= (-np.inf if threshold is None else threshold)
    bars = [
        go.Bar(
            x=(low + high)[rows] / 2,
            y=n[rows],
            width=(high - low)[rows],
            name=words,
            marker={"color": colour, "line": {"width": 0}},
            customdata=low[rows],
            hovertemplate="%{y:,} detections with a score of %{customdata:.3f} or a little "
            "more<extra></extra>",
        )
        for words, colour, rows in (
            ("left out", look.pale, ~is_kept),
            ("kept", look.of(letter), is_kept),
        )
    ]
    left_out = "" if threshold is None else "; pale: left out by the threshold"
    ends = [low[0], high[-1]] + ([] if threshold is None else [threshold])
    span = [min(ends), max(ends)]
    return _with_threshold(
        bars,
        threshold,
        look,
        title=f"Scores of {system_label(letter, name)}",
        subtitle=count_text(int(n.sum()), "detection") + left_out,
        bargap=0,
        barmode="overlay",
        xaxis=look.axis("score", begins=span[0], can_zoom=True, range=span, showgrid=False),
        yaxis=look.axis("detections", rangemode="tozero"),
    )


def false_alarm_plot(
    curve: pd.DataFrame, *, letter: str, name: str, threshold: float | None, theme: Theme
) -> go.Figure:
    """Plot the false alarms per minute of recording that each threshold leaves: 0 is best.

    Parameters
    ----------
    curve
        `nvcore.metrics.detection.operating_point.false_alarm_curve`.
    letter
        "x" or "y".
    """
    look = LOOK[theme]
    if curve.empty:
        return look.empty("The detections of this system have no scores.")
    line = go.Scatter(
        x=curve["threshold"].to_numpy(),
        y=curve["false_alarms_per_minute"].to_numpy(),
        mode="lines",
        line={"color": look.of(letter), "width": 2.2},
        customdata=curve["n_kept"].to_numpy(),
        name=letter.upper(),
        hovertemplate="threshold %{x:.3f}<br>%{y:.1f} false alarms per minute<br>"
        "%{customdata:,} detections kept<extra></extra>",
    )
    most = count_text(int(curve["n_false_alarms"].max()), "false alarm")
    return _with_threshold(
        line,
        threshold,
        look,
        title=f"False alarms of {system_label(letter, name)}",
        subtitle=f"{most} at the lowest threshold",
        hovermode="x",
        xaxis=look.axis("score threshold", begins=curve["threshold"].min(), can_zoom=True),
        yaxis=look.axis("false alarms per minute", rangemode="tozero"),
    )


def _with_threshold(traces: Any, threshold: float | None, look: ChartLook, **settings: Any) -> Any:
    """Draw a figure over scores, and the threshold of the system in it."""
    # room for the label also without a threshold, so that the plots of X and Y stay level
    margin = {"t": HEADING_PX + LABEL_PX}
    figure = look.draw(traces, height=280, showlegend=False, margin=margin, **settings)
    if threshold is not None:
        rule(figure, "x", threshold, color=look.ink, name="threshold")
        place = {"x": threshold, "y": 1, "yref": "paper", "yanchor": "bottom"}
        write(figure, f"threshold {threshold:g}", size=12, color=look.ink, **place)
    return figure


def proximity_plot(dataset: Dataset, params: Params, *, theme: Theme) -> go.Figure:
    """Plot the proximity weight over how near the pedestrians of the truth seem, small.

    Nearness is height or depth below the horizon in pixels, or distance in metres, as `params` say.
    If the recordings' sizes make several sigmoids, the first `N_CURVES` are drawn.
    """
    look, objects = LOOK[theme], dataset.objects
    if params.proximity == "none":
        return look.empty(f"Every {objects.singular} counts the same.", height=SMALL_PX)
    size, curves, title = _sizes_and_curves(dataset, params)
    if not len(size):
        return look.empty(f"The truth has no {objects.singular} to show.", height=SMALL_PX)
    end = 1.02 * float(max(size.max(), *(zero + 3 * abs(spread) for zero, spread in curves)))
    n, edges = np.histogram(size, bins=N_BINS, range=(min(0.0, float(size.min())), end))
    along = np.linspace(edges[0], end, 121)
    traces: list[Any] = [
        go.Bar(
            x=(edges[:-1] + edges[1:]) / 2,
            y=n / n.max(initial=1),
            width=np.diff(edges),
            marker={"color": faded(look.truth, 0.28), "line": {"width": 0}},
            customdata=n,
            hovertemplate="%{customdata:,} boxes of about %{x:.0f}<extra></extra>",
            name=objects.plural,
            showlegend=False,
        )
    ]
    for i, (zero, spread) in enumerate(curves):
        k, hover = sigmoid((along - zero) / spread), "%{x:.0f}: weight %{y:.2f}<extra></extra>"
        line = {"color": look.ink, "width": 2}
        weight = marks(along, k, None, hover=hover, mode="lines", line=line, name="weight k")
        hover, marker = "counts half at %{x:.1f}<extra></extra>", {"color": look.ink, "size": 8}
        midpoint = marks([zero], [0.5], None, hover=hover, marker=marker, name="midpoint")
        for trace, part in ((weight, "weight"), (midpoint, "midpoint")):
            # the browser moves curve and midpoint with the sliders
            traces.append(trace.update(meta=f"nv-{part}-{i}", showlegend=False))
    return look.draw(
        traces,
        title="Proximity weight",
        height=SMALL_PX + HEADING_PX,
        margin={"r": EDGE_PX},
        bargap=0,
        xaxis=look.axis(title, range=[edges[0], end], showgrid=False),
        yaxis=look.axis("weight", range=[0, 1.05], tickvals=[0, 0.5, 1]),
    )


def _sizes_and_curves(
    dataset: Dataset, params: Params
) -> tuple[np.ndarray, list[tuple[float, float]], str]:
    """Return the pedestrians' nearness, (zero, spread) of each sigmoid, and the axis' title."""
    truth, frames = weighing_truth(dataset, params), dataset.frame_columns
    rows = np.arange(0, len(truth), max(1, -(-len(truth) // MAX_BOXES)))
    rows = rows[~truth.ignore[rows]]
    n_all = f"{int(np.count_nonzero(~truth.ignore)):,} boxes"
    if params.proximity == "distance":
        distance_m = truth.distance_m[rows]
        measured = distance_m[np.isfinite(distance_m)]
        return measured, [(params.midpoint_m, -params.spread_m)], f"distance (m), {n_all}"
    settings = [in_use(params, "midpoint", frames), in_use(params, "spread", frames)]
    pairs = np.unique(np.column_stack(settings), axis=0)
    curves = [(float(zero), float(soft)) for zero, soft in pairs[:N_CURVES]]
    if params.proximity == "horizon":
        horizon = in_use(params, "horizon", frames)
        foot = truth.y[rows] + truth.h[rows]
        depth = foot - horizon[frames.recording[truth.frame_index[rows]]]
        return depth[np.isfinite(depth)], curves, f"foot below horizon (px), {n_all}"
    return truth.h[rows], curves, f"height (px), {n_all}"
