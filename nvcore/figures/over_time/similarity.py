"""Similarity of both systems over the time of one recording, with where it is low."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from tsdownsample import MinMaxLTTBDownsampler

from nvcore.comparison import Result
from nvcore.figures.marks import click_markers, still_line
from nvcore.figures.style import (
    HEADING_PX,
    LEFT_PX,
    LEGEND_PX,
    LOOK,
    axis,
    begins_at,
    draw,
    empty_figure,
    faded,
    plain,
    system_label,
    write,
)
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.scoring import SystemResult
from nvcore.wording import count_text

MAX_POINTS: Final = 4000
"""Points of one line: more than a screen has columns, few enough for the browser."""


def decimate(values: np.ndarray, *, n_points: int = MAX_POINTS) -> np.ndarray:
    """Rows that keep the shape of a series when drawn; sorted int64, at most `n_points` of them.

    The smallest and the largest value are always among them, as are the first and the last row.
    """
    n = len(values)
    if n <= n_points:
        return np.arange(n)
    sampled = MinMaxLTTBDownsampler().downsample(  # type: ignore[no-untyped-call]
        np.ascontiguousarray(values, dtype=np.float64), n_out=n_points - 2
    )
    extremes = [int(np.argmin(values)), int(np.argmax(values))]
    rows: np.ndarray = np.union1d(sampled.astype(np.int64), extremes)
    return rows


def evenly(n: int, *, n_points: int) -> np.ndarray:
    """At most `n_points` rows spread evenly over 0..n-1, both ends included; int64."""
    if n <= n_points:
        return np.arange(n)
    return np.linspace(0, n - 1, n_points).round().astype(np.int64)


def end_of(result: Result, recording: int) -> float:
    """When the last frame of a recording ends, s; for recordings with frames."""
    last = result.dataset.frame_columns.rows_of(recording).stop - 1
    frames = result.dataset.frames
    return float(frames["time_s"].to_numpy()[last] + frames["step_s"].to_numpy()[last])


def time_range(end_s: float) -> list[float]:
    """Ends of an axis over a whole recording, with a little room: the same in all its figures."""
    return [-0.005 * end_s, end_s * 1.005 or 1.0]


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
    end_s: float
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
    worst = lows.sort_values("depth_s", ascending=False, kind="stable").head(MAX_INTERVALS)
    values, time_s = system.similarity[span.start : span.stop], span.time_s
    drawn = decimate(values)
    corners_t: list[np.ndarray] = []
    corners_v: list[np.ndarray] = []
    first_rows = worst["first_row"].to_numpy() - span.start
    last_rows = worst["last_row"].to_numpy() - span.start
    worst_rows = worst["worst_row"].to_numpy() - span.start
    # a loop over at most MAX_INTERVALS polygons
    for first, last, lowest in zip(first_rows, last_rows, worst_rows, strict=True):
        inside = drawn[np.searchsorted(drawn, first) : np.searchsorted(drawn, last, side="right")]
        rows = np.union1d(inside, [first, lowest, last])
        edges = _crossing(time_s, values, first, -1, low), _crossing(time_s, values, last, 1, low)
        corners_t.append(np.concatenate([[edges[0]], time_s[rows], [edges[1], edges[0], np.nan]]))
        corners_v.append(np.concatenate([[low], values[rows], [low, low, np.nan]]))
    none = [np.empty(0)]
    axes = span.axes(np.concatenate(corners_t or none), np.concatenate(corners_v or none), letter)
    return still_line(
        **axes,
        fill="toself",
        fillcolor=faded(LOOK[theme].of(letter), 0.28),
        line={"width": 0},
        legendgroup=letter,
        name=f"{letter.upper()}, low similarity",
        meta=f"nv-low-{letter}",
    )


def _crossing(time_s: np.ndarray, values: np.ndarray, row: int, way: int, low: float) -> float:
    """Where the line from a low frame to its neighbour crosses the limit, seconds."""
    other = row + way
    if not 0 <= other < len(values):
        return float(time_s[row])
    share = (low - values[row]) / (values[other] - values[row])
    return float(time_s[row] + share * (time_s[other] - time_s[row]))


def event_marks(
    span: TimeSpan, events: pd.DataFrame, letter: str, theme: Theme, objects: Objects
) -> list[Any]:
    """Bars of the saliency events, the stronger the more salient, and markers to click."""
    worst = events.sort_values("saliency_s", ascending=False, kind="stable").head(MAX_EVENTS)
    start_s = span.time_s[worst["first_row"].to_numpy() - span.start]
    duration_s, saliency_s = worst["duration_s"].to_numpy(), worst["saliency_s"].to_numpy()
    # in the strip X stands above Y, or left of it
    place = np.full(len(worst), int((letter == "x") != span.upright), dtype=float)
    strength = saliency_s / saliency_s.max(initial=1e-9)
    colour = LOOK[theme].of(letter)
    rim = {"width": 1, "color": colour}
    bars = go.Bar(
        **span.strip(duration_s, place),
        base=start_s,
        width=0.72,
        orientation="v" if span.upright else "h",
        hoverinfo="skip",
        showlegend=False,
        marker={"color": colour, "opacity": 0.35 + 0.65 * strength, "line": rim},
        name=f"{letter.upper()}, saliency events",
        legendgroup=letter,
    )
    text = [
        f"{letter.upper()} misses {objects.singular} {track} for {duration:.2f} s<br>"
        f"from {start:.2f} s: saliency {saliency:.2f} s (recency {recency:.2f})"
        for track, start, duration, saliency, recency in zip(
            worst["track"], start_s, duration_s, saliency_s, worst["recency"], strict=True
        )
    ]
    clicks = click_markers(
        **span.strip(start_s + duration_s / 2, place),
        texts=text,
        customdata=worst["first_row"].to_numpy(),
        name=f"{letter.upper()}, events",
    )
    return [bars, clicks]


TimeLayout = Literal["time", "upright", "side_by_side"]

MAX_CLICKS: Final = 800
"""Frames that can be clicked: one for a column of pixels; the browser draws a marker for each."""
MEAN_POINTS: Final = 2000
HEIGHT_PX: Final[dict[TimeLayout, int]] = {"time": 400, "upright": 720, "side_by_side": 720}


def similarity_plot(
    result: Result,
    recording: int,
    *,
    theme: Theme,
    cursor_row: int | None = None,
    layout: TimeLayout = "time",
) -> go.Figure:
    """Similarity of X and Y over time: frame by frame, moving mean, low intervals, events.

    The area between the low limit and a trace below it is the depth of that interval. A click gives
    the frame: `customdata` is its row in ``dataset.frames``.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    cursor_row
        Row in ``dataset.frames`` of the frame that is shown; None: no cursor.
    layout
        ``"time"``: time to the right. ``"upright"``: time upwards, X to the left of the middle
        and Y to the right, with 1 (perfect) in the middle (paper, figure 8). ``"side_by_side"``:
        the same, with similarity growing to the right for both systems.
    """
    start, stop = result.dataset.frame_columns.first[recording : recording + 2]
    if start == stop:
        return empty_figure("This recording has no frames.", theme=theme)
    time_s = result.dataset.frames["time_s"].to_numpy()[start:stop]
    span = TimeSpan(int(start), int(stop), time_s, end_of(result, recording), layout != "time")
    traces, counts = [], []
    for letter, system in result.sides:
        lows = _of_recording(system.intervals, recording)
        events = _of_recording(system.events, recording)
        traces += [
            low_areas(span, system, lows, letter, result.params.low, theme),
            *_lines(span, system, letter, theme),
            *event_marks(span, events, letter, theme, result.objects),
        ]
        counts.append((letter.upper(), len(lows), len(events)))
    floor = _floor(result, span)
    traces += _clicks(result, span, floor)
    name = plain(result.dataset.recordings["name"][recording])
    figure = draw(
        traces,
        theme,
        title=f"Similarity over time, {name}",
        subtitle=_subtitle(result, span, counts),
        height=HEIGHT_PX[layout],
        margin={"l": LEFT_PX, "t": HEADING_PX + LEGEND_PX},
        barmode="overlay",
        hoverdistance=-1,
        uirevision=f"{result.dataset.fingerprint} {recording} {layout}",
        **_axes(span, floor, layout, theme),
    )
    _limit_line(figure, span, result.params.low, theme)
    if cursor_row is not None and span.start <= cursor_row < span.stop:
        cursor_s = float(time_s[cursor_row - span.start])
        line = {"color": LOOK[theme].ink, "width": 1.5}
        along, across = ("y", "x") if span.upright else ("x", "y")
        _line_at(figure, cursor_s, (along, along), (across, "paper"), name="cursor", line=line)
    return figure


def _of_recording(spans: pd.DataFrame, recording: int) -> pd.DataFrame:
    chosen: pd.DataFrame = spans[spans["recording"].to_numpy() == recording]
    return chosen


def _lines(span: TimeSpan, system: SystemResult, letter: str, theme: Theme) -> list[go.Scatter]:
    """The trace, thin, and its moving mean, thick."""
    colour = LOOK[theme].of(letter)

    def line(values: np.ndarray, n_points: int, **more: Any) -> go.Scatter:
        part = values[span.start : span.stop]
        rows = decimate(part, n_points=n_points)
        axes = span.axes(span.time_s[rows], part[rows], letter)
        return still_line(**axes, legendgroup=letter, **more)

    thin = {"width": 1, "color": faded(colour, 0.55)}
    thick = {"width": 2.4, "color": colour, "dash": LOOK[theme].dash(letter)}
    name, mean_name = f"{letter.upper()}, frame by frame", system_label(letter, system.name)
    mean = system.similarity_window
    return [
        line(system.similarity, MAX_POINTS, line=thin, name=name, meta=f"nv-raw-{letter}"),
        line(
            mean,
            MEAN_POINTS,
            line=thick,
            name=mean_name,
            showlegend=None,
            meta=f"nv-mean-{letter}",  # the browser moves these lines with the sliders
        ),
    ]


def _clicks(result: Result, span: TimeSpan, floor: float) -> list[go.Scatter]:
    """One line of invisible markers: the one nearest to a click is the frame at that time."""
    rows = span.start + evenly(span.stop - span.start, n_points=MAX_CLICKS)
    frame = result.dataset.frames["frame"].to_numpy()[rows]
    time_s = span.time_s[rows - span.start]
    x, y = result.x.similarity[rows], result.y.similarity[rows]
    text = [
        f"frame {number}, {second:.2f} s<br>X {value_x:.2f}   Y {value_y:.2f}"
        for number, second, value_x, value_y in zip(frame, time_s, x, y, strict=True)
    ]
    middle = np.full(len(rows), (1 + floor) / 2)
    return [
        click_markers(
            **span.axes(time_s, middle, letter), texts=text, customdata=rows, name="frames"
        )
        for letter in ("xy" if span.upright else "x")
    ]


def _floor(result: Result, span: TimeSpan) -> float:
    """Lower end of the axis: in steps, so that it stays where it is while a slider moves."""
    least = min(system.similarity[span.start : span.stop].min() for _, system in result.sides)
    return max(0.0, float(np.floor((min(least, result.params.low) - 0.02) * 5) / 5))


def _subtitle(result: Result, span: TimeSpan, counts: list[tuple[str, int, int]]) -> str:
    lows = _counts_text({letter: n for letter, n, _ in counts}, MAX_INTERVALS)
    events = _counts_text({letter: n for letter, _, n in counts}, MAX_EVENTS)
    return (
        f"{count_text(span.stop - span.start, 'frame')}; moving mean over "
        f"{result.params.window:g} s; low-similarity intervals: {lows}; saliency events: {events}"
    )


def _counts_text(counts: dict[str, int], most: int) -> str:
    return ", ".join(
        f"{letter} {n:,}" + (f" (worst {most} drawn)" if n > most else "")
        for letter, n in counts.items()
    )


def _axes(span: TimeSpan, floor: float, layout: TimeLayout, theme: Theme) -> dict[str, Any]:
    def similarity(of: str, domain: list[float], ends: list[float]) -> dict[str, Any]:
        form = {"range": ends, "fixedrange": True, "tickformat": ".2~f", "domain": domain}
        return axis(theme, f"similarity{of} (1 = perfect){begins_at(floor)}", **form)

    time = axis(theme, "time (s)", range=time_range(span.end_s))
    strip: dict[str, Any] = {"range": [-0.6, 1.6], "tickvals": [0, 1]}
    strip |= {"fixedrange": True, "showgrid": False}
    if not span.upright:
        strip |= {"ticktext": ["Y events", "X events"], "domain": [0.85, 1], "anchor": "x"}
        return {
            "xaxis": time | {"anchor": "y"},
            "yaxis": similarity("", [0, 0.80], [floor, 1.02]),
            "yaxis2": axis(theme, **strip),
        }
    strip |= {"ticktext": ["X", "Y"], "domain": [0.455, 0.545]}
    ends_of_y = [1.02, floor] if layout == "upright" else [floor, 1.02]
    return {
        "yaxis": time,
        "xaxis": similarity(" of X", [0, 0.44], [floor, 1.02]),
        "xaxis2": axis(theme, "events", **strip),
        "xaxis3": similarity(" of Y", [0.56, 1], ends_of_y),
    }


def _line_at(
    figure: go.Figure, edge: float, along: tuple[str, str], across: tuple[str, str], **more: Any
) -> None:
    """A line at one value of an axis, over the other's whole length: (x or y, reference)."""
    (name, ref), (cross_name, cross_ref) = along, across
    place = {f"{name}0": edge, f"{name}1": edge, f"{name}ref": ref}
    place |= {f"{cross_name}0": 0, f"{cross_name}1": 1, f"{cross_name}ref": cross_ref}
    figure.add_shape(type="line", **more, **place)


def _limit_line(figure: go.Figure, span: TimeSpan, low: float, theme: Theme) -> None:
    muted = LOOK[theme].muted
    line = {"color": muted, "width": 1, "dash": "dot"}
    along, across = ("x", "y") if span.upright else ("y", "x")
    for ref in ("x", "x3") if span.upright else ("y",):
        ends = (along, ref), (across, f"{across} domain")
        _line_at(figure, low, *ends, name="low limit", line=line, layer="below")
    place = {along: low, across: 1, f"{across}ref": f"{across} domain", "xanchor": "right"}
    write(figure, f"low limit {low:g}", size=11, color=muted, yanchor="top", **place)
