"""Figures of one recording over time: similarity of X and Y, and losses of each frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from tsdownsample import MinMaxLTTBDownsampler

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text, number
from nvcore.comparison.compare import Result
from nvcore.figures.marks import click_markers, row_texts, rule, still_line
from nvcore.figures.style import HEADING_PX, LOOK, ChartLook, faded, plain, system_label, write
from nvcore.metrics.losses import lost_per_minute

TimeLayout = Literal["time", "upright", "side_by_side"]

LEFT_PX: Final = 84
"""Left margin of the figures over time, so that they line up below each other."""
LEGEND_PX: Final = 52
"""Height of a legend in one row, with the gaps around it."""
NO_FRAMES: Final = "This recording has no frames."
MAX_POINTS: Final = 4000
"""Maximum number of points of a line: more than a screen has columns, few enough to draw."""
MEAN_POINTS: Final = 2000
MAX_CLICKS: Final = 800
"""Maximum number of clickable frames, about one for each column of pixels."""
MAX_INTERVALS: Final = 200
"""Maximum number of low-similarity intervals drawn for each system, most severe first."""
MAX_EVENTS: Final = 200
"""Maximum number of saliency events drawn for each system, most salient first."""
HEIGHT_PX: Final[dict[TimeLayout, int]] = {"time": 400, "upright": 720, "side_by_side": 720}
LOSSES_PX: Final = 440
LOSS_PANELS: Final = {"x": [0.53, 1.0], "y": [0.0, 0.47]}
"""Lower and upper end of each system's panel, as shares of the plot's height."""
LEAST_TOP: Final = 0.2
"""Least upper end of a scale of losses, so that trifles look small."""


def decimate(values: np.ndarray, *, n_points: int = MAX_POINTS) -> np.ndarray:
    """Return at most `n_points` rows that keep the shape of a series when drawn, sorted int64.

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
    """Return at most `n_points` rows spread evenly over 0..n-1, both ends included, int64."""
    if n <= n_points:
        return np.arange(n)
    return np.linspace(0, n - 1, n_points).round().astype(np.int64)


