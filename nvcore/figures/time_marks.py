"""What the time plot marks: low-similarity intervals and saliency events of one recording."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.analysis import SystemResult
from nvcore.figures.series import decimate
from nvcore.figures.style import LOOK, click_markers, faded
from nvcore.palette import Theme

MAX_INTERVALS: Final = 200
"""Low-similarity intervals drawn for each system, largest severity first."""
MAX_EVENTS: Final = 200
"""Saliency events drawn for each system, largest saliency first."""


@dataclass(frozen=True)
class TimeSpan:
    """The rows of one recording, its times, and the axes that a figure puts them on."""

    start: int
    stop: int
    time_s: np.ndarray
    upright: bool

    def axes(self, time_s: Any, value: Any, letter: str) -> dict[str, Any]:
        """`x`, `y` and the axes of a trace of values over time."""
        if not self.upright:
            return {"x": time_s, "y": value, "xaxis": "x", "yaxis": "y"}
        return {"x": value, "y": time_s, "xaxis": "x" if letter == "x" else "x3", "yaxis": "y"}

    def strip(self, time_s: Any, place: Any) -> dict[str, Any]:
        """The same for the strip of saliency events."""
        if not self.upright:
            return {"x": time_s, "y": place, "xaxis": "x", "yaxis": "y2"}
        return {"x": place, "y": time_s, "xaxis": "x2", "yaxis": "y"}


def low_areas(
    span: TimeSpan, system: SystemResult, lows: pd.DataFrame, letter: str, low: float, theme: Theme
) -> go.Scatter:
    """Polygons between the low limit and the trace, one for each interval drawn."""
    worst = lows.sort_values("severity_s", ascending=False, kind="stable").head(MAX_INTERVALS)
    values, time_s = system.similarity[span.start : span.stop], span.time_s
    kept = decimate(values)
    corners_t: list[np.ndarray] = []
    corners_v: list[np.ndarray] = []
    first_rows = worst["first_row"].to_numpy() - span.start
    last_rows = worst["last_row"].to_numpy() - span.start
    worst_rows = worst["worst_row"].to_numpy() - span.start
    # a loop over at most MAX_INTERVALS polygons
    for first, last, lowest in zip(first_rows, last_rows, worst_rows, strict=True):
        inside = kept[np.searchsorted(kept, first) : np.searchsorted(kept, last, side="right")]
        rows = np.union1d(inside, [first, lowest, last])
        edges = _crossing(time_s, values, first, -1, low), _crossing(time_s, values, last, 1, low)
        corners_t.append(np.concatenate([[edges[0]], time_s[rows], [edges[1], edges[0], np.nan]]))
        corners_v.append(np.concatenate([[low], values[rows], [low, low, np.nan]]))
    none = [np.empty(0)]
    axes = span.axes(np.concatenate(corners_t or none), np.concatenate(corners_v or none), letter)
    return go.Scatter(
        **axes, mode="lines", fill="toself", fillcolor=faded(LOOK[theme].of(letter), 0.28),
        line={"width": 0}, hoverinfo="skip", legendgroup=letter, showlegend=False,
        name=f"{letter.upper()}, low similarity",
    )  # fmt: skip


def _crossing(time_s: np.ndarray, values: np.ndarray, row: int, way: int, low: float) -> float:
    """Where the line from a low frame to its neighbour crosses the limit, seconds."""
    other = row + way
    if not 0 <= other < len(values):
        return float(time_s[row])
    share = (low - values[row]) / (values[other] - values[row])
    return float(time_s[row] + share * (time_s[other] - time_s[row]))


def event_marks(span: TimeSpan, events: pd.DataFrame, letter: str, theme: Theme) -> list[Any]:
    """Bars of the saliency events, the stronger the more salient, and markers to click."""
    worst = events.sort_values("saliency_s", ascending=False, kind="stable").head(MAX_EVENTS)
    start_s = span.time_s[worst["first_row"].to_numpy() - span.start]
    duration_s, saliency_s = worst["duration_s"].to_numpy(), worst["saliency_s"].to_numpy()
    # in the strip X stands above Y, or left of it
    place = np.full(len(worst), int((letter == "x") != span.upright), dtype=float)
    strength = saliency_s / saliency_s.max(initial=1e-9)
    colour = LOOK[theme].of(letter)
    bars = go.Bar(
        **span.strip(duration_s, place), base=start_s, width=0.72,
        orientation="v" if span.upright else "h", hoverinfo="skip", showlegend=False,
        marker={"color": colour, "opacity": 0.35 + 0.65 * strength,
                "line": {"width": 1, "color": colour}},
        name=f"{letter.upper()}, saliency events", legendgroup=letter,
    )  # fmt: skip
    steady = {"marker": {"opacity": 1}}
    bars.update(selected=steady, unselected=steady)
    text = [
        f"{letter.upper()} misses pedestrian {track} for {duration:.2f} s<br>from {start:.2f} s: "
        f"saliency {saliency:.2f} s (recency {recency:.2f})"
        for track, start, duration, saliency, recency in zip(
            worst["track"], start_s, duration_s, saliency_s, worst["recency"], strict=True
        )
    ]
    clicks = click_markers(
        **span.strip(start_s + duration_s / 2, place), customdata=worst["first_row"].to_numpy(),
        text=text, hovertemplate="%{text}<extra></extra>", name=f"{letter.upper()}, events",
    )  # fmt: skip
    return [bars, clicks]
