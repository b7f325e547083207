"""Similarity of both systems over the time of one recording, with where it is low."""

from __future__ import annotations

from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.analysis import Result, SystemResult
from nvcore.figures.series import decimate, evenly
from nvcore.figures.style import (
    DASH,
    LOOK,
    axis,
    click_markers,
    count_text,
    empty_figure,
    faded,
    heading,
    layout,
    plain,
    system_label,
)
from nvcore.figures.time_marks import MAX_EVENTS, MAX_INTERVALS, TimeSpan, event_marks, low_areas
from nvcore.palette import Theme
from nvcore.tables import sides

TimeLayout = Literal["time", "upright"]

MAX_CLICKS: Final = 800
"""Frames that can be clicked: one for a column of pixels; the browser draws a marker for each."""
MEAN_POINTS: Final = 2000
HEIGHT_PX: Final[dict[TimeLayout, int]] = {"time": 400, "upright": 720}


def similarity_plot(
    result: Result,
    recording: int,
    *,
    theme: Theme,
    cursor_row: int | None = None,
    layout: TimeLayout = "time",
) -> go.Figure:
    """Similarity of X and Y over time: frame by frame, moving mean, low intervals, events.

    The area between the low limit and a trace below it is the severity of that interval. A click
    gives the frame: `customdata` is its row in ``dataset.frames``.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    cursor_row
        Row in ``dataset.frames`` of the frame that is shown; None: no cursor.
    layout
        ``"time"``: time to the right. ``"upright"``: time upwards, X to the left of the middle
        and Y to the right, with 1 (perfect) in the middle (paper, figure 8).
    """
    start, stop = result.dataset.frame_columns.first[recording : recording + 2]
    if start == stop:
        return empty_figure("This recording has no frames.", theme=theme)
    time_s = result.dataset.frames["time_s"].to_numpy()[start:stop]
    span = TimeSpan(int(start), int(stop), time_s, layout == "upright")
    traces, counts = [], []
    for letter, system in sides(result):
        lows = _of_recording(system.intervals, recording)
        events = _of_recording(system.events, recording)
        traces += [
            low_areas(span, system, lows, letter, result.params.low, theme),
            *_lines(span, system, letter, theme),
            *event_marks(span, events, letter, theme),
        ]
        counts.append((letter.upper(), len(lows), len(events)))
    floor = _floor(result, span)
    traces += _clicks(result, span, floor)
    name = plain(result.dataset.recordings["name"][recording])
    figure = go.Figure(traces, _layout(span, floor, theme))
    figure.update_layout(
        title_text=heading(
            f"Similarity over time, {name}", _subtitle(result, span, counts), theme=theme
        ),
        uirevision=f"{result.dataset.fingerprint} {recording} {layout}",
    )
    _limit_line(figure, span, result.params.low, theme)
    if cursor_row is not None and span.start <= cursor_row < span.stop:
        at = float(time_s[cursor_row - span.start])
        _line_across(figure, span, at, {"color": LOOK[theme].ink, "width": 1.5}, name="cursor")
    return figure


def _of_recording(spans: pd.DataFrame, recording: int) -> pd.DataFrame:
    chosen: pd.DataFrame = spans[spans["recording"].to_numpy() == recording]
    return chosen


def _lines(span: TimeSpan, system: SystemResult, letter: str, theme: Theme) -> list[go.Scatter]:
    """The trace, thin, and its moving mean, thick."""
    colour = LOOK[theme].of(letter)
    traces = []
    for values, n_points, line, more in (
        (system.similarity, None, {"width": 1, "color": faded(colour, 0.55)},
         {"showlegend": False, "name": f"{letter.upper()}, frame by frame"}),
        (system.similarity_window, MEAN_POINTS,
         {"width": 2.4, "color": colour, "dash": DASH[letter]},
         {"name": system_label(letter, system.name)}),
    ):  # fmt: skip
        part = values[span.start : span.stop]
        rows = decimate(part) if n_points is None else decimate(part, n_points=n_points)
        axes = span.axes(span.time_s[rows], part[rows], letter)
        traces.append(
            go.Scatter(
                **axes, mode="lines", line=line, legendgroup=letter, hoverinfo="skip", **more
            )
        )
    return traces


def _clicks(result: Result, span: TimeSpan, floor: float) -> list[go.Scatter]:
    """One line of invisible markers: the one nearest to a click is the frame at that time."""
    rows = span.start + evenly(span.stop - span.start, n_points=MAX_CLICKS)
    frame = result.dataset.frames["frame"].to_numpy()[rows]
    time_s = span.time_s[rows - span.start]
    x, y = result.x.similarity[rows], result.y.similarity[rows]
    text = [
        f"frame {number}, {second:.2f} s<br>X {one:.2f}   Y {other:.2f}"
        for number, second, one, other in zip(frame, time_s, x, y, strict=True)
    ]
    middle = np.full(len(rows), (1 + floor) / 2)
    return [
        click_markers(
            **span.axes(time_s, middle, letter), customdata=rows, text=text,
            hovertemplate="%{text}<extra></extra>", name="frames",
        )
        for letter in ("xy" if span.upright else "x")
    ]  # fmt: skip


