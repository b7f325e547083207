"""State lanes: when each pedestrian of a recording was matched or missed by X and by Y."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import click_markers, line_up, still_line, with_gaps
from nvcore.figures.over_time.similarity import end_of, time_range
from nvcore.figures.style import (
    EDGE_PX,
    LEFT_PX,
    LOOK,
    ChartLook,
    axis,
    draw,
    empty_figure,
    faded,
    plain,
    rows_axis,
    system_label,
)
from nvcore.palette import Theme
from nvcore.subjects import contributed
from nvcore.tables.lanes import lanes_table
from nvcore.wording import count_text

MAX_LANES: Final = 200
"""Encounters drawn, if not fewer are asked for."""
AROUND_PX: Final = 120
"""Height of title, legend and axis, which is above the lanes, and of what is below them."""
MAX_CLICKS: Final = 1500
"""Places that can be clicked, over all lanes; the browser draws a marker for each."""
MIN_CLICKS_LANE: Final = 20
MAX_CLICKS_LANE: Final = 120
MAX_BARS: Final = 3000
PIXELS: Final = 4000
"""Columns of pixels to which bars are rounded when there are more than that."""
LANE_PX: Final = ((12, 30), (40, 20), (MAX_LANES, 13))
"""Height of a lane for up to so many of them."""
WORDS: Final = {"not_relevant": "too far to count", "": "not annotated"}
"""States that are not called by their own word."""
BAR: Final = 0.38
"""Height of one bar; a lane is 1 high."""


@dataclass(frozen=True)
class Strip:
    """A strip above the lanes; empty where there is nothing to show.

    Attributes
    ----------
    height_px, words
        Height that it adds, and what the subtitle says of it.
    traces
        On the axis ``y2``.
    xaxis, yaxis, more
        Settings of the axes of the lanes, and of the layout.
    """

    height_px: int = 0
    words: str = ""
    traces: tuple[go.Scatter, ...] = ()
    xaxis: dict[str, Any] = field(default_factory=dict)
    yaxis: dict[str, Any] = field(default_factory=dict)
    more: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Lanes:
    """What a subject adds to the lanes of a recording.

    Attributes
    ----------
    strip
        What stands above the lanes, of the result, the recording's row, the height of the lanes in
        px, and the theme. Only one subject has room for it.
    marks
        Marks in the lanes, of the result, the encounters of the lanes in order, the height of a
        mark in px, and the theme.
    note
        What the hover text of frames says: of the result and the rows of encounters and frames, a
        text each, empty where there is nothing to say.
    """

    strip: Callable[[Result, int, int, Theme], Strip]
    marks: Callable[[Result, np.ndarray, float, Theme], go.Scatter]
    note: Callable[[Result, np.ndarray, np.ndarray], Sequence[str]]


def lanes_figure(
    result: Result,
    recording: int,
    *,
    theme: Theme,
    cursor_row: int | None = None,
    first: int = 0,
    most: int = MAX_LANES,
    only_missed: bool = False,
    chosen: int | None = None,
) -> go.Figure:
    """One lane for each encounter of a recording, X's bar above Y's, over time.

    The most severe failures are on top. Filled: matched. Hollow and hatched: missed. Pale: not
    near enough to count. A bar in a lane: the last chance to stop. Above the lanes stands the time
    to contact of who is nearest, where anybody is approached. Shaded: stretches with a code
    (`nvcore.settings.Settings.codes`). A click gives frame and encounter:
    `customdata` is the row in ``dataset.frames`` and that in ``result.encounters``.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    cursor_row
        Row in ``dataset.frames`` of the frame that is shown; None: no cursor.
    first, most
        Lanes drawn: so many, from this one on, counted from 0.
    only_missed
        Leave out whom nobody misses while near enough to count.
    chosen
        Row of ``result.encounters`` whose lane is marked; None: no lane.
    """
    runs = lanes_table(result, recording)
    if runs.empty:
        text = f"This recording has no annotated {result.objects.singular}."
        return empty_figure(text, theme=theme)
    ordered = lane_order(result, recording, only_missed=only_missed)
    if not len(ordered):
        text = result.objects.say("{Nobody} near enough to count is missed here.")
        return empty_figure(text, theme=theme)
    encounters = ordered[first : first + most]
    lane_of = np.full(len(result.encounters), -1)
    lane_of[encounters] = np.arange(len(encounters))
    runs = runs.assign(lane=lane_of[runs["encounter"].to_numpy()])
    runs = runs[runs["lane"].to_numpy() >= 0]
    kinds = [("not_relevant", "xy", "too far to count"), ("ignored", "xy", "ignored")]
    kinds += [
        (state, letter, f"{letter.upper()} {state}")
        for letter in "xy"
        for state in ("matched", "missed")
    ]
    traces = [_bars(runs, *kind, theme) for kind in kinds]
    extent = count_text(len(ordered), result.objects.singular, result.objects.plural)
    if only_missed:
        extent += " with misses"
    extent += ", most severe on top"
    if len(ordered) > len(encounters):
        extent += f", {first + 1} to {first + len(encounters)} drawn"
    own_name = result.dataset.recordings["name"][recording]
    n_lanes = len(encounters)
    lane_px = next(px for most, px in LANE_PX if n_lanes <= most)
    rows = result.dataset.frame_columns.rows_of(recording)
    time_s = result.dataset.frames["time_s"].to_numpy()
    tracks = result.encounters.track[encounters]
    short = result.objects.say("{short}")
    pedestrians = [f"{short} {plain(track, max_length=8)}" for track in tracks]
    chosen_lane = -1 if chosen is None else int(lane_of[chosen])
    if chosen_lane >= 0:
        pedestrians[chosen_lane] = f"<b>▶ {pedestrians[chosen_lane]}</b>"
    labels = [system_label(letter, system.name) for letter, system in result.sides]
    lanes_px = lane_px * n_lanes
    strip = Strip()
    for added in contributed("lanes"):
        strip = added.strip(result, recording, lanes_px, theme)
        traces.append(added.marks(result, encounters, 0.6 * lane_px, theme))
    codes = [of for of in result.dataset.settings.codes if of.recording == own_name]
    along = axis(theme, side="top", ticksuffix=" s", range=time_range(end_of(result, recording)))
    figure = draw(
        [
            *(trace for trace in traces if len(trace.x)),
            *strip.traces,
            _clicks(result, runs, n_lanes),
        ],
        theme,
        title=f"Who is missed when, {plain(own_name)}",
        subtitle=f"{extent}; upper bar {labels[0]}, lower bar {labels[1]}{strip.words}"
        + ("; shaded: stretches with a code" if codes else ""),
        height=AROUND_PX + lanes_px + strip.height_px,
        hoverdistance=-1,
        margin={"l": LEFT_PX, "t": AROUND_PX - EDGE_PX},
        # above the lanes, and as wide as that of the similarity over time
        xaxis=along | strip.xaxis,
        yaxis=rows_axis(theme, pedestrians, fixedrange=True, showgrid=False) | strip.yaxis,
        uirevision=f"{result.dataset.fingerprint} {recording} lanes",
        **strip.more,
    )
    for of in codes:
        shade = {"line": {"width": 0}, "fillcolor": faded(LOOK[theme].ink, 0.1), "layer": "below"}
        label = {"text": plain(of.code), "textposition": "bottom left"}
        ends = {"x0": of.start_s, "x1": of.end_s, "yref": "y domain", "y0": 0, "y1": 1}
        figure.add_shape(type="rect", name="code", label=label, **shade, **ends)
    if cursor_row is not None and rows.start <= cursor_row < rows.stop:
        line_up(figure, float(time_s[cursor_row]), "cursor", theme)
    if chosen_lane >= 0:
        ends = {"y0": chosen_lane - 0.5, "y1": chosen_lane + 0.5, "xref": "paper", "x0": 0, "x1": 1}
        line = {"color": LOOK[theme].ink, "width": 1.5}
        figure.add_shape(type="rect", name="chosen", line=line, **ends)
    return figure


def lane_order(result: Result, recording: int, *, only_missed: bool = False) -> np.ndarray:
    """Encounters of a recording, as rows of ``result.encounters``, the most severe failure first.

    That is the larger severity of X and Y; of equals the one whom they miss longer, then the one
    who comes first.

    Parameters
    ----------
    only_missed
        Leave out whom nobody misses while near enough to count.
    """
    encounters = np.flatnonzero(result.encounters.recording == recording)
    severities = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    severity_s = np.nan_to_num(np.maximum(*severities)[encounters])
    runs = lanes_table(result, recording)
    length_s = (runs["stop_s"] - runs["start_s"]).to_numpy() * (runs["state"] == "missed")
    missed_s = np.bincount(
        runs["encounter"].to_numpy(), weights=length_s, minlength=len(result.encounters)
    )[encounters]
    keys = (-missed_s.round(6), -severity_s.round(6))  # equal ones differ in their last digits
    order = np.lexsort((result.encounters.first_row[encounters], *keys))
    ordered: np.ndarray = encounters[order]
    return ordered[missed_s[order] > 0] if only_missed else ordered


def _bars(runs: pd.DataFrame, state: str, letters: str, label: str, theme: Theme) -> go.Scatter:
    """All bars of one look as one path: five corners each, which stays quick with thousands.

    More than `MAX_BARS` are widened to columns of pixels, and those that become the same are drawn
    once; misses are drawn last and stay visible.
    """
    part = runs[(runs["state"] == state) & runs["system"].isin(list(letters))]
    start, stop = part["start_s"].to_numpy(), part["stop_s"].to_numpy()
    lane, is_x = part["lane"].to_numpy(), part["system"].to_numpy() == "x"
    if len(part) > MAX_BARS:
        pixel_s = float(runs["stop_s"].max()) / PIXELS
        start, stop = np.floor(start / pixel_s) * pixel_s, np.ceil(stop / pixel_s) * pixel_s
        distinct = np.unique(np.column_stack([lane, is_x, start, stop]), axis=0)
        lane, is_x, start, stop = distinct.T
    top = lane + np.where(is_x > 0, -BAR, 0.02)
    low = top + BAR - 0.02
    outline = still_line(
        with_gaps(start, stop, stop, start, start),
        with_gaps(top, top, low, low, top),
        label,
        showlegend=None,
        fill="toself",
    )
    return outline.update(_paint(state, letters, LOOK[theme]))


def _paint(state: str, letters: str, look: ChartLook) -> dict[str, Any]:
    """Filled: matched. Hollow and hatched: missed. Pale: neither."""
    if state == "ignored":
        return {"fillcolor": look.pale, "line": {"width": 1, "color": look.muted}}
    if state == "not_relevant":
        return {"fillcolor": faded(look.pale, 0.45), "line": {"width": 0}}
    colour = look.of(letters)
    if state == "matched":
        return {"fillcolor": colour, "line": {"width": 0}}
    pattern = {"shape": "/", "fgcolor": colour, "bgcolor": faded(colour, 0.08)}
    return {
        "fillpattern": {**pattern, "fillmode": "replace", "size": 6, "solidity": 0.18},
        "line": {"width": 1.2, "color": colour},
    }


def _clicks(result: Result, runs: pd.DataFrame, n_lanes: int) -> go.Scatter:
    """Invisible markers along every lane; each knows its frame and what both systems did there."""
    n_clicks = min(max(MAX_CLICKS // n_lanes, MIN_CLICKS_LANE), MAX_CLICKS_LANE)
    ends = runs.groupby("lane").agg(
        first=("first_row", "min"), last=("last_row", "max"), encounter=("encounter", "first")
    )
    spread = np.linspace(0, 1, n_clicks)
    first, last = ends["first"].to_numpy()[:, None], ends["last"].to_numpy()[:, None]
    rows = (first + np.round(spread * (last - first))).astype(np.int64)
    lane = np.repeat(ends.index.to_numpy(), rows.shape[1])
    n_frames = len(result.dataset.frames)
    lane, row = np.divmod(np.unique(lane * n_frames + rows.ravel()), n_frames)
    state = {letter: _state_at(runs, letter, lane, row) for letter in "xy"}
    time_s = result.dataset.frames["time_s"].to_numpy()[row]
    frame = result.dataset.frames["frame"].to_numpy()[row]
    track, noun = (
        result.encounters.track[ends["encounter"].to_numpy()[lane]],
        result.objects.singular,
    )
    text = [
        f"{noun} {track_id}, frame {number}, {second:.2f} s<br>X: {by_x}   Y: {by_y}"
        for track_id, number, second, by_x, by_y in zip(
            track, frame, time_s, state["x"], state["y"], strict=True
        )
    ]
    encounter = ends["encounter"].to_numpy()[lane]
    for added in contributed("lanes"):
        notes = added.note(result, encounter, row)
        text = [
            f"{line}<br>{note}" if note else line for line, note in zip(text, notes, strict=True)
        ]
    places = np.column_stack([row, encounter])
    return click_markers(time_s, lane.astype(float), text, customdata=places, name="frames")


def _state_at(runs: pd.DataFrame, letter: str, lane: np.ndarray, row: np.ndarray) -> list[str]:
    """State of one system in a lane at a frame row, in words."""
    part = runs[runs["system"] == letter].sort_values(["lane", "first_row"])
    n_rows = int(runs["last_row"].max()) + 2
    key = part["lane"].to_numpy() * n_rows + part["first_row"].to_numpy()
    run = np.searchsorted(key, lane * n_rows + row, side="right") - 1
    inside = (run >= 0) & (part["lane"].to_numpy()[run] == lane)
    inside &= part["last_row"].to_numpy()[run] >= row
    states = np.where(inside, part["state"].to_numpy(dtype=object)[run], "")
    return [WORDS.get(state, state) for state in states]
