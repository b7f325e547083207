"""State lanes: when each pedestrian of a recording was matched or missed by X and by Y."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.style import (
    LOOK,
    axis,
    click_markers,
    empty_figure,
    faded,
    layout,
    plain,
    system_label,
)
from nvcore.palette import Theme
from nvcore.tables.lanes import lanes_table
from nvcore.wording import count_text

MAX_LANES: Final = 200
"""Encounters drawn: those that are missed longest."""
MAX_CLICKS: Final = 1500
"""Places that can be clicked, over all lanes; the browser draws a marker for each."""
MIN_CLICKS_LANE: Final = 20
MAX_CLICKS_LANE: Final = 120
MAX_BARS: Final = 3000
PIXELS: Final = 4000
"""Columns of pixels that are told apart when there are more bars than that."""
LANE_PX: Final = ((12, 30), (40, 20), (MAX_LANES, 13))
"""Height of a lane for up to so many of them."""
WORDS: Final = {"not_relevant": "too far to count", "": "not annotated"}
"""States that are not called by their own word."""
BAR: Final = 0.38
"""Height of one bar; a lane is 1 high."""


def lanes_figure(
    result: Result, recording: int, *, theme: Theme, cursor_row: int | None = None
) -> go.Figure:
    """One lane for each encounter of a recording, X's bar above Y's, over time.

    Filled: matched. Hollow and hatched: missed. Pale: not near enough to count. A click gives the
    frame: `customdata` is its row in ``dataset.frames``.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    cursor_row
        Row in ``dataset.frames`` of the frame that is shown; None: no cursor.
    """
    runs = lanes_table(result, recording)
    if runs.empty:
        return empty_figure("This recording has no annotated pedestrian.", theme=theme)
    n_all = runs["encounter"].nunique()
    encounters = _most_missed(runs)
    lane_of = np.full(len(result.encounters), -1)
    lane_of[encounters] = np.arange(len(encounters))
    runs = runs.assign(lane=lane_of[runs["encounter"].to_numpy()])
    runs = runs[runs["lane"].to_numpy() >= 0]
    traces = [
        _bars(runs, ("not_relevant",), "xy", "too far to count", theme),
        _bars(runs, ("ignored",), "xy", "ignored", theme),
    ]
    for letter in "xy":
        for state in ("matched", "missed"):
            traces.append(_bars(runs, (state,), letter, f"{letter.upper()} {state}", theme))
    traces = [trace for trace in traces if len(trace.x)]
    said = count_text(n_all, "pedestrian")
    if n_all > len(encounters):
        said += f", the {len(encounters)} that are missed longest drawn"
    name = plain(result.dataset.recordings["name"][recording])
    n_lanes = len(encounters)
    lane_px = next(px for most, px in LANE_PX if n_lanes <= most)
    start, stop = result.dataset.frame_columns.first[recording : recording + 2]
    time_s = result.dataset.frames["time_s"].to_numpy()
    end = float(time_s[stop - 1] + result.dataset.frames["step_s"].to_numpy()[stop - 1])
    tracks = result.encounters.track[encounters]
    labels = [system_label(letter, system.name) for letter, system in result.sides]
    figure = go.Figure(
        [*traces, _clicks(result, runs, n_lanes)],
        layout(
            theme,
            title=f"Who is missed when, {name}",
            subtitle=f"{said}; upper bar {labels[0]}, lower bar {labels[1]}",
            height=140 + lane_px * n_lanes,
            hoverdistance=-1,
            xaxis=axis(theme, "time (s)", range=[-0.005 * end, end * 1.005 or 1.0]),
            yaxis=axis(
                theme, range=[n_lanes - 0.4, -0.6], fixedrange=True, showgrid=False,
                tickvals=np.arange(n_lanes),
                ticktext=[f"ped {plain(track, max_length=8)}" for track in tracks],
            ),
            uirevision=f"{result.dataset.fingerprint} {recording} lanes",
        ),
    )  # fmt: skip
    if cursor_row is not None and start <= cursor_row < stop:
        at = float(time_s[cursor_row])
        figure.add_shape(
            type="line", name="cursor", x0=at, x1=at, yref="paper", y0=0, y1=1,
            line={"color": LOOK[theme].ink, "width": 1.5},
        )  # fmt: skip
    return figure


def _most_missed(runs: pd.DataFrame) -> np.ndarray:
    """The encounters to draw, by their first frame; all of them unless there are too many."""
    encounter, code = np.unique(runs["encounter"].to_numpy(), return_inverse=True)
    length_s = (runs["stop_s"] - runs["start_s"]).to_numpy() * (runs["state"] == "missed")
    missed_s = np.bincount(code, weights=length_s)
    first_row = np.full(len(encounter), np.iinfo(np.int64).max)
    np.minimum.at(first_row, code, runs["first_row"].to_numpy())
    chosen = np.sort(np.argsort(-missed_s, kind="stable")[:MAX_LANES])
    ordered: np.ndarray = encounter[chosen[np.argsort(first_row[chosen], kind="stable")]]
    return ordered


def _bars(
    runs: pd.DataFrame, states: tuple[str, ...], letters: str, label: str, theme: Theme
) -> go.Scatter:
    """All bars of one look as one path: five corners each, which stays quick with thousands.

    More than `MAX_BARS` are widened to columns of pixels, and those that become the same are drawn
    once; misses are drawn last and stay visible.
    """
    part = runs[runs["state"].isin(states) & runs["system"].isin(list(letters))]
    start, stop = part["start_s"].to_numpy(), part["stop_s"].to_numpy()
    lane, is_x = part["lane"].to_numpy(), part["system"].to_numpy() == "x"
    if len(part) > MAX_BARS:
        pixel_s = float(runs["stop_s"].max()) / PIXELS
        start, stop = np.floor(start / pixel_s) * pixel_s, np.ceil(stop / pixel_s) * pixel_s
        distinct = np.unique(np.column_stack([lane, is_x, start, stop]), axis=0)
        lane, is_x, start, stop = distinct.T
    top = lane + np.where(is_x > 0, -BAR, 0.02)
    low = top + BAR - 0.02
    nan = np.full(len(start), np.nan)
    look = LOOK[theme]
    paint: dict[str, Any]
    if states == ("matched",):
        paint = {"fillcolor": look.of(letters), "line": {"width": 0}}
    elif states == ("missed",):
        colour = look.of(letters)
        paint = {
            "fillpattern": {"shape": "/", "fgcolor": colour, "bgcolor": faded(colour, 0.08),
                            "fillmode": "replace", "size": 6, "solidity": 0.18},
            "line": {"width": 1.2, "color": colour},
        }  # fmt: skip
    elif states == ("ignored",):
        paint = {"fillcolor": look.pale, "line": {"width": 1, "color": look.muted}}
    else:
        paint = {"fillcolor": faded(look.pale, 0.45), "line": {"width": 0}}
    return go.Scatter(
        x=np.column_stack([start, stop, stop, start, start, nan]).ravel(),
        y=np.column_stack([top, top, low, low, top, nan]).ravel(),
        mode="lines", fill="toself", hoverinfo="skip", name=label, **paint,
    )  # fmt: skip


def _clicks(result: Result, runs: pd.DataFrame, n_lanes: int) -> go.Scatter:
    """Invisible markers along every lane; each knows its frame and what both systems did there."""
    each = min(max(MAX_CLICKS // n_lanes, MIN_CLICKS_LANE), MAX_CLICKS_LANE)
    ends = runs.groupby("lane").agg(
        first=("first_row", "min"), last=("last_row", "max"), encounter=("encounter", "first")
    )
    spread = np.linspace(0, 1, each)
    first, last = ends["first"].to_numpy()[:, None], ends["last"].to_numpy()[:, None]
    rows = (first + np.round(spread * (last - first))).astype(np.int64)
    lane = np.repeat(ends.index.to_numpy(), rows.shape[1])
    n_frames = len(result.dataset.frames)
    lane, row = np.divmod(np.unique(lane * n_frames + rows.ravel()), n_frames)
    state = {letter: _state_at(runs, letter, lane, row) for letter in "xy"}
    time_s = result.dataset.frames["time_s"].to_numpy()[row]
    frame = result.dataset.frames["frame"].to_numpy()[row]
    track = result.encounters.track[ends["encounter"].to_numpy()[lane]]
    text = [
        f"pedestrian {one}, frame {number}, {second:.2f} s<br>X: {by_x}   Y: {by_y}"
        for one, number, second, by_x, by_y in zip(
            track, frame, time_s, state["x"], state["y"], strict=True
        )
    ]
    return click_markers(
        x=time_s, y=lane.astype(float), customdata=row, text=text,
        hovertemplate="%{text}<extra></extra>", name="frames",
    )  # fmt: skip


def _state_at(runs: pd.DataFrame, letter: str, lane: np.ndarray, row: np.ndarray) -> list[str]:
    """State of one system in a lane at a frame row, in words."""
    part = runs[runs["system"] == letter].sort_values(["lane", "first_row"])
    n_rows = int(runs["last_row"].max()) + 2
    key = part["lane"].to_numpy() * n_rows + part["first_row"].to_numpy()
    at = np.searchsorted(key, lane * n_rows + row, side="right") - 1
    inside = (at >= 0) & (part["lane"].to_numpy()[at] == lane)
    inside &= part["last_row"].to_numpy()[at] >= row
    states = np.where(inside, part["state"].to_numpy(dtype=object)[at], "")
    return [WORDS.get(state, state) for state in states]
