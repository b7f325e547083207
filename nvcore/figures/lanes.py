"""Rows over time: lanes of the pedestrians in a recording, strips of all recordings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.subject import subjects
from nvcore.common.wording import count_text
from nvcore.comparison.compare import Result
from nvcore.figures.marks import click_markers, outlines, still_line
from nvcore.figures.over_time import LEAST_TOP, OverTime, frame_texts
from nvcore.figures.style import (
    EDGE_PX,
    LOOK,
    ChartLook,
    faded,
    plain,
    system_label,
    which_is_which,
)
from nvcore.tables.lanes import lanes_table
from nvcore.tables.loss_strip import LossStrip

MAX_LANES: Final = 200
"""Default number of encounters drawn."""
AROUND_PX: Final = 120
"""Height of title, legend and axis above the lanes, plus the room below them."""
ABOVE_PX: Final = 84
GAP_PX: Final = 12
"""Height of a strip above the lanes, and of the room between it and the lanes."""
MAX_CLICKS: Final = 1500
"""Maximum number of clickable places in all lanes, as the browser draws a marker for each."""
CLICKS_OF_LANE: Final = (20, 120)
MAX_BARS: Final = 3000
PIXELS: Final = 4000
"""Number of pixel columns to which bars are rounded if there are more than `MAX_BARS`."""
LANE_PX: Final = ((12, 30), (40, 20), (1_000_000, 13))
"""Height of a lane by the largest number of lanes that it is for."""
KINDS: Final = (
    ("not_relevant", "xy", "too far to count"),
    ("ignored", "xy", "ignored"),
    *((kind, of, f"{of.upper()} {kind}") for of in "xy" for kind in ("matched", "missed")),
)
"""State, systems and name of the bars that are drawn alike. Misses are drawn last."""
WORDS: Final = {"not_relevant": "too far to count", "": "not annotated"}
"""Words for the states that are not shown by their own name."""
BAR: Final = 0.38
"""Height of one bar; a lane is 1 high."""

STRIP_PX: Final = ((20, 22, 3), (1_000_000, 15, 2))
"""Height of a recording's strip for up to so many of them, and the gap between two."""
BAR_PX: Final = (80, 220)
"""Least and largest length of the colour bar."""
SCALE_PX: Final = 76
"""Width of the colour bar with its labels."""
MAX_STRIP_CLICKS: Final = 400
"""Maximum number of clickable places in all strips. The browser draws a marker for each."""


@dataclass(frozen=True)
class Strip:
    """A strip above the lanes: its part of the subtitle, its traces on ``y2``, and that axis."""

    words: str
    traces: Sequence[go.Scatter]
    axis: dict[str, Any]


