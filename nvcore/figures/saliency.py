"""Saliency: the events on the recency curve, and what makes up a number."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import marks, steady_marker, still_line
from nvcore.figures.style import (
    LOOK,
    SYMBOL,
    axis,
    draw,
    empty_figure,
    faded,
    plain,
    rows_axis,
    system_label,
)
from nvcore.metrics.saliency import recency_weight
from nvcore.palette import Theme
from nvcore.wording import count_text

MAX_EVENTS: Final = 1000
"""Events of each system on the curve, the most salient first."""
N_PARTS: Final = 6
"""Events of each system that are taken apart."""
CURVE_POINTS: Final = 201
SHIFT: Final = 0.03
"""How far from the curve the marks of X and Y stand apart from each other."""
NO_EVENTS: Final = "No saliency events: no pedestrian is missed by more than the tolerance."


def _events(result: Result, letter: str, recording: int | None, most: int) -> pd.DataFrame:
    """Events of one system, the most salient first, with a text for each."""
    system = result.system(letter)
    events = system.events
    if recording is not None:
        events = events[events["recording"].to_numpy() == recording]
    events = events.sort_values("saliency_s", ascending=False, kind="stable").head(most)
    names = result.dataset.recordings["name"].to_numpy()[events["recording"].to_numpy()]
    start_s = result.dataset.frames["time_s"].to_numpy()[events["first_row"].to_numpy()]
    text = [
        f"{letter.upper()} misses pedestrian {track}<br>{plain(name)} at {start:.2f} s<br>"
        f"{weight:.2f} s × recency {recency:.2f} = {saliency:.2f} s"
        for name, track, start, weight, recency, saliency in zip(
            names,
            events["track"],
            start_s,
            events["weight_s"],
            events["recency"],
            events["saliency_s"],
            strict=True,
        )
    ]
    return events.assign(text=text, name=names, start_s=start_s)


def recency_plot(result: Result, *, theme: Theme, recording: int | None = None) -> go.Figure:
    """The recency curve with every event on it; larger marks last longer.

    `customdata` is the row in ``dataset.frames`` of the event's first frame.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``; None: all of them.
    """
    params, look = result.params, LOOK[theme]
    in_seconds = params.recency_unit == "seconds"
    column = "rest_s" if in_seconds else "tau"
    reach = _reach_s(result, recording) if in_seconds else 1.0
    place = np.linspace(0, reach, CURVE_POINTS)
    scope = "encounter" if params.saliency_scope == "encounter" else "recording"
    line = {"color": look.muted, "width": 1.5}
    traces = [still_line(place, recency_weight(place, place, params), "recency", line=line)]
    counts = []
    for letter, system in result.sides:
        events = _events(result, letter, recording, MAX_EVENTS)
        counts.append(f"{letter.upper()} {count_text(len(events), 'event')}")
        area = events["duration_s"].to_numpy()
        # X's marks stand above the curve and Y's below: many events of both end at one time
        shift = SHIFT if letter == "x" else -SHIFT
        marker = steady_marker(
            color=faded(look.of(letter), 0.35),
            symbol=SYMBOL[letter],
            size=5 + 15 * np.sqrt(area / max(area.max(initial=0), 1e-9)),
            line={"width": 1.2, "color": look.of(letter)},
        )
        traces.append(
            marks(
                events[column].to_numpy(),
                events["recency"].to_numpy() + shift,
                events["text"].tolist(),
                customdata=events["first_row"].to_numpy(),
                name=system_label(letter, system.name),
                **marker,
            )
        )
    if in_seconds:
        quantity = f"time from the end of the event to the end of its {scope} (s)"
        along = axis(theme, quantity, range=[1.02 * reach, -0.03 * reach], fixedrange=True)
    else:
        quantity = f"end of the event in its {scope} (share of the duration)"
        along = axis(theme, quantity, tickformat=".0%", range=[-0.02, 1.03], fixedrange=True)
    return draw(
        traces,
        theme,
        title="When misses happen, and how much they count",
        subtitle=f"{', '.join(counts)}; larger marks last longer; X drawn just above the curve, "
        "Y just below",
        height=360,
        xaxis=along,
        yaxis=axis(theme, "recency (weight, 0 to 1)", range=[-0.06, 1.08], fixedrange=True),
    )


def _reach_s(result: Result, recording: int | None) -> float:
    """Longest time left after an event, or where recency has faded, seconds."""
    params = result.params
    faded_s = params.recency_midpoint_s + 5 * params.recency_spread_s
    rests = (_events(result, letter, recording, MAX_EVENTS)["rest_s"].max() for letter in "xy")
    return max(faded_s, *(float(rest) for rest in rests if rest == rest))


def parts_plot(
    result: Result, *, theme: Theme, recording: int | None = None, n: int = N_PARTS
) -> go.Figure:
    """The most salient events taken apart: how long (pale), and what recency leaves (solid).

    `customdata` is the row in ``dataset.frames`` of the event's first frame.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``; None: all of them.
    n
        Events of each system.
    """
    look = LOOK[theme]
    traces: list[go.Bar] = []
    labels: list[str] = []
    for letter, system in result.sides:
        events = _events(result, letter, recording, n)
        place = len(labels) + np.arange(len(events), dtype=float)
        for name, track, start in zip(
            events["name"], events["track"], events["start_s"], strict=True
        ):
            where = "" if recording is not None else f"{plain(name, max_length=20)}, "
            labels.append(f"{where}ped {plain(track, max_length=8)}, {start:.1f} s")
        colour = look.of(letter)
        for column, fill in (("weight_s", faded(colour, 0.22)), ("saliency_s", colour)):
            marker = steady_marker(color=fill, line={"width": 1, "color": colour}, cornerradius=2)
            traces.append(
                go.Bar(
                    x=events[column].to_numpy(),
                    y=place,
                    width=0.72,
                    orientation="h",
                    customdata=events["first_row"].to_numpy(),
                    hovertext=events["text"].tolist(),
                    hovertemplate="%{hovertext}<extra></extra>",
                    name=system_label(letter, system.name),
                    legendgroup=letter,
                    showlegend=column == "saliency_s",
                    **marker,
                )
            )
    if not labels:
        return empty_figure(NO_EVENTS, theme=theme)
    is_risk = result.params.saliency_weight == "risk"
    kind = "largest event" if result.params.saliency_aggregate == "max" else "sum of events"
    return draw(
        traces,
        theme,
        title="The number taken apart",
        subtitle=f"{count_text(len(labels), 'most salient event')}; pale: "
        f"{'weighted distance over time' if is_risk else 'duration'}, solid: × recency",
        height=150 + 24 * len(labels),
        barmode="overlay",
        xaxis=axis(theme, f"seconds (a recording: {kind})", rangemode="tozero"),
        yaxis=rows_axis(theme, labels, fixedrange=True, showgrid=False, automargin=True),
    )
