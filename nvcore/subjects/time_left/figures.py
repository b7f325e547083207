"""Figures of the time left: up to contact, over the speed, margins, and in the lanes."""

from __future__ import annotations

from itertools import compress
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text, minus, percent
from nvcore.comparison.compare import Result
from nvcore.figures.curves import mark_value
from nvcore.figures.lanes import Lanes, Strip
from nvcore.figures.marks import (
    band,
    click_markers,
    curve_line,
    joined,
    marks,
    outlines,
    row_texts,
    rule,
    still_line,
)
from nvcore.figures.over_time import decimate, evenly, frame_texts
from nvcore.figures.style import CLEAR, LOOK, ChartLook, Names, faded, plain, system_label, written
from nvcore.notes import phrase
from nvcore.subjects.time_left.encounters import (
    QUADRANTS,
    contact_at,
    count_in_time,
    nearest_contact,
    urgent_encounters,
)
from nvcore.subjects.time_left.judging import needed_time, speed_of_frames, turning_speeds
from nvcore.subjects.time_left.notes import responses
from nvcore.subjects.time_left.steps import time_left_in

OverSpeed = Literal["share_in_time", "mean_impact_kmh"]

NO_URGENT: Final = "No encounter is urgent: nobody has to be told in time."
MOST_ROWS: Final = 20
"""Default number of encounters drawn, which fill a screen."""
MOST_S: Final = 12.0
"""Longest time before contact that is drawn, unless a last chance is earlier.

Earlier moments stand at the edge.
"""
ROW_PX: Final = 26
TOP_PX: Final = 98
"""Height of heading and legend, which in a narrow window has two rows."""
AXIS_PX: Final = 42
HEAD_PX: Final = 32
"""Height of the titles of the impact speeds, inside the plot: the legend above it may wrap."""
APART: Final = 0.2
"""Distance of X's mark above the middle of a row, and of Y's below, in rows."""
BAND: Final = 0.4
"""Half the height of the band that is too late, in rows."""
NEVER: Final = 0.035
"""Distance right of contact of marks of systems that never confirm, as a share of the axis."""
RIGHT_PX: Final = 108
IMPACT_PX: Final = {"x": 48, "y": RIGHT_PX - 16}
"""Right ends of the impact speeds of X and Y, from the right end of the plot."""

OVER_SPEED: Final[dict[OverSpeed, tuple[str, str, str, dict[str, Any]]]] = {
    "share_in_time": (
        "Share in time over speed",
        "higher is better",
        "confirmed in time",
        {"range": [-0.03, 1.05], "tickformat": ".0%"},
    ),
    "mean_impact_kmh": (
        "Mean impact speed over speed",
        "lower is better",
        "mean impact speed (km/h)",
        {},
    ),
}
"""Title, better direction, and title and settings of the axis of each measure."""
TURNS: Final = 3
"""Maximum number of turns that are marked. With more, speed hardly decides the order."""

IN_TIME_WORDS: Final = {
    "both": "both in time",
    "only_x": "only X in time",
    "only_y": "only Y in time",
    "neither": "neither in time",
}
"""Words for the systems that confirm an urgent encounter in time."""
CORNERS: Final = {"both": (1, 1), "only_x": (1, 0), "only_y": (0, 1), "neither": (0, 0)}
"""Corner of the plot for each of these, as shares of its width and height."""
WORD_SHARE: Final = (0.3, 0.2)
"""Share of the plot's width and height that is free for the word in a corner."""
MOST_MARKS: Final = 2000
"""Maximum number of encounters drawn, those with the fastest impacts first."""
MOST_MARGIN_S: Final = 8.0
"""Largest margin on the axes. Larger ones stand at the edge."""
NEVER_MARGIN: Final = 0.12
"""Distance from the least margin to encounters that are never confirmed, as a share of the span."""
LEAST_SPAN_S: Final = 1.0
"""Least range of the margin axis on either side of the last chance."""

CONTACT_S: Final = 6.0
"""Longest time to contact drawn above the lanes, unless the car needs longer to stop."""
POINTS: Final = 2000
CLICKS: Final = 300