@dataclass(frozen=True)
class Lanes:
    """Content that a subject adds to the lanes of a recording.

    Attributes
    ----------
    strip
        Function of the result, the recording's row and the look that returns the strip above the
        lanes, or None if there is nothing to show. Only one subject has room for it.
    marks
        Function of the result, the encounters of the lanes in order, the height of a mark in px and
        the look that returns marks in the lanes.
    note
        Function of the result and the rows of encounters and frames that returns a hover text for
        each frame, which may be empty.
    """

    strip: Callable[[Result, int, ChartLook], Strip | None]
    marks: Callable[[Result, np.ndarray, float, ChartLook], go.Scatter]
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
    """Draw one lane for each encounter of a recording over time, X's bar above Y's.

    The most severe failures are on top. Filled: matched. Hollow and hatched: missed. Pale: not
    near enough to count. A bar in a lane: the last chance to stop. Above the lanes stands the time
    to contact with the nearest pedestrian, if any is approached. Shaded: stretches with a code
    (`nvcore.settings.defaults.Settings.codes`). A click gives frame and encounter:
    `customdata` is the row in ``dataset.frames`` and that in ``result.encounters``.

    Parameters
    ----------
    recording, cursor_row
        As for `nvcore.figures.over_time.similarity_plot`.
    first, most
        First lane drawn, counted from 0, and maximum number of lanes.
    only_missed
        True to leave out pedestrians whom no system misses while they are near enough to count.
    chosen
        Row of ``result.encounters`` whose lane is marked; None: no lane.
    """
    look, runs, objects = LOOK[theme], lanes_table(result, recording), result.objects
    if runs.empty:
        return look.empty(f"This recording has no annotated {objects.singular}.")
    ordered = lane_order(result, recording, only_missed=only_missed)
    if not len(ordered):
        return look.empty(objects.say("{Nobody} near enough to count is missed here."))
    encounters = ordered[first : first + most]
    n_lanes = len(encounters)
    lane_of = np.full(len(result.encounters), -1)
    lane_of[encounters] = np.arange(n_lanes)
    runs = runs.assign(lane=lane_of[runs["encounter"]])
    runs = runs[runs["lane"] >= 0]
    lane_px = next(px for most, px in LANE_PX if n_lanes <= most)
    lanes_px = lane_px * n_lanes

    traces = [_bars(runs, *kind, look) for kind in KINDS]
    strip = None
    for added in _of_subjects():
        strip = added.strip(result, recording, look) or strip
        traces.append(added.marks(result, encounters, 0.6 * lane_px, look))
    traces = [trace for trace in traces if len(trace.x)]
    short = objects.say("{short}")
    labels = [
        f"{short} {plain(track, max_length=8)}" for track in result.encounters.track[encounters]
    ]
    lane = -1 if chosen is None else int(lane_of[chosen])
    if lane >= 0:
        labels[lane] = f"<b>▶ {labels[lane]}</b>"

    extent = count_text(len(ordered), objects.singular, objects.plural)
    extent += " with misses" * only_missed + ", most severe on top"
    if len(ordered) > n_lanes:
        extent += f", {first + 1} to {first + n_lanes} drawn"
    for bar, (letter, system) in zip(("; upper", ", lower"), result.sides, strict=True):
        extent += f"{bar} bar {system_label(letter, system.name)}"
    own_name = result.dataset.recordings["name"][recording]
    codes = [of for of in result.dataset.settings.codes if of.recording == own_name]
    # above the lanes, and as wide as that of the similarity over time
    over_time = OverTime(result, recording, look)
    time = over_time.axis(side="top", ticksuffix=" s")
    rows = look.rows_axis(labels, showgrid=False)
    axes, height = {"xaxis": time, "yaxis": rows}, AROUND_PX + lanes_px
    if strip:
        whole_px = lanes_px + GAP_PX + ABOVE_PX
        time["anchor"], rows["domain"] = "y2", [0, lanes_px / whole_px]
        axes["yaxis2"] = strip.axis | {"domain": [1 - ABOVE_PX / whole_px, 1]}
        extent, height = extent + strip.words, height + GAP_PX + ABOVE_PX
        traces += strip.traces
    figure = over_time.draw(
        [*traces, _lane_clicks(result, runs, n_lanes)],
        "lanes",
        "Who is missed when",
        subtitle=extent + "; shaded: stretches with a code" * bool(codes),
        height=height,
        margin={"t": AROUND_PX - EDGE_PX},
        **axes,
    )
    for of in codes:
        shade = {"line": {"width": 0}, "fillcolor": faded(look.ink, 0.1), "layer": "below"}
        label = {"text": plain(of.code), "textposition": "bottom left"}
        ends = {"x0": of.start_s, "x1": of.end_s, "yref": "y domain", "y0": 0, "y1": 1}
        figure.add_shape(type="rect", name="code", label=label, **shade, **ends)
    over_time.draw_cursor(figure, cursor_row)
    if lane >= 0:
        ends = {"y0": lane - 0.5, "y1": lane + 0.5, "xref": "paper", "x0": 0, "x1": 1}
        figure.add_shape(type="rect", name="chosen", line={"color": look.ink, "width": 1.5}, **ends)
    return figure


