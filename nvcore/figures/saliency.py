"""Figures of saliency: events on the recency curve, parts of events, and similarity."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text
from nvcore.comparison.compare import Result
from nvcore.figures.marks import marks, row_texts, still_line, with_gaps
from nvcore.figures.style import CLEAR, LOOK, faded, plain, system_label
from nvcore.metrics.saliency import recency_weight
from nvcore.tables.result import recordings_table

MAX_EVENTS: Final = 1000
"""Maximum number of events of each system on the curve, the most salient first."""
MANY_EVENTS: Final = 40
"""Events of a system above which the marks on the curve are small and open."""
N_PARTS: Final = 6
"""Maximum number of events of each system that are split into parts."""
CURVE_POINTS: Final = 201
MANY_RECORDINGS: Final = 100
"""Recordings above which the marks of the plane are small and faint."""
NO_EVENTS: Final = "No saliency events: no {one} is missed by more than the tolerance."


def _events_in(result: Result, letter: str, recording: int | None) -> pd.DataFrame:
    """Return the events of one system in a recording, or in all, the most salient first."""
    events: pd.DataFrame = result.system(letter).events
    if recording is not None:
        events = events[events["recording"].to_numpy() == recording]
    return events.sort_values("saliency_s", ascending=False, kind="stable")


def _worded(result: Result, letter: str, events: pd.DataFrame) -> pd.DataFrame:
    """Add recording's name, start_s and hover text to events of one system."""
    names = result.dataset.recordings["name"].to_numpy()[events["recording"].to_numpy()]
    start_s = result.dataset.frames["time_s"].to_numpy()[events["first_row"].to_numpy()]
    events = events.assign(name=names, start_s=start_s)
    is_risk, noun = result.params.saliency_weight == "risk", result.objects.singular
    text = [
        f"{letter.upper()} misses {noun} {event.track}<br>{plain(event.name)} at "
        f"{event.start_s:.2f} s<br>"
        + (f"for {event.duration_s:.2f} s, weight {event.weight_s:.2f} s<br>" if is_risk else "")
        + f"{event.weight_s:.2f} s × recency {event.recency:.2f} = {event.saliency_s:.2f} s"
        for event in events.itertuples(index=False)
    ]
    return events.assign(text=text)


def recency_plot(result: Result, *, theme: Theme, recording: int | None = None) -> go.Figure:
    """Plot the recency curve with every event. Larger marks weigh more before recency.

    `customdata` is the row in ``dataset.frames`` of the event's first frame.

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``; None: all of them.
    """
    look, params = LOOK[theme], result.params
    systems = {letter: _events_in(result, letter, recording) for letter in "xy"}
    scope = "encounter" if params.saliency_scope == "encounter" else "recording"
    if params.recency_unit == "seconds":
        # up to the longest time left after an event, or to where recency has faded
        faded_s = params.recency_midpoint_s + 5 * params.recency_spread_s
        column = "rest_s"
        reach = np.concatenate([events[column] for events in systems.values()]).max(initial=faded_s)
        quantity = f"time from the end of the event to the end of its {scope} (s)"
        along = look.axis(quantity, range=[1.02 * reach, -0.03 * reach])
    else:
        column, reach = "tau", 1.0
        quantity = f"end of the event in its {scope} (share of the duration)"
        along = look.axis(quantity, tickformat=".0%", range=[-0.02, 1.03])
    place = np.linspace(0, reach, CURVE_POINTS)
    weight = recency_weight(place, place, params)
    traces = [still_line(place, weight, "recency", color=look.muted, width=1.5)]
    counts = []
    most_s = np.concatenate([events["weight_s"] for events in systems.values()]).max(initial=1e-9)
    is_many = max(map(len, systems.values())) > MANY_EVENTS
    for letter, system in result.sides:
        n_events = len(systems[letter])
        events = _worded(result, letter, systems[letter].head(MAX_EVENTS))
        drawn = f" ({len(events):,} drawn)" if len(events) < n_events else ""
        counts.append(f"{letter.upper()} {count_text(n_events, 'event')}{drawn}")
        relative = np.sqrt(events["weight_s"].to_numpy() / most_s)
        mark = marks(
            events[column].to_numpy(),
            events["recency"].to_numpy(),
            events["text"].tolist(),
            customdata=events["first_row"].to_numpy(),
            name=system_label(letter, system.name),
            marker={
                "color": CLEAR if is_many else faded(look.of(letter), 0.35),
                "symbol": look.symbol(letter),
                "size": 3 + 8 * relative if is_many else 5 + 15 * relative,
                "line": {"width": 1.2, "color": look.of(letter)},
            },
        )
        traces.append(mark)
    return look.draw(
        traces,
        title="When misses happen, and how much they count",
        subtitle=f"{', '.join(counts)}; larger marks "
        + ("weigh more" if params.saliency_weight == "risk" else "last longer"),
        height=360,
        xaxis=along,
        yaxis=look.axis("recency (weight, 0 to 1)", range=[-0.04, 1.05]),
    )