def approach_plot(
    result: Result, urgent: pd.DataFrame, *, theme: Theme, first: int = 0, most: int = MOST_ROWS
) -> go.Figure:
    """Plot each urgent encounter as a line from the first annotated frame to contact.

    The last chance is a bar; right of it, in the band, it is too late to stop. Filled marks: X and
    Y confirm the pedestrian. Open marks, right of contact: never. A click gives frame and
    encounter: `customdata` is the row in ``dataset.frames`` and that in ``result.encounters``.

    Parameters
    ----------
    urgent
        `nvcore.subjects.time_left.encounters.urgent_encounters`, in the order to draw.
    first, most
        First row drawn, counted from 0, and maximum number of rows.
    """
    look = LOOK[theme]
    if urgent.empty:
        return look.empty(NO_URGENT)
    part = urgent.iloc[first : first + most]
    n, row = len(part), np.arange(len(part), dtype=float)
    longest_s = max(MOST_S, np.ceil(1.2 * urgent["ttc_s"].max()))  # holds the last chances
    reach_s = float(min(longest_s, np.ceil(urgent["first_s"].max())))  # the same for all parts
    look_of = _last_chance(0.55 * ROW_PX, look)
    chances = _moments(result, part, part["urgent_row"].to_numpy(), "last chance") | look_of
    lines = _approach_lines(part, row, reach_s, look)
    traces = [*lines, marks(part["ttc_s"].to_numpy(), row, **chances)]
    for letter, shift in (("x", -APART), ("y", APART)):
        traces += _confirmations(result, part, letter, row + shift, reach_s, look)
    has_several = len(result.dataset.recordings) > 1
    labels = row_texts(
        "{short} {track}, {recording}" if has_several else "{short} {track}",
        short=result.objects.say("{short}"),
        track=[plain(track, max_length=8) for track in part["track"]],
        recording=[plain(name, max_length=20) for name in part["recording"]],
    )
    extent = f"{count_text(len(urgent), 'urgent encounter')}, the fastest impact on top"
    if n < len(urgent):
        extent += f", {first + 1} to {first + n} drawn"
    if (urgent["first_s"] > reach_s).any():
        extent += f"; what was more than {reach_s:g} s before contact stands at the left edge"
    time: dict[str, Any] = {"range": [reach_s * 1.01, -2 * NEVER * reach_s]}
    time |= {"zeroline": True, "zerolinewidth": 1.5, "zerolinecolor": look.ink}
    return look.draw(
        [trace for trace in traces if len(trace.x)],
        title="From the first sight to contact",
        subtitle=extent,
        height=TOP_PX + HEAD_PX + ROW_PX * n + AXIS_PX,
        hoverdistance=-1,
        margin={"r": RIGHT_PX, "t": TOP_PX},
        annotations=_impacts(part, look),
        xaxis=look.axis("seconds before contact", **time),
        yaxis=look.rows_axis(labels, range=[n - 0.4, -0.6 - HEAD_PX / ROW_PX], showgrid=False),
    )


def _approach_lines(
    part: pd.DataFrame, row: np.ndarray, reach_s: float, look: ChartLook
) -> list[go.Scatter]:
    """Return a line for each encounter, dotted after its last frame, and the "too late" bands."""
    zero = np.zeros(len(part))
    start = np.minimum(part["first_s"].to_numpy(), reach_s)
    stop, chance = np.maximum(part["last_s"].to_numpy(), 0), part["ttc_s"].to_numpy()
    return [
        still_line(
            *outlines(chance, zero, row - BAND, row + BAND),
            "too late to stop",
            showlegend=None,
            fill="toself",
            fillcolor=faded(look.pale, 0.55),
            width=0,
        ),
        joined(start, stop, row, "annotated", color=look.muted, width=2),
        joined(stop, zero, row, "no longer annotated", showlegend=None, **look.dotted),
    ]


def _last_chance(size: float, look: ChartLook) -> dict[str, Any]:
    """Return name and looks of the marks of last chances."""
    line = {"width": 3, "color": look.ink}
    marker = {"symbol": "line-ns", "size": size, "color": look.ink, "line": line}
    return {"name": "last chance to stop", "marker": marker}


