"""What each frame of one recording loses to misses and to false alarms, for both systems."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import click_markers, line_up, still_line
from nvcore.figures.over_time.similarity import (
    MAX_CLICKS,
    MAX_POINTS,
    end_of,
    evenly,
    time_range,
)
from nvcore.figures.style import LEFT_PX, LOOK, axis, draw, empty_figure, faded, plain, write
from nvcore.metrics.losses import lost_per_minute
from nvcore.palette import Theme
from nvcore.scoring import SystemResult
from nvcore.wording import count_text, number

HEIGHT_PX: Final = 440
PANELS: Final = {"x": (0.53, 1.0), "y": (0.0, 0.47)}
"""Lower and upper end of each system's panel, as shares of the plot's height."""
LEAST_TOP: Final = 0.2
"""Least upper end of the axes, so that trifles look small."""


def keep_peaks(*series: np.ndarray, n_points: int = MAX_POINTS) -> np.ndarray:
    """Rows that draw several series of one length together; sorted int64, at most `n_points`.

    The rows are cut into stretches of one length. Of each stretch the largest value of every
    series is kept, so that no short loss disappears, and the smallest sum, so that no pause does;
    the first and the last row are always kept.
    """
    n = len(series[0])
    if n <= n_points:
        return np.arange(n)
    n_stretches = (n_points - 2) // (len(series) + 1)
    starts = np.linspace(0, n, n_stretches, endpoint=False).astype(np.int64)
    rows = [_largest_of_each(values, starts) for values in (*series, -np.sum(series, axis=0))]
    return np.unique(np.concatenate([[0, n - 1], *rows]))


def _largest_of_each(values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Row of the largest value of each stretch, the first of equals."""
    largest = np.maximum.reduceat(values, starts)
    lengths = np.diff(np.append(starts, len(values)))
    hits = np.flatnonzero(values == np.repeat(largest, lengths))
    rows: np.ndarray = hits[np.searchsorted(hits, starts)]
    return rows


def loss_plot(
    result: Result, recording: int, *, theme: Theme, cursor_row: int | None = None
) -> go.Figure:
    """Similarity that each frame loses to misses and, stacked on it, to false alarms; 0 is best.

    The height of both areas together is 1 - similarity. X stands above Y, on one scale. A click
    gives the frame: `customdata` is its row in ``dataset.frames``.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    cursor_row
        Row in ``dataset.frames`` of the frame that is shown; None: no cursor.

    References
    ----------
    Paper 11-0360, equation 2; ``docs/metrics.md``, similarity.
    """
    rows = result.dataset.frame_columns.rows_of(recording)
    if rows.start == rows.stop:
        return empty_figure("This recording has no frames.", theme=theme)
    time_s = result.dataset.frames["time_s"].to_numpy()[rows]
    losses = {
        letter: (system.loss_miss[rows], system.loss_false[rows]) for letter, system in result.sides
    }
    most = max(float(np.add(*of_system).max()) for of_system in losses.values())
    top = max(LEAST_TOP, float(np.ceil((most + 0.02) * 5) / 5))
    traces: list[Any] = []
    for letter, _ in result.sides:
        traces += _areas(letter, time_s, *losses[letter], theme)
        traces.append(_clicks(result, letter, rows, losses, 0.5 * top))
    name = plain(result.dataset.recordings["name"][recording])
    figure = draw(
        traces,
        theme,
        title=f"Similarity lost over time, {name}",
        subtitle=_subtitle(result, rows),
        height=HEIGHT_PX,
        hoverdistance=-1,
        margin={"l": LEFT_PX},
        legend={"traceorder": "normal"},
        uirevision=f"{result.dataset.fingerprint} {recording} losses",
        **_axes(result.sides, end_of(result, recording), top, theme),
    )
    for letter, system in result.sides:
        place = {"x": 0, "xref": "paper", "xanchor": "left", "y": PANELS[letter][1]}
        label = f" {letter.upper()}: {plain(system.name)}" if system.name else letter.upper()
        colour = LOOK[theme].of(letter)
        write(figure, label, size=12, color=colour, yref="paper", yanchor="top", **place)
    if cursor_row is not None and rows.start <= cursor_row < rows.stop:
        line_up(figure, float(time_s[cursor_row - rows.start]), "cursor", theme)
    return figure