def parts_plot(
    result: Result, *, theme: Theme, recording: int | None = None, n: int = N_PARTS
) -> go.Figure:
    """Plot the parts of the most salient events: duration (pale), and with recency (solid).

    `customdata` is the row in ``dataset.frames`` of the event's first frame.

    Parameters
    ----------
    recording
        As for `recency_plot`.
    n
        Events of each system.
    """
    look, params, short = LOOK[theme], result.params, result.objects.say("{short}")
    traces: list[go.Bar] = []
    labels: list[str] = []
    for letter, system in result.sides:
        events = _worded(result, letter, _events_in(result, letter, recording).head(n))
        place = len(labels) + np.arange(len(events), dtype=float)
        labels += [
            ("" if recording is not None else f"{plain(event.name, max_length=20)}, ")
            + f"{short} {plain(event.track, max_length=8)}, from {event.start_s:.1f} s"
            for event in events.itertuples(index=False)
        ]
        colour = look.of(letter)
        for column, fill in (("weight_s", faded(colour, 0.22)), ("saliency_s", colour)):
            bars = go.Bar(
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
                marker={"color": fill, "line": {"width": 1, "color": colour}, "cornerradius": 2},
            )
            traces.append(bars)
    if not labels:
        return look.empty(result.objects.say(NO_EVENTS))
    what = "only the largest counts" if params.saliency_aggregate == "max" else "their sum counts"
    return look.draw(
        traces,
        title="The number taken apart",
        subtitle=f"{count_text(len(labels), 'largest event')}; pale: "
        + ("weighted distance" if params.saliency_weight == "risk" else "duration")
        + ", solid: × recency",
        height=150 + 24 * len(labels),
        barmode="overlay",
        xaxis=look.axis(f"seconds ({what})", can_zoom=True, rangemode="tozero"),
        yaxis=look.rows_axis(labels, showgrid=False),
    )


def plane_plot(result: Result, *, theme: Theme) -> go.Figure:
    """Plot mean similarity by saliency, with X and Y of each recording joined by a line.

    Large open marks are the means over recordings. `customdata` is a row in ``dataset.frames``: the
    first frame of the system's most salient event of the recording, else the recording's first.
    """
    look, recordings = LOOK[theme], recordings_table(result)
    recordings = recordings[recordings["n_frames"] > 0]
    if recordings.empty:
        return look.empty("There is no recording to compare.")
    is_many = len(recordings) > MANY_RECORDINGS
    (x_similarity, x_saliency), (y_similarity, y_saliency) = place = [
        recordings[[f"mean_similarity_{letter}", f"saliency_{letter}"]].to_numpy(dtype=float).T
        for letter in "xy"
    ]
    joined = still_line(
        with_gaps(x_similarity, y_similarity),
        with_gaps(x_saliency, y_saliency),
        "the same recording",
        color=look.pale,
        width=0.75 if is_many else 2,
    )
    of_recordings, means = [], []
    for (letter, system), points in zip(result.sides, place, strict=True):
        rows = result.dataset.frame_columns.first[:-1].copy()
        events = system.events.sort_values("saliency_s", kind="stable")
        rows[events["recording"].to_numpy()] = events["first_row"].to_numpy()  # the last one stays
        text = row_texts(
            "{name}: {system}<br>mean similarity {similarity:.3f}<br>saliency {saliency_s:.2f} s",
            name=recordings["recording"].map(plain),
            system=letter.upper(),
            similarity=points[0],
            saliency_s=points[1],
        )
        marker = look.marker(letter, 5 if is_many else 10, rim=0 if is_many else 1)
        marker["opacity"] = 0.6 if is_many else 1
        mark = marks(
            points[0],
            points[1],
            text,
            cliponaxis=False,
            customdata=rows[recordings.index.to_numpy()],
            name=system_label(letter, system.name),
            marker=marker,
        )
        of_recordings.append(mark)
        (x, y), rim = points.mean(axis=1), {"width": 2.5, "color": look.of(letter)}
        mark = marks(
            [x],
            [y],
            [
                f"{letter.upper()}, mean of the recordings<br>mean similarity {x:.3f}<br>"
                f"saliency {y:.2f} s"
            ],
            name=f"mean of {letter.upper()}",
            cliponaxis=False,
            marker={"color": CLEAR, "symbol": look.symbol(letter), "size": 20, "line": rim},
        )
        means.append(mark)
    n_x = np.count_nonzero((x_similarity > y_similarity) & (x_saliency < y_saliency))
    n_y = np.count_nonzero((y_similarity > x_similarity) & (y_saliency < x_saliency))
    start = min(float(x_similarity.min()) - 0.02, float(y_similarity.min()) - 0.02, 0.9)
    return look.draw(
        [joined, *of_recordings, *(means if len(recordings) > 1 else [])],
        title="Similarity and saliency of the recordings",
        subtitle=f"{count_text(len(recordings), 'recording')}; best is bottom right; better in "
        f"both: X in {n_x:,}, Y in {n_y:,}",
        height=420,
        xaxis=look.axis("mean similarity (1 = perfect)", begins=start, range=[start, 1.005]),
        yaxis=look.axis("saliency (s, 0 = nothing to notice)", can_zoom=True, rangemode="tozero"),
    )