def _moments(
    result: Result, part: pd.DataFrame, frame_row: np.ndarray, what: str
) -> dict[str, Any]:
    """Return texts and clicks of marks at a moment of each encounter."""
    texts = frame_texts(
        result,
        frame_row,
        "{noun} {track}, {recording}<br>{what}: frame {frame}, {time_s:.2f} s<br>last chance "
        "{ttc_s:.2f} s before contact, at {speed_kmh:.4g} km/h<br>{of_both}",
        noun=result.objects.singular,
        what=what,
        recording=part["recording"].map(plain),
        of_both=responses_text(result, part.index.to_numpy()),
        **{name: part[name] for name in ("track", "ttc_s", "speed_kmh")},
    )
    return {"texts": texts, "customdata": np.column_stack([frame_row, part.index.to_numpy()])}


def responses_text(result: Result, encounters: np.ndarray) -> list[str]:
    """Return hover texts with a line for each system's response to an urgent encounter.

    Parameters
    ----------
    encounters
        Rows of ``result.encounters``; shape (n,).
    """
    return [
        "<br>".join(phrase(response, result.objects) for response in of_both)
        for of_both in responses(result, encounters)
    ]


def _confirmations(
    result: Result, part: pd.DataFrame, letter: str, y: np.ndarray, reach_s: float, look: ChartLook
) -> list[go.Scatter]:
    """Return filled marks where a system confirms pedestrians, open ones where it never does."""
    name = result.system(letter).name
    at_s = part[f"confirmed_s_{letter}"].to_numpy()
    is_never = np.isnan(at_s)
    confirmed, never = part[~is_never], part[is_never]
    confirmed_row = confirmed[f"confirmed_row_{letter}"].to_numpy()
    what = f"{letter.upper()} {result.objects.say('confirms the {one}')}"
    line = {"width": 2, "color": look.of(letter)}
    return [
        marks(
            np.clip(at_s[~is_never], 0, reach_s),
            y[~is_never],
            **_moments(result, confirmed, confirmed_row, what),
            cliponaxis=False,
            name=f"{system_label(letter, name)} confirms",
            marker=look.marker(letter, 11),
        ),
        marks(
            np.full(len(never), -NEVER * reach_s),
            y[is_never],
            **_moments(result, never, never["urgent_row"].to_numpy(), "last chance"),
            cliponaxis=False,
            name=f"{letter.upper()} never",
            showlegend=False,
            marker={"symbol": look.symbol(letter), "size": 10, "color": CLEAR, "line": line},
        ),
    ]


def _impacts(part: pd.DataFrame, look: ChartLook) -> list[dict[str, Any]]:
    """Return impact speeds as two columns of text right of the plot, muted if the car stops."""
    side: dict[str, Any] = {"xref": "paper", "x": 1, "xanchor": "right", "size": 12, "yref": "y"}
    head: dict[str, Any] = {**side, "y": -0.6, "yanchor": "bottom", "color": look.muted}
    texts = [written("impact, km/h", xshift=IMPACT_PX["y"], yshift=16, **head)]
    texts += [written(letter.upper(), xshift=shift, **head) for letter, shift in IMPACT_PX.items()]
    for place, row in enumerate(part.to_dict("records")):
        for letter, shift in IMPACT_PX.items():
            value = row[f"impact_kmh_{letter}"]
            text, colour = (f"<b>{value:.0f}</b>", look.of(letter)) if value else ("0", look.muted)
            texts.append(written(text, y=place, xshift=shift, color=colour, **side))
    return texts


