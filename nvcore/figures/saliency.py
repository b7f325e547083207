"""Saliency: the events on the recency curve, what makes up a number, and beside similarity."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line, with_gaps
from nvcore.figures.style import (
    CLEAR,
    LOOK,
    axis,
    begins_at,
    draw,
    empty_figure,
    faded,
    plain,
    rows_axis,
    system_label,
)
from nvcore.metrics.saliency import recency_weight
from nvcore.palette import Theme
from nvcore.tables.result import recordings_table
from nvcore.wording import count_text

MAX_EVENTS: Final = 1000
"""Events of each system on the curve, the most salient first."""
MANY_EVENTS: Final = 40
"""Events of a system above which the marks on the curve are small and open."""
N_PARTS: Final = 6
"""Events of each system that are taken apart."""
CURVE_POINTS: Final = 201
MANY_RECORDINGS: Final = 100
"""Recordings above which the marks of the plane are small and faint."""
NO_EVENTS: Final = "No saliency events: no {one} is missed by more than the tolerance."


def _events_in(result: Result, letter: str, recording: int | None) -> pd.DataFrame:
    """Events of one system in a recording; None: in all."""
    events: pd.DataFrame = result.system(letter).events
    if recording is not None:
        events = events[events["recording"].to_numpy() == recording]
    return events


def _most_salient(result: Result, letter: str, recording: int | None, most: int) -> pd.DataFrame:
    """The most salient events of one system, in their order, with a text for each."""
    events = _events_in(result, letter, recording)
    events = events.sort_values("saliency_s", ascending=False, kind="stable").head(most)
    names = result.dataset.recordings["name"].to_numpy()[events["recording"].to_numpy()]
    start_s = result.dataset.frames["time_s"].to_numpy()[events["first_row"].to_numpy()]
    is_risk, noun = result.params.saliency_weight == "risk", result.objects.singular
    text = [
        f"{letter.upper()} misses {noun} {track}<br>{plain(name)} at {start:.2f} s<br>"
        + (f"for {duration:.2f} s, weight {weight:.2f} s<br>" if is_risk else "")
        + f"{weight:.2f} s × recency {recency:.2f} = {saliency:.2f} s"
        for name, track, start, duration, weight, recency, saliency in zip(
            names,
            events["track"],
            start_s,
            events["duration_s"],
            events["weight_s"],
            events["recency"],
            events["saliency_s"],
            strict=True,
        )
    ]
    return events.assign(text=text, name=names, start_s=start_s)


def recency_plot(result: Result, *, theme: Theme, recording: int | None = None) -> go.Figure:
    """The recency curve with every event on it; larger marks weigh more before recency.

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
    weights_s = {letter: _events_in(result, letter, recording)["weight_s"] for letter in "xy"}
    most_s = np.concatenate(list(weights_s.values())).max(initial=1e-9)
    is_many = max(map(len, weights_s.values())) > MANY_EVENTS
    for letter, system in result.sides:
        events = _most_salient(result, letter, recording, MAX_EVENTS)
        n_events = len(weights_s[letter])
        drawn = f" ({len(events):,} drawn)" if len(events) < n_events else ""
        counts.append(f"{letter.upper()} {count_text(n_events, 'event')}{drawn}")
        marker = {
            "color": CLEAR if is_many else faded(look.of(letter), 0.35),
            "symbol": look.symbol(letter),
            "size": (3 if is_many else 5)
            + (8 if is_many else 15) * np.sqrt(events["weight_s"].to_numpy() / most_s),
            "line": {"width": 1.2, "color": look.of(letter)},
        }
        traces.append(
            marks(
                events[column].to_numpy(),
                events["recency"].to_numpy(),
                events["text"].tolist(),
                customdata=events["first_row"].to_numpy(),
                name=system_label(letter, system.name),
                marker=marker,
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
        subtitle=f"{', '.join(counts)}; larger marks "
        + ("weigh more" if params.saliency_weight == "risk" else "last longer"),
        height=360,
        xaxis=along,
        yaxis=axis(theme, "recency (weight, 0 to 1)", range=[-0.04, 1.05], fixedrange=True),
    )


def _reach_s(result: Result, recording: int | None) -> float:
    """Longest time left after an event, or where recency has faded, seconds."""
    params = result.params
    faded_s = params.recency_midpoint_s + 5 * params.recency_spread_s
    rests_s = (_events_in(result, letter, recording)["rest_s"] for letter in "xy")
    return max(faded_s, *(float(rest_s.max()) for rest_s in rests_s if len(rest_s)))


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
    look, short = LOOK[theme], result.objects.say("{short}")
    traces: list[go.Bar] = []
    labels: list[str] = []
    for letter, system in result.sides:
        events = _most_salient(result, letter, recording, n)
        place = len(labels) + np.arange(len(events), dtype=float)
        for name, track, start in zip(
            events["name"], events["track"], events["start_s"], strict=True
        ):
            where = "" if recording is not None else f"{plain(name, max_length=20)}, "
            labels.append(f"{where}{short} {plain(track, max_length=8)}, from {start:.1f} s")
        colour = look.of(letter)
        for column, fill in (("weight_s", faded(colour, 0.22)), ("saliency_s", colour)):
            marker = {"color": fill, "line": {"width": 1, "color": colour}, "cornerradius": 2}
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
                    marker=marker,
                )
            )
    if not labels:
        return empty_figure(result.objects.say(NO_EVENTS), theme=theme)
    is_risk = result.params.saliency_weight == "risk"
    what = (
        "only the largest counts"
        if result.params.saliency_aggregate == "max"
        else "their sum counts"
    )
    return draw(
        traces,
        theme,
        title="The number taken apart",
        subtitle=f"{count_text(len(labels), 'largest event')}; pale: "
        f"{'weighted distance' if is_risk else 'duration'}, solid: × recency",
        height=150 + 24 * len(labels),
        barmode="overlay",
        xaxis=axis(theme, f"seconds ({what})", rangemode="tozero"),
        yaxis=rows_axis(theme, labels, fixedrange=True, showgrid=False),
    )