def _areas(
    letter: str, time_s: np.ndarray, of_misses: np.ndarray, of_alarms: np.ndarray, theme: Theme
) -> list[go.Scatter]:
    """Misses filled, false alarms hatched on top of them."""
    colour = LOOK[theme].of(letter)
    shown = keep_peaks(of_misses, of_alarms)
    thin = {"width": 1, "color": colour}
    hatched = {"shape": "/", "size": 5, "solidity": 0.35, "fillmode": "replace"}
    hatched |= {"fgcolor": colour, "bgcolor": faded(colour, 0.08)}
    common = {"x": time_s[shown], "xaxis": "x", "yaxis": "y" if letter == "x" else "y2"}
    misses = still_line(
        **common,
        y=of_misses[shown],
        name=f"{letter.upper()}, misses",
        stackgroup=letter,
        fillcolor=faded(colour, 0.55),
        line=thin,
        showlegend=None,
    )
    alarms = still_line(
        **common,
        y=of_alarms[shown],
        name=f"{letter.upper()}, false alarms",
        stackgroup=letter,
        fillpattern=hatched,
        line=thin,
        showlegend=None,
    )
    return [misses, alarms]


def _clicks(
    result: Result,
    letter: str,
    rows: slice,
    losses: dict[str, tuple[np.ndarray, np.ndarray]],
    middle: float,
) -> go.Scatter:
    """A line of invisible markers: the one nearest to a click is the frame at that time."""
    inside = evenly(rows.stop - rows.start, n_points=MAX_CLICKS)
    frames = result.dataset.frames
    columns = (frames["frame"].to_numpy()[rows], frames["time_s"].to_numpy()[rows])
    frame_numbers, time_s = (column[inside] for column in columns)
    parts = [of_system[inside] for of_both in losses.values() for of_system in of_both]
    text = [
        f"frame {frame}, {second:.2f} s<br>X loses {miss_x:.3f} to misses, {false_x:.3f} to false "
        f"alarms<br>Y loses {miss_y:.3f} to misses, {false_y:.3f} to false alarms"
        for frame, second, miss_x, false_x, miss_y, false_y in zip(
            frame_numbers, time_s, *parts, strict=True
        )
    ]
    place = {"x": time_s, "y": np.full(len(inside), middle), "xaxis": "x"}
    place["yaxis"] = "y" if letter == "x" else "y2"
    return click_markers(**place, texts=text, customdata=rows.start + inside, name="frames")


def _subtitle(result: Result, rows: slice) -> str:
    step_s = result.dataset.frame_columns.step_s[rows]
    lost = ", ".join(
        f"{letter.upper()} {number(lost_per_minute(system.similarity[rows], step_s), '.2f')}"
        for letter, system in result.sides
    )
    n_frames = count_text(rows.stop - rows.start, "frame")
    return f"{n_frames}; lost similarity, seconds per minute (0 is best): {lost}"


def _axes(
    sides: tuple[tuple[str, SystemResult], ...], end_s: float, top: float, theme: Theme
) -> dict[str, Any]:
    time = axis(theme, "time (s)", range=time_range(end_s), anchor="y2")
    axes: dict[str, Any] = {"xaxis": time}
    for (letter, _), key in zip(sides, ("yaxis", "yaxis2"), strict=True):
        form = {"range": [0, top], "fixedrange": True, "tickformat": ".2~f", "nticks": 5}
        title = f"lost by {letter.upper()} (0 = best)"
        axes[key] = axis(theme, title, domain=list(PANELS[letter]), anchor="x", **form)
    return axes