def over_speed_plot(
    curve: pd.DataFrame,
    names: Names,
    *,
    speed_kmh: float | None,
    theme: Theme,
    measure: OverSpeed = "share_in_time",
) -> go.Figure:
    """Plot a measure of X and Y over the speed, marking changes of the order.

    Parameters
    ----------
    curve
        Curve from `nvcore.subjects.time_left.judging.curve_over_speed`.
    speed_kmh
        Marked speed that all recordings are assumed to have
        (`nvcore.subjects.time_left.steps.TimeLeftView.assumed_speed_kmh`). None: some recordings
        state their own, which the curve replaces.
    measure
        ``share_in_time`` (higher is better) or ``mean_impact_kmh`` (lower is better).
    """
    look, defined = LOOK[theme], curve[curve["urgent"] > 0]
    if defined.empty:
        return look.empty("No encounter is urgent at any speed up to 130 km/h.")
    title, better, y_title, form = OVER_SPEED[measure]
    speeds, n = defined["speed_kmh"].to_numpy(), defined["urgent"].to_numpy()
    traces = [
        curve_line(
            speeds,
            defined[f"{measure}_{letter}"].to_numpy(dtype=float),
            row_texts(
                "{speed:g} km/h: {urgent} urgent<br>{letter}: {in_time:.0f} in time ({share}), "
                "mean impact {impact:.1f} km/h",
                letter=letter.upper(),
                speed=defined["speed_kmh"],
                urgent=defined["urgent"],
                in_time=defined[f"in_time_{letter}"],
                share=defined[f"share_in_time_{letter}"].map(percent),
                impact=defined[f"mean_impact_kmh_{letter}"],
            ),
            line=look.line(letter),
            name=system_label(letter, name),
            marker=look.marker(letter, 6),
        )
        for letter, name in zip("xy", names, strict=True)
    ]
    most = np.nanmax(defined[[f"{measure}_x", f"{measure}_y"]].to_numpy(dtype=float))
    whose = "all recordings, in place of their own" if speed_kmh is None else "the car"
    ticks = np.arange(10, 131, 20)
    form = {"range": [-0.04 * most, 1.08 * most or 1.0], **form}
    figure = look.draw(
        traces,
        title=title,
        subtitle=f"{count_text(n[0], 'urgent encounter')} at {speeds[0]:g} km/h, {n[-1]:,} at "
        f"{speeds[-1]:g}; {better}",
        height=340,
        hoverdistance=-1,
        xaxis=look.axis(f"speed of {whose} (km/h)", range=[5, 135], tickvals=ticks),
        yaxis=look.axis(y_title, **form),
    )
    turns = turning_speeds(defined, measure)
    marked = [] if speed_kmh is None else [("now", "speed", speed_kmh, 0.0, "ink", "solid")]
    if len(turns) <= TURNS:
        marked += [("turns at", f"turn {at:g}", at, 0.09, "muted", "dot") for at in turns]
    for word, name, at, y, colour, dash in marked:
        place = y if measure == "share_in_time" else 1 - y  # where the lines leave room
        looks = {"colour": colour, "dash": dash, "layer": "below"}
        mark_value(figure, at, f"{word} {at:g}", look, name=name, left_from=100, y=place, **looks)
    return figure