def keep_peaks(*series: np.ndarray, n_points: int = MAX_POINTS) -> np.ndarray:
    """Return at most `n_points` rows that draw several series of one length, sorted int64.

    The rows are cut into stretches of one length. Of each stretch the largest value of every
    series is kept, so that no short loss disappears, and the smallest sum, so that no pause does;
    the first and the last row are always kept.
    """
    n = len(series[0])
    if n <= n_points:
        return np.arange(n)
    starts = np.linspace(0, n, (n_points - 2) // (len(series) + 1), endpoint=False).astype(np.int64)
    lengths = np.diff(starts, append=n)
    kept = [np.array([0, n - 1])]
    for values in (*series, -np.sum(series, axis=0)):
        largest = np.maximum.reduceat(values, starts)
        hits = np.flatnonzero(values == np.repeat(largest, lengths))
        kept.append(hits[np.searchsorted(hits, starts)])  # the first of equals
    return np.unique(np.concatenate(kept))


def end_of(result: Result, recording: int) -> float:
    """Return the end of a recording's last frame, s. The recording must have frames."""
    last = result.dataset.frame_columns.rows_of(recording).stop - 1
    frames = result.dataset.frames
    return float(frames["time_s"].to_numpy()[last] + frames["step_s"].to_numpy()[last])


def frame_texts(result: Result, rows: np.ndarray, template: str, **columns: Any) -> list[str]:
    """Fill a template for rows of the frames table with their frame and time_s (`row_texts`)."""
    frames = result.dataset.frames
    own = {name: frames[name].to_numpy()[rows] for name in ("frame", "time_s")}
    return row_texts(template, **own, **columns)


@dataclass(frozen=True)
class OverTime:
    """A recording whose figures share the axis of time. `recording` is its row."""

    result: Result
    recording: int
    look: ChartLook

    @property
    def rows(self) -> slice:
        """Its rows in the frames table."""
        return self.result.dataset.frame_columns.rows_of(self.recording)

    @property
    def time_s(self) -> np.ndarray:
        """Start of each frame, s."""
        return self.result.dataset.frames["time_s"].to_numpy()[self.rows]

    def axis(self, title: str = "", **more: Any) -> dict[str, Any]:
        """Return the axis over the whole recording with a little room."""
        end_s = end_of(self.result, self.recording)
        ends = [-0.005 * end_s, end_s * 1.005 or 1.0]
        return self.look.axis(title, can_zoom=True, range=ends, **more)

    def draw(self, traces: Any, kind: str, title: str, **more: Any) -> go.Figure:
        """Draw a figure with the recording's name in the title.

        While its `kind` stays the same, the browser keeps the visible range, unless it is empty.
        """
        dataset = self.result.dataset
        title = f"{title}, {plain(dataset.recordings['name'][self.recording])}"
        more["margin"] = {"l": LEFT_PX, **more.get("margin", {})}
        key = f"{dataset.fingerprint} {self.recording} {kind}" if kind else None
        return self.look.draw(traces, title=title, hoverdistance=-1, uirevision=key, **more)

    def draw_cursor(self, figure: go.Figure, row: int | None, **place: Any) -> None:
        """Draw a line at the frame that is shown, if it is one of the recording."""
        if row is not None and self.rows.start <= row < self.rows.stop:
            place, time_s = {"direction": "x"} | place, float(self.time_s[row - self.rows.start])
            rule(figure, at=time_s, color=self.look.ink, name="cursor", **place)


@dataclass(frozen=True)
class Panels(OverTime):
    """Panels of a recording, each with its axis of values. Time runs upwards if `upright`."""

    axes: Mapping[str, str]
    upright: bool = False

    def place(self, panel: str, time_s: Any, values: Any) -> dict[str, Any]:
        """Return `x`, `y` and the axes of a trace."""
        if self.upright:
            return {"x": values, "y": time_s, "xaxis": self.axes[panel], "yaxis": "y"}
        return {"x": time_s, "y": values, "xaxis": "x", "yaxis": self.axes[panel]}

    def clicks(self, panel: str, level: float, template: str, **columns: np.ndarray) -> go.Scatter:
        """Return invisible markers. The one nearest to a click is the frame at that time."""
        inside = evenly(self.rows.stop - self.rows.start, n_points=MAX_CLICKS)
        rows = self.rows.start + inside
        columns = {name: column[rows] for name, column in columns.items()}
        texts = frame_texts(self.result, rows, template, **columns)
        place = self.place(panel, self.time_s[inside], np.full(len(rows), level))
        return click_markers(**place, texts=texts, customdata=rows, name="frames")


def similarity_plot(
    result: Result,
    recording: int,
    *,
    theme: Theme,
    cursor_row: int | None = None,
    layout: TimeLayout = "time",
) -> go.Figure:
    """Draw similarity of X and Y over time, its moving mean, low intervals and events.

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
    look = LOOK[theme]
    rows, upright = result.dataset.frame_columns.rows_of(recording), layout != "time"
    if rows.start == rows.stop:
        return look.empty(NO_FRAMES)
    axes = (
        {"x": "x", "y": "x3", "events": "x2"} if upright else {"x": "y", "y": "y", "events": "y2"}
    )
    panels = Panels(result, recording, look, axes, upright)
    traces: list[Any] = []
    lows, events = {}, {}
    for letter, system in result.sides:
        lows[letter] = system.intervals[system.intervals["recording"] == recording]
        events[letter] = system.events[system.events["recording"] == recording]
        traces.append(_low_areas(panels, letter, lows[letter]))
        traces += _similarity_lines(panels, letter)
        traces += _event_marks(panels, letter, events[letter])
    low, similarity = result.params.low, [system.similarity for _, system in result.sides]
    # in steps, so that the end of the axis stays where it is while a slider moves
    least = min(low, *(of_system[rows].min() for of_system in similarity))
    floor = max(0.0, float(np.floor((least - 0.02) * 5) / 5))
    template = "frame {frame}, {time_s:.2f} s<br>X {x:.2f}   Y {y:.2f}"
    of_both = dict(zip("xy", similarity, strict=True))
    middle = (1 + floor) / 2
    traces += [
        panels.clicks(letter, middle, template, **of_both) for letter in ("xy" if upright else "x")
    ]
    figure = panels.draw(
        traces,
        layout,
        "Similarity over time",
        subtitle=f"{count_text(rows.stop - rows.start, 'frame')}; moving mean over "
        f"{result.params.window:g} s; low-similarity intervals: {_drawn(lows, MAX_INTERVALS)}; "
        f"saliency events: {_drawn(events, MAX_EVENTS)}",
        height=HEIGHT_PX[layout],
        margin={"t": HEADING_PX + LEGEND_PX},
        barmode="overlay",
        **_similarity_axes(panels, floor, layout),
    )
    muted = look.muted
    along, across = ("x", "y") if upright else ("y", "x")
    looks = look.dotted | {"layer": "below"}
    over = f"{across} domain"
    for ref in ("x", "x3") if upright else ("y",):
        rule(figure, along, low, ref=ref, over=over, name="low limit", **looks)
    place = {along: low, across: 1, f"{across}ref": over, "xanchor": "right", "yanchor": "top"}
    write(figure, f"low limit {low:g}", size=11, color=muted, **place)
    panels.draw_cursor(figure, cursor_row, direction=across, ref=across)
    return figure


def _drawn(tables: Mapping[str, pd.DataFrame], most: int) -> str:
    """Return how many intervals or events there are, and how many of them are drawn."""
    return ", ".join(
        f"{letter.upper()} {len(table):,}" + f" (worst {most} drawn)" * (len(table) > most)
        for letter, table in tables.items()
    )


def _low_areas(panels: Panels, letter: str, lows: pd.DataFrame) -> go.Scatter:
    """Draw polygons between the low limit and the trace, one for each interval drawn."""
    low, time_s = panels.result.params.low, panels.time_s
    values = panels.result.system(letter).similarity[panels.rows]
    drawn = decimate(values)
    worst = lows.sort_values("depth_s", ascending=False, kind="stable").head(MAX_INTERVALS)
    parts = [np.empty((2, 0))]
    for interval in worst[["first_row", "worst_row", "last_row"]].to_numpy() - panels.rows.start:
        first, _, last = interval
        rows = np.union1d(drawn[(drawn >= first) & (drawn <= last)], interval)
        begin_s, end_s = (
            _crossing_s(time_s, values, row, way, low) for row, way in ((first, -1), (last, 1))
        )
        parts += [
            np.array([[begin_s], [low]]),
            np.stack([time_s[rows], values[rows]]),
            np.array([[end_s, begin_s, np.nan], [low, low, np.nan]]),
        ]
    return still_line(
        **panels.place(letter, *np.concatenate(parts, axis=1)),
        fill="toself",
        fillcolor=faded(panels.look.of(letter), 0.28),
        width=0,
        legendgroup=letter,
        name=f"{letter.upper()}, low similarity",
        meta=f"nv-low-{letter}",
    )


def _crossing_s(time_s: np.ndarray, values: np.ndarray, row: int, way: int, low: float) -> float:
    """Return the time at which the line from a low frame to its neighbour crosses the limit, s."""
    other = row + way
    if not 0 <= other < len(values):
        return float(time_s[row])
    share = (low - values[row]) / (values[other] - values[row])
    return float(time_s[row] + share * (time_s[other] - time_s[row]))


def _event_marks(panels: Panels, letter: str, events: pd.DataFrame) -> list[Any]:
    """Draw a bar for each saliency event, the stronger the more salient, and markers to click."""
    worst = events.sort_values("saliency_s", ascending=False, kind="stable").head(MAX_EVENTS)
    start_s = panels.time_s[worst["first_row"].to_numpy() - panels.rows.start]
    duration_s, saliency_s = worst["duration_s"].to_numpy(), worst["saliency_s"].to_numpy()
    # in the strip X stands above Y, or left of it
    place = np.full(len(worst), int((letter == "x") != panels.upright), dtype=float)
    strength = saliency_s / saliency_s.max(initial=1e-9)
    colour = panels.look.of(letter)
    bars = go.Bar(
        **panels.place("events", duration_s, place),
        base=start_s,
        width=0.72,
        orientation="v" if panels.upright else "h",
        hoverinfo="skip",
        showlegend=False,
        marker={
            "color": colour,
            "opacity": 0.35 + 0.65 * strength,
            "line": {"width": 1, "color": colour},
        },
        name=f"{letter.upper()}, saliency events",
        legendgroup=letter,
    )
    texts = row_texts(
        "{letter} misses {noun} {track} for {duration_s:.2f} s<br>from {start_s:.2f} s: saliency "
        "{saliency_s:.2f} s (recency {recency:.2f})",
        letter=letter.upper(),
        noun=panels.result.objects.singular,
        start_s=start_s,
        **{name: worst[name] for name in ("track", "duration_s", "saliency_s", "recency")},
    )
    clicks = click_markers(
        **panels.place("events", start_s + duration_s / 2, place),
        texts=texts,
        customdata=worst["first_row"].to_numpy(),
        name=f"{letter.upper()}, events",
    )
    return [bars, clicks]


def _similarity_lines(panels: Panels, letter: str) -> list[go.Scatter]:
    """Draw similarity (thin) and its moving mean (thick). The browser moves both with sliders."""
    system, thick = panels.result.system(letter), panels.look.line(letter)

    def line(values: np.ndarray, n_points: int, kind: str, name: str, **looks: Any) -> go.Scatter:
        rows = decimate(values[panels.rows], n_points=n_points)
        place = panels.place(letter, panels.time_s[rows], values[panels.rows][rows])
        meta = f"nv-{kind}-{letter}"
        return still_line(**place, legendgroup=letter, meta=meta, name=name, **looks)

    raw, label = f"{letter.upper()}, frame by frame", system_label(letter, system.name)
    return [
        line(system.similarity, MAX_POINTS, "raw", raw, color=faded(thick["color"], 0.55), width=1),
        line(system.similarity_window, MEAN_POINTS, "mean", label, line=thick, showlegend=None),
    ]


def _similarity_axes(panels: Panels, floor: float, layout: TimeLayout) -> dict[str, Any]:
    def similarity(of: str, domain: list[float], ends: list[float]) -> dict[str, Any]:
        form: Any = {"range": ends, "tickformat": ".2~f", "domain": domain}
        return panels.look.axis(f"similarity{of} (1 = perfect)", begins=floor, **form)

    time, ends = panels.axis("time (s)"), [floor, 1.02]
    strip: dict[str, Any] = {"range": [-0.6, 1.6], "tickvals": [0, 1], "showgrid": False}
    if layout == "time":
        strip |= {"ticktext": ["Y events", "X events"], "domain": [0.85, 1], "anchor": "x"}
        return {
            "xaxis": time | {"anchor": "y"},
            "yaxis": similarity("", [0, 0.80], ends),
            "yaxis2": panels.look.axis(**strip),
        }
    strip |= {"ticktext": ["X", "Y"], "domain": [0.455, 0.545]}
    return {
        "yaxis": time,
        "xaxis": similarity(" of X", [0, 0.44], ends),
        "xaxis2": panels.look.axis("events", **strip),
        "xaxis3": similarity(" of Y", [0.56, 1], ends[:: -1 if layout == "upright" else 1]),
    }


def loss_plot(
    result: Result, recording: int, *, theme: Theme, cursor_row: int | None = None
) -> go.Figure:
    """Draw the loss of each frame to misses and, stacked on it, to false alarms, 0 is best.

    The height of both areas together is 1 - similarity. X stands above Y, on one scale. A click
    gives the frame: `customdata` is its row in ``dataset.frames``. `recording` and `cursor_row` are
    those of `similarity_plot`.

    References
    ----------
    Paper 11-0360, equation 2; ``docs/metrics.md``, similarity.
    """
    look, rows = LOOK[theme], result.dataset.frame_columns.rows_of(recording)
    if rows.start == rows.stop:
        return look.empty(NO_FRAMES)
    panels = Panels(result, recording, look, {"x": "y", "y": "y2"})
    most = max((of.loss_miss[rows] + of.loss_false[rows]).max() for _, of in result.sides)
    top = max(LEAST_TOP, float(np.ceil((most + 0.02) * 5) / 5))
    template = (
        "frame {frame}, {time_s:.2f} s<br>X loses {miss_x:.3f} to misses, {false_x:.3f} to false "
        "alarms<br>Y loses {miss_y:.3f} to misses, {false_y:.3f} to false alarms"
    )
    losses = {f"miss_{letter}": system.loss_miss for letter, system in result.sides}
    losses |= {f"false_{letter}": system.loss_false for letter, system in result.sides}
    step_s = result.dataset.frame_columns.step_s[rows]
    traces, lost = [], []
    axes = {"xaxis": panels.axis("time (s)", anchor="y2")}
    for letter, system in result.sides:
        traces += _loss_areas(panels, letter)
        traces.append(panels.clicks(letter, 0.5 * top, template, **losses))
        per_minute = number(lost_per_minute(system.similarity[rows], step_s), ".2f")
        lost.append(f"{letter.upper()} {per_minute}")
        axes["yaxis" if letter == "x" else "yaxis2"] = look.axis(
            f"lost by {letter.upper()} (0 = best)",
            domain=LOSS_PANELS[letter],
            anchor="x",
            range=[0, top],
            tickformat=".2~f",
            nticks=5,
        )
    figure = panels.draw(
        traces,
        "losses",
        "Similarity lost over time",
        subtitle=f"{count_text(rows.stop - rows.start, 'frame')}; lost similarity, seconds per "
        f"minute (0 is best): {', '.join(lost)}",
        height=LOSSES_PX,
        legend={"traceorder": "normal"},
        **axes,
    )
    for letter, system in result.sides:
        label = f" {letter.upper()}: {plain(system.name)}" if system.name else letter.upper()
        place = {"x": 0, "xref": "paper", "xanchor": "left", "y": LOSS_PANELS[letter][1]}
        place |= {"yref": "paper", "yanchor": "top"}
        write(figure, label, size=12, color=look.of(letter), **place)
    panels.draw_cursor(figure, cursor_row)
    return figure


def _loss_areas(panels: Panels, letter: str) -> list[go.Scatter]:
    """Draw misses filled and false alarms hatched on top of them."""
    system, colour = panels.result.system(letter), panels.look.of(letter)
    losses = system.loss_miss[panels.rows], system.loss_false[panels.rows]
    shown = keep_peaks(*losses)
    pattern = panels.look.hatching(letter, 5, 0.35)
    fills: Any = {"fillcolor": faded(colour, 0.55)}, {"fillpattern": pattern}
    return [
        still_line(
            **panels.place(letter, panels.time_s[shown], lost[shown]),
            name=f"{letter.upper()}, {kind}",
            stackgroup=letter,
            color=colour,
            width=1,
            showlegend=None,
            **fill,
        )
        for lost, kind, fill in zip(losses, ("misses", "false alarms"), fills, strict=True)
    ]