def plane_plot(result: Result, *, theme: Theme) -> go.Figure:
    """Mean similarity by saliency: a mark for each recording and system, X and Y joined by a line.

    Large open marks are the means over recordings. `customdata` is a row in ``dataset.frames``: the
    first frame of the system's most salient event of the recording, else the recording's first.
    """
    recordings = recordings_table(result)
    recordings = recordings[recordings["n_frames"] > 0]
    if recordings.empty:
        return empty_figure("There is no recording to compare.", theme=theme)
    is_many = len(recordings) > MANY_RECORDINGS
    place = {letter: _place(recordings, letter) for letter in "xy"}
    joined = still_line(
        with_gaps(place["x"][0], place["y"][0]),
        with_gaps(place["x"][1], place["y"][1]),
        "the same recording",
        line={"width": 0.75 if is_many else 2, "color": LOOK[theme].pale},
    )
    traces = [joined]
    for letter in "xy":
        traces.append(_recording_marks(result, recordings, letter, is_small=is_many, theme=theme))
    if len(recordings) > 1:
        for letter in "xy":
            traces.append(_mean_mark(letter, *place[letter].mean(axis=1), theme=theme))
    n_better = [
        np.count_nonzero((place[own][0] > place[other][0]) & (place[own][1] < place[other][1]))
        for own, other in ("xy", "yx")
    ]
    lowest = min(float(similarity.min()) for similarity, _ in place.values())
    start = min(lowest - 0.02, 0.9)
    return draw(
        traces,
        theme,
        title="Similarity and saliency of the recordings",
        subtitle=f"{count_text(len(recordings), 'recording')}; best is bottom right; better in "
        f"both: X in {n_better[0]:,}, Y in {n_better[1]:,}",
        height=420,
        xaxis=axis(
            theme,
            "mean similarity (1 = perfect)" + begins_at(start),
            range=[start, 1.005],
            fixedrange=True,
        ),
        yaxis=axis(theme, "saliency (s, 0 = nothing to notice)", rangemode="tozero"),
    )


def _place(recordings: pd.DataFrame, letter: str) -> np.ndarray:
    """Mean similarity and saliency (s) of a system in the recordings; shape (2, n_recordings)."""
    place: np.ndarray = recordings[[f"mean_similarity_{letter}", f"saliency_{letter}"]].to_numpy(
        dtype=float
    )
    return place.T


def _recording_marks(
    result: Result, recordings: pd.DataFrame, letter: str, *, is_small: bool, theme: Theme
) -> go.Scatter:
    """A mark for each recording, which opens the system's most salient event in it."""
    look = LOOK[theme]
    similarity, saliency_s = _place(recordings, letter)
    rows = result.dataset.frame_columns.first[:-1].copy()
    events = result.system(letter).events.sort_values("saliency_s", kind="stable")
    rows[events["recording"].to_numpy()] = events["first_row"].to_numpy()  # the last one stays
    text = [
        f"{plain(name)}: {letter.upper()}<br>mean similarity {value:.3f}<br>"
        f"saliency {seconds:.2f} s"
        for name, value, seconds in zip(
            recordings["recording"], similarity, saliency_s, strict=True
        )
    ]
    return marks(
        similarity,
        saliency_s,
        text,
        cliponaxis=False,
        customdata=rows[recordings.index.to_numpy()],
        name=system_label(letter, result.system(letter).name),
        marker={
            "opacity": 0.6 if is_small else 1,
            "color": look.of(letter),
            "symbol": look.symbol(letter),
            "size": 5 if is_small else 10,
            "line": {"width": 0 if is_small else 1, "color": look.surface},
        },
    )


def _mean_mark(letter: str, x: float, y: float, *, theme: Theme) -> go.Scatter:
    """The mean of a system over recordings: a large open mark."""
    look = LOOK[theme]
    marker = {
        "color": CLEAR,
        "symbol": look.symbol(letter),
        "size": 20,
        "line": {"width": 2.5, "color": look.of(letter)},
    }
    text = (
        f"{letter.upper()}, mean of the recordings<br>mean similarity {x:.3f}<br>saliency {y:.2f} s"
    )
    name = f"mean of {letter.upper()}"
    return marks([x], [y], [text], name=name, cliponaxis=False, marker=marker)