def _floor(result: Result, span: TimeSpan) -> float:
    """Lower end of the axis: in steps, so that it stays where it is while a slider moves."""
    least = min(system.similarity[span.start : span.stop].min() for _, system in sides(result))
    return max(0.0, float(np.floor((min(least, result.params.low) - 0.02) * 5) / 5))


def _subtitle(result: Result, span: TimeSpan, counts: list[tuple[str, int, int]]) -> str:
    def told(of: dict[str, int], most: int) -> str:
        return ", ".join(
            f"{letter} {n:,}" + (f" (worst {most} drawn)" if n > most else "")
            for letter, n in of.items()
        )

    lows = {letter: n for letter, n, _ in counts}
    events = {letter: n for letter, _, n in counts}

    return (
        f"{count_text(span.stop - span.start, 'frame')}; moving mean over "
        f"{result.params.window:g} s; low-similarity intervals: {told(lows, MAX_INTERVALS)}; "
        f"saliency events: {told(events, MAX_EVENTS)}"
    )


def _layout(span: TimeSpan, floor: float, theme: Theme) -> dict[str, Any]:
    value: dict[str, Any] = {"range": [floor, 1.02], "fixedrange": True, "tickformat": ".2~f"}
    end = float(span.time_s[-1])
    time = {"range": [-0.005 * end, end * 1.005 or 1.0], "title_text": "time (s)"}
    strip: dict[str, Any] = {
        "range": [-0.6, 1.6], "fixedrange": True, "tickvals": [0, 1], "showgrid": False,
    }  # fmt: skip
    shared: dict[str, Any] = {
        "barmode": "overlay",
        "hoverdistance": -1,
        "height": HEIGHT_PX["upright" if span.upright else "time"],
    }
    if not span.upright:
        return layout(theme, title=" ", **shared) | {
            "xaxis": axis(theme) | time | {"anchor": "y"},
            "yaxis": axis(theme, "similarity (1 = perfect)") | value | {"domain": [0, 0.80]},
            "yaxis2": axis(theme, **strip, ticktext=["Y events", "X events"])
            | {"domain": [0.85, 1], "anchor": "x"},
        }
    return layout(theme, title=" ", **shared) | {
        "yaxis": axis(theme) | time,
        "xaxis": axis(theme, "similarity of X (1 = perfect)") | value | {"domain": [0, 0.44]},
        "xaxis2": axis(theme, "events", **strip, ticktext=["X", "Y"]) | {"domain": [0.455, 0.545]},
        "xaxis3": axis(theme, "similarity of Y (1 = perfect)")
        | value | {"range": [1.02, floor], "domain": [0.56, 1]},
    }  # fmt: skip


def _line_across(
    figure: go.Figure, span: TimeSpan, time_s: float, line: dict[str, Any], *, name: str
) -> None:
    """A line over the whole height (width) at one time."""
    along, across = ("y", "x") if span.upright else ("x", "y")
    figure.add_shape(
        {
            "type": "line", "name": name, "line": line,
            f"{along}0": time_s, f"{along}1": time_s, f"{along}ref": along,
            f"{across}0": 0, f"{across}1": 1, f"{across}ref": "paper",
        }
    )  # fmt: skip


def _limit_line(figure: go.Figure, span: TimeSpan, low: float, theme: Theme) -> None:
    look = LOOK[theme]
    line = {"color": look.muted, "width": 1, "dash": "dot"}
    along, across = ("x", "y") if span.upright else ("y", "x")
    for ref in ("x", "x3") if span.upright else ("y",):
        figure.add_shape(
            {
                "type": "line", "name": "low limit", "line": line, "layer": "below",
                f"{along}0": low, f"{along}1": low, f"{along}ref": ref,
                f"{across}0": 0, f"{across}1": 1,
                f"{across}ref": "y domain" if span.upright else "x domain",
            }
        )  # fmt: skip
    figure.add_annotation(
        text=f"low limit {low:g}", showarrow=False, font={"size": 11, "color": look.muted},
        **({"x": low, "y": 1, "yref": "y domain", "xanchor": "right", "yanchor": "top"}
           if span.upright else
           {"x": 1, "xref": "x domain", "y": low, "xanchor": "right", "yanchor": "top"}),
    )  # fmt: skip