def lane_order(result: Result, recording: int, *, only_missed: bool = False) -> np.ndarray:
    """Return rows of ``result.encounters`` in a recording, the most severe failure first.

    The larger severity of X and Y counts. Ties are broken by the time missed, longest first, then
    by the first frame. `only_missed` is as in `lanes_figure`.
    """
    encounters = np.flatnonzero(result.encounters.recording == recording)
    severities = [system.failures["severity_s"].to_numpy() for _, system in result.sides]
    severity_s = np.nan_to_num(np.maximum(*severities)[encounters])
    runs = lanes_table(result, recording)
    missed = runs[runs["state"] == "missed"]
    length_s = (missed["stop_s"] - missed["start_s"]).groupby(missed["encounter"]).sum()
    missed_s = length_s.reindex(encounters, fill_value=0.0).to_numpy()
    keys = (-missed_s.round(6), -severity_s.round(6))  # equal ones differ in their last digits
    order = np.lexsort((result.encounters.first_row[encounters], *keys))
    ordered: np.ndarray = encounters[order]
    return ordered[missed_s[order] > 0] if only_missed else ordered


def _bars(runs: pd.DataFrame, state: str, letters: str, label: str, look: ChartLook) -> go.Scatter:
    """Draw all bars of one look as one path, which stays quick with thousands.

    More than `MAX_BARS` are widened to columns of pixels, and those that become the same are drawn
    once.
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
    path, looks = outlines(start, stop, top, top + BAR - 0.02), _paint(state, letters, look)
    return still_line(*path, label, showlegend=None, fill="toself", **looks)


def _paint(state: str, letters: str, look: ChartLook) -> dict[str, Any]:
    """Return the looks of bars: matched filled, missed hollow and hatched, others pale."""
    if state == "ignored":
        return {"fillcolor": look.pale, "width": 1, "color": look.muted}
    if state == "not_relevant":
        return {"fillcolor": faded(look.pale, 0.45), "width": 0}
    colour = look.of(letters)
    if state == "matched":
        return {"fillcolor": colour, "width": 0}
    return {"fillpattern": look.hatching(letters, 6, 0.18), "width": 1.2, "color": colour}


def _lane_clicks(result: Result, runs: pd.DataFrame, n_lanes: int) -> go.Scatter:
    """Return invisible markers along every lane that know their frame and both systems' states."""
    ends = runs.groupby("lane").agg({"first_row": "min", "last_row": "max", "encounter": "first"})
    spread = np.linspace(0, 1, int(np.clip(MAX_CLICKS // n_lanes, *CLICKS_OF_LANE)))
    first, last, encounter = ends.to_numpy().T
    rows = (first[:, None] + np.round(spread * (last - first)[:, None])).astype(np.int64)
    n_frames = len(result.dataset.frames)
    places = np.unique(np.arange(n_lanes)[:, None] * n_frames + rows)
    lane, row = np.divmod(places, n_frames)
    encounter = encounter[lane]
    texts = frame_texts(
        result,
        row,
        "{noun} {track}, frame {frame}, {time_s:.2f} s<br>X: {x}   Y: {y}",
        noun=result.objects.singular,
        track=result.encounters.track[encounter],
        **{letter: _state_at(runs, letter, lane, row) for letter in "xy"},
    )
    for added in _of_subjects():
        notes = added.note(result, encounter, row)
        texts = [
            f"{text}<br>{note}" if note else text for text, note in zip(texts, notes, strict=True)
        ]
    return click_markers(
        result.dataset.frames["time_s"].to_numpy()[row],
        lane.astype(float),
        texts,
        customdata=np.column_stack([row, encounter]),
        name="frames",
    )


def _of_subjects() -> list[Lanes]:
    return [lanes for subject in subjects() for lanes in subject.figures().lanes]


def _state_at(runs: pd.DataFrame, letter: str, lane: np.ndarray, row: np.ndarray) -> list[str]:
    """Return the state of one system in lanes at frame rows, in words."""
    part = runs[runs["system"] == letter].sort_values(["lane", "first_row"])
    n_rows = int(runs["last_row"].max()) + 2
    key = (part["lane"] * n_rows + part["first_row"]).to_numpy()
    run = np.searchsorted(key, lane * n_rows + row, side="right") - 1
    found = part.iloc[run]
    inside = (run >= 0) & (found["lane"] == lane) & (found["last_row"] >= row)
    return [WORDS.get(state, state) for state in found["state"].where(inside, "")]


def loss_strip_plot(result: Result, strip: LossStrip, *, theme: Theme) -> go.Figure:
    """Draw losses of every recording over time, the worst recording on top.

    The colour is the largest loss ``1 - M`` of either system in that bin of time. A click gives the
    frame in which it stands: `customdata` is its row in ``dataset.frames``.

    Parameters
    ----------
    strip
        `nvcore.tables.loss_strip.loss_strip` of the result.
    """
    look = LOOK[theme]
    n_strips, n_bins = strip.loss.shape
    if not n_strips:
        return look.empty("There is no evaluated frame.")
    strip_px, gap_px = next(px for most, *px in STRIP_PX if n_strips <= most)
    names = result.dataset.recordings["name"].to_numpy()[strip.recording]
    extent = count_text(strip.n_recordings, "recording")
    if strip.n_recordings > n_strips:
        extent += f", the {n_strips} in which most is lost drawn"
    if n_strips > 1:
        extent += ", most lost per minute on top"
    bar_px = float(np.clip(strip_px * n_strips, *BAR_PX))
    place: dict[str, Any] = {"nticks": 4, "y": 1, "yanchor": "top"}
    heat = go.Heatmap(
        x0=0.5 * strip.bin_s,
        dx=strip.bin_s,
        y=np.arange(n_strips),
        z=strip.loss.astype(np.float32),  # half the bytes
        zmin=0,
        zmax=max(LEAST_TOP, float(np.ceil(np.nanmax(strip.loss) * 5 - 1e-9) / 5)),
        colorscale=look.loss_scale,
        colorbar=look.colour_bar("loss", 12, side="top", lenmode="pixels", len=bar_px, **place),
        xgap=0,
        ygap=gap_px,
        hoverinfo="skip",
        hoverongaps=False,
        name="loss",
    )
    return look.draw(
        [heat, _strip_clicks(result, strip, [plain(name) for name in names])],
        title="Where to look first",
        subtitle=f"{extent}; colour: the worse system's largest loss "
        f"in each {strip.bin_s:.3g} s{which_is_which(theme)}",
        height=132 + strip_px * n_strips,
        margin={"r": SCALE_PX},
        hoverdistance=-1,
        showlegend=False,
        xaxis=look.axis("time (s)", can_zoom=True, range=[0, n_bins * strip.bin_s], showgrid=False),
        yaxis=look.rows_axis([plain(name, max_length=18) for name in names], showgrid=False),
    )


def _strip_clicks(result: Result, strip: LossStrip, names: list[str]) -> go.Scatter:
    """Return invisible markers at the worst bins, as Plotly reports no clicks in a heat map.

    Neighbouring bins share one where there are more than `MAX_STRIP_CLICKS`.
    """
    n_strips, n_bins = strip.loss.shape
    stride = max(1, -(-n_strips * n_bins // MAX_STRIP_CLICKS))
    loss = np.pad(np.nan_to_num(strip.loss, nan=-1.0), ((0, 0), (0, -n_bins % stride)),
                  constant_values=-1.0).reshape(n_strips, -1, stride)  # fmt: skip
    place, group = np.nonzero(loss.max(axis=2) >= 0)
    bins = group * stride + loss.argmax(axis=2)[place, group]
    rows = strip.row[place, bins]
    texts = frame_texts(
        result,
        rows,
        "{name}, frame {frame}, {time_s:.2f} s<br>similarity X {x:.2f}   Y {y:.2f}",
        name=[names[strip] for strip in place],
        x=result.x.similarity[rows],
        y=result.y.similarity[rows],
    )
    middle_s = (bins + 0.5) * strip.bin_s
    return click_markers(middle_s, place.astype(float), texts, customdata=rows, name="frames")