def margins_plot(result: Result, urgent: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot the margin of Y over that of X, a mark for each urgent encounter: up is earlier.

    Above the diagonal Y is first. Encounters that are never confirmed stand at the edge.
    `customdata` is the row of the last chance in ``dataset.frames`` and the encounter's row in
    ``result.encounters``.

    Parameters
    ----------
    urgent
        `nvcore.subjects.time_left.encounters.urgent_encounters`.
    """
    look = LOOK[theme]
    if urgent.empty:
        return look.empty(NO_URGENT)
    counts = count_in_time(urgent)
    extent = f"{count_text(len(urgent), 'urgent encounter')}: " + ", ".join(
        f"{IN_TIME_WORDS[name]} {counts[name]:,}" for name in QUADRANTS
    )
    if len(urgent) > MOST_MARKS:
        extent += f"; the {MOST_MARKS:,} with the fastest impacts drawn"
    urgent = urgent.head(MOST_MARKS)
    margins = urgent[["margin_s_x", "margin_s_y"]].to_numpy(dtype=float)
    low = min(float(np.nanmin(margins, initial=0)) - 0.2, -LEAST_SPAN_S)
    high = min(max(float(np.nanmax(margins, initial=0)), LEAST_SPAN_S), MOST_MARGIN_S)
    span, is_never = high - low, np.isnan(margins)
    never = low - NEVER_MARGIN * span if is_never.any() else low
    if (margins > high).any():
        extent += f"; margins of more than {high:g} s stand at the edge"
    place = np.where(is_never, never, np.clip(margins, low, high))
    ends = [never - 0.06 * span, high + 0.04 * span]
    is_taken = {
        name: (np.abs(place - np.take(ends, corner)) < np.diff(ends) * WORD_SHARE).all(axis=1).any()
        for name, corner in CORNERS.items()
    }
    # over all marks, but clear of a word in its corner
    diagonal = [
        low if is_taken["neither"] else low + 0.22 * span,
        high if is_taken["both"] else high - 0.12 * span,
    ]
    traces = [still_line(diagonal, diagonal, "X as early as Y", showlegend=None, **look.dotted)]
    texts = row_texts(
        "{noun} {track}, {recording}<br>{of_both}",
        noun=result.objects.singular,
        track=urgent["track"],
        recording=urgent["recording"].map(plain),
        of_both=responses_text(result, urgent.index.to_numpy()),
    )
    rows = np.column_stack([urgent["urgent_row"].to_numpy(), urgent.index.to_numpy()])
    clear = {"color": CLEAR, "symbol": "circle", "size": 9}
    looks = {
        "both": clear | {"line": {"width": 1.5, "color": look.muted}},
        "only_x": look.marker("x", 12),
        "only_y": look.marker("y", 12),
        "neither": {"color": look.ink, "symbol": "x", "size": 10, "line": {"width": 0}},
    }
    for name in QUADRANTS:
        is_in = (urgent["in_time"] == name).to_numpy()
        if is_in.any():
            mark = marks(
                place[is_in, 0],
                place[is_in, 1],
                [*compress(texts, is_in)],
                customdata=rows[is_in],
                name=f"{IN_TIME_WORDS[name]} ({counts[name]:,})",
                cliponaxis=False,
                marker=looks[name],
            )
            traces.append(mark)
    step = next(step for step in (0.5, 1, 2, 5) if span / step <= 8 or step == 5)
    ticks = (np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0).tolist()
    ticktext = [minus(f"{tick:g}") for tick in ticks]
    if is_never.any():
        ticks, ticktext = [never, *ticks], ["never", *ticktext]
    scale = {"range": ends, "tickvals": ticks, "ticktext": ticktext}
    along, up = (
        look.axis(f"margin of {system_label(letter, system.name)} (s)", **scale)
        for letter, system in result.sides
    )
    figure = look.draw(
        traces,
        title="Margin of X against Y",
        subtitle=extent,
        height=420,
        hoverdistance=24,
        xaxis=along,
        yaxis=up,
        # the legend has the word of a corner in which a mark stands
        annotations=[
            written(IN_TIME_WORDS[name], size=12, color=look.muted, **_corner(*corner, low))
            for name, corner in CORNERS.items()
            if not is_taken[name]
        ],
    )
    for letter in "xy":  # the last chance: a margin of 0
        name = f"last chance {letter}"
        rule(figure, letter, 0, color=look.ink, width=1.2, name=name, layer="below")
    return figure


def _corner(right: int, up: int, low: float) -> dict[str, Any]:
    """Return the place of a word in a corner: at an edge of the plot or at the least margin."""
    x, y = (
        {letter: 1, f"{letter}ref": "paper"} if is_high else {letter: low}
        for letter, is_high in (("x", right), ("y", up))
    )
    anchors = {"xanchor": "right" if right else "left", "yanchor": "top" if up else "bottom"}
    return {**x, **y, **anchors, "xshift": -6 if right else 6, "yshift": -4 if up else 4}


def _contact_strip(result: Result, recording: int, look: ChartLook) -> Strip | None:
    """Draw the least time to contact in each frame, filled where it is too late to stop.

    A click gives frame and encounter: `customdata` is the row in ``dataset.frames`` and that in
    ``result.encounters``.
    """
    frames = result.dataset.frame_columns
    rows, nearest = frames.rows_of(recording), nearest_contact(result, recording)
    speed_kmh = speed_of_frames(frames, result.params.speed_kmh)[rows]
    needed_s = needed_time(speed_kmh, result.params)
    reach_s = max(CONTACT_S, float(np.ceil(1.2 * needed_s.max(initial=0))))
    time_s = result.dataset.frames["time_s"].to_numpy()[rows]
    ttc_s = np.nan_to_num(nearest["ttc_s"].to_numpy(), nan=np.inf)
    known = np.flatnonzero(ttc_s < reach_s)
    if not len(known):
        return None
    drawn = decimate(np.minimum(ttc_s, reach_s), n_points=POINTS)
    x, values, needed = time_s[drawn], ttc_s[drawn], needed_s[drawn]
    values = np.where(values < reach_s, values, np.nan)
    late, pale = np.fmin(values, needed), faded(look.ink, 0.22)
    area = band(x, needed, late, "too late to stop", yaxis="y2", fillcolor=pale)
    is_same = bool(np.ptp(needed_s) == 0)
    at = np.array([0, -1]) if is_same else drawn
    limit = still_line(
        time_s[at],
        needed_s[at],
        f"{needed_s[0]:.1f} s needed to stop" if is_same else "time needed to stop",
        showlegend=None,
        yaxis="y2",
        **look.dotted,
    )
    line = still_line(x, values, "time to contact", yaxis="y2", color=look.ink, width=1.6)
    known = known[evenly(len(known), n_points=CLICKS)]
    encounter = nearest["encounter"].to_numpy()[known]
    texts = frame_texts(
        result,
        rows.start + known,
        "{noun} {track}, frame {frame}, {time_s:.2f} s<br>{left_s:.2f} s to contact, the least",
        noun=result.objects.singular,
        track=result.encounters.track[encounter],
        left_s=ttc_s[known],
    )
    places = np.column_stack([rows.start + known, encounter])
    clicks = click_markers(
        time_s[known], ttc_s[known], texts, customdata=places, name="contact", yaxis="y2"
    )
    ticks = np.arange(3) * np.floor(reach_s / 3)
    return Strip(
        words=f"; above them the least time to contact, up to {reach_s:g} s",
        traces=[area, limit, line, clicks],
        axis=look.axis("time to<br>contact (s)", range=[0, reach_s], tickvals=ticks),
    )


def _chances_in_lanes(
    result: Result, encounters: np.ndarray, size: float, look: ChartLook
) -> go.Scatter:
    """Mark the last chance in the lanes of urgent encounters, given those of all lanes in order."""
    lane = np.flatnonzero(time_left_in(result).is_urgent[encounters])
    urgent = encounters[lane]
    row = time_left_in(result).urgency["urgent_row"].to_numpy()[urgent]
    texts = frame_texts(
        result,
        row,
        "{noun} {track}, last chance to stop: frame {frame}, {time_s:.2f} s<br>{of_both}",
        noun=result.objects.singular,
        track=result.encounters.track[urgent],
        of_both=responses_text(result, urgent),
    )
    looks = _last_chance(size, look) | {"customdata": np.column_stack([row, urgent])}
    time_s = result.dataset.frames["time_s"].to_numpy()[row]
    return marks(time_s, lane.astype(float), texts, **looks)


def _to_contact(result: Result, encounter: np.ndarray, row: np.ndarray) -> list[str]:
    ttc_s = contact_at(result, encounter, row)
    return [f"{left:.1f} s to contact" if np.isfinite(left) else "" for left in ttc_s]


LANES: Final = Lanes(_contact_strip, _chances_in_lanes, _to_contact)
"""Content in and above the lanes of a recording."""


def time_left(result: Result, *, theme: Theme) -> go.Figure:
    """Plot urgent encounters up to contact, with the last chance and the confirmations."""
    return approach_plot(result, urgent_encounters(result), theme=theme)


def over_speed(result: Result, measure: OverSpeed = "share_in_time", *, theme: Theme) -> go.Figure:
    """Plot the time left of X and Y over the speed of the car.

    Parameters
    ----------
    measure
        ``"share_in_time"`` or ``"mean_impact_kmh"``.
    """
    view = time_left_in(result)
    speed_kmh = view.assumed_speed_kmh
    return over_speed_plot(
        view.over_speed, result.names, speed_kmh=speed_kmh, theme=theme, measure=measure
    )


def margins(result: Result, *, theme: Theme) -> go.Figure:
    """Plot the margins before the last chance at which X and Y confirm each urgent pedestrian."""
    return margins_plot(result, urgent_encounters(result), theme=theme)


FIGURES: Final = {"time_left": time_left, "over_speed": over_speed, "margins": margins}
"""Figures by name in `nvcore.api.figures.Figures`."""
