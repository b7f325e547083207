"""Figures of the driver in a comparison: detectability over time, and counts over its threshold."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.driver.illumination import LightSource
from nvcore.driver.illumination.clock import AdaptationClock
from nvcore.figures.curves import mark_value
from nvcore.figures.marks import (
    curve_line,
    marks,
    row_texts,
    rule,
    still_line,
    system_line,
    system_marker,
)
from nvcore.figures.over_time import decimate
from nvcore.figures.style import (
    LOOK,
    axis,
    counts_axis,
    draw,
    empty_figure,
    faded,
    system_label,
    written,
)
from nvcore.objects import Objects
from nvcore.palette import Shade, Theme, scheme_of
from nvcore.wording import count_text

HEIGHT_PX: Final = 300
WITH_LIGHT_PX: Final = 540
ADAPTING_S: Final = (5.0, 10.0)
"""Least and largest upper end of the axis of the adaptation: what matters comes first."""
OUTSIDE_AT: Final = -0.06
"""Height of the strokes of doubtful frames: below 0, where no estimate can be."""
ROOM_S: Final = 0.5
"""Time shown before and after the pedestrian."""
SIMULATED: Final[dict[Shade, str]] = {"light": "#8E3A8A", "dark": "#D68FD0"}
"""Neither X's nor Y's colour, nor the truth's."""
LIGHT: Final = {
    LightSource.METER: ("light (lx)", "light by the light meter"),
    LightSource.PICTURE: (
        "picture's mean",
        "light by the pictures' mean luminance, a stand-in",
    ),
}
"""Title of the axis of light, and words for the subtitle."""
UNKNOWN: Final = "nothing is known of the light"
MARK_PX: Final = 7


def detectability_course_plot(
    course: pd.DataFrame,
    *,
    threshold: float,
    theme: Theme,
    objects: Objects,
    clock: AdaptationClock | None = None,
    simulated: pd.DataFrame | None = None,
    caution: str = "",
) -> go.Figure:
    """Plot detectability with its standard deviation over time, above light and adaptation.

    A click on a mark gives its row of the frames table as `customdata`.

    Parameters
    ----------
    course
        Of `nvcore.driver.comparison.encounters.detectability_course`.
    threshold
        Least detectability with which the driver sees the pedestrian, 0..1.
    clock
        Of the pedestrian's recording; None: nothing is known of the light.
    simulated
        Rows as of the course, with what `detectability` would be after a simulated change of light
        (`nvcore.driver.simulation.simulate_change`), which is the clock's, too.
    caution
        Whose answers the estimates rest on, where some were simulated.
    """
    known, look = course[course["detectability"].notna()], LOOK[theme]
    if known.empty:
        text = f"It is not known how detectable this {objects.singular} is, in any frame."
        return empty_figure(text, theme=theme)
    is_early = known["is_up_to_relevant"]
    traces = [
        _band(known, theme),
        _dots(known[is_early], "up to the first frame that counts", look.ink, "circle"),
        _dots(known[~is_early], "later, or distant", look.ink, "circle-open"),
        _outside(known, theme),
    ]
    if simulated is not None:
        own = simulated["is_simulated"].astype(bool) & simulated["detectability"].notna()
        drawn = course.assign(detectability=simulated["detectability"].to_numpy())[own.to_numpy()]
        traces.append(_dots(drawn, "simulated", SIMULATED[scheme_of(theme).shade], "diamond"))
    subtitle = f"{count_text(len(known), 'frame')} in which it is known, of {len(course):,}"
    subtitle += f"; {caution}" if caution else ""
    span = [float(course["time_s"].min()) - ROOM_S, float(course["time_s"].max()) + ROOM_S]
    axes: dict[str, Any] = {}
    if clock is not None:
        lines, axes = _light(clock, span, theme)
        traces += lines
        subtitle += f"; {UNKNOWN if np.isnan(clock.level).all() else LIGHT[clock.source][1]}"
    title = f"share of drivers who see the {objects.singular}"
    form: dict[str, Any] = {"range": [-0.09, 1.04], "fixedrange": True}
    figure = draw(
        traces,
        theme,
        title="Detectability over time",
        subtitle=subtitle,
        height=WITH_LIGHT_PX if clock else HEIGHT_PX,
        xaxis=axis(theme, "time (s)", range=span, anchor="y3" if clock else "y"),
        yaxis=axis(theme, title, domain=[0.5 if clock else 0, 1], **form),
        **axes,
    )
    figure.add_hline(
        y=threshold,
        line={"color": look.muted, "width": 1.5, "dash": "dash"},
        annotation_text=f"sees from {threshold:g} on",
        annotation_position="bottom right",
    )
    if clock is not None:
        _mark_changes(figure, clock, span, theme)
    return figure


def _dots(frames: pd.DataFrame, name: str, colour: str, symbol: str) -> go.Scatter:
    is_simulated = name == "simulated"
    return marks(
        frames["time_s"],
        frames["detectability"],
        None,
        hover="simulated, " * is_simulated + "%{x:.2f} s: %{y:.2f}<extra></extra>",
        customdata=frames["row"],
        name=name,
        showlegend=None if is_simulated else len(frames) > 0,
        marker={"color": colour, "size": 6, "symbol": symbol},
    )


def _band(known: pd.DataFrame, theme: Theme) -> go.Scatter:
    """Draw ± 1 standard deviation, split where frames lack one."""
    frames = known[known["sd"].notna()]
    stretch = np.cumsum(frames["row"].diff().ne(1))
    x: list[float | None] = []
    y: list[float | None] = []
    for _, part in frames.groupby(stretch):  # a handful for each encounter
        low, high = ((part["detectability"] + way * part["sd"]).clip(0, 1) for way in (-1, 1))
        x += [*part["time_s"], *part["time_s"][::-1], None]
        y += [*high, *low[::-1], None]
    pale = faded(LOOK[theme].muted, 0.2)
    return still_line(
        x,
        y,
        "± 1 standard deviation",
        showlegend=bool((known["sd"] > 0).any()),
        fill="toself",
        fillcolor=pale,
        line={"color": pale, "width": 1},  # all there is of a single frame
    )


def _outside(known: pd.DataFrame, theme: Theme) -> go.Scatter:
    """Mark frames whose estimates are outside the training range by strokes at the bottom."""
    times = known["time_s"][known["is_outside"].astype(bool)]
    line = {"width": 2, "color": LOOK[theme].muted}
    return marks(
        times,
        np.full(len(times), OUTSIDE_AT),
        None,
        hover="",
        hoverinfo="skip",
        name="estimated outside the range of the training",
        showlegend=len(times) > 0,
        marker={"symbol": "line-ns", "size": 6, "line": line},
    )


def _light(
    clock: AdaptationClock, span: list[float], theme: Theme
) -> tuple[list[go.Scatter], dict[str, Any]]:
    """Draw brightness, and the seconds since it became dark, over time, with their axes."""
    is_inside = (clock.time_s >= span[0]) & (clock.time_s <= span[1])
    bright = clock.level[clock.level > 0]
    low, high = -1, 0  # exponents of ten that enclose all readings
    if len(bright):
        low, high = math.floor(np.log10(bright.min())), math.ceil(np.log10(bright.max()))
    level = np.where(clock.level <= 0, 10.0**low, clock.level)  # 0 has no place on such an axis
    traces = []
    for values, place, name in (
        (level, "y2", "light"),
        (clock.period_s, "y3", "seconds since the change"),
    ):
        shown = np.where(is_inside, values, np.nan)
        rows = decimate(np.nan_to_num(shown, nan=-1.0))
        line = {"color": LOOK[theme].ink, "width": 1.5, "shape": "hv"}
        traces.append(still_line(clock.time_s[rows], shown[rows], name, yaxis=place, line=line))
    log: dict[str, Any] = {"type": "log", "dtick": 1, "exponentformat": "none", "fixedrange": True}
    log |= {"range": [low, max(high, low + 1)], "domain": [0.25, 0.42]}
    longest_s = float(np.nanmax(clock.period_s[is_inside], initial=0.0))
    top = [0, float(np.clip(longest_s, *ADAPTING_S))]
    period = axis(theme, "adapting (s)", domain=[0, 0.17], fixedrange=True, range=top)
    return traces, {"yaxis2": axis(theme, LIGHT[clock.source][0], **log), "yaxis3": period}


def _mark_changes(
    figure: go.Figure, clock: AdaptationClock, span: list[float], theme: Theme
) -> None:
    """Draw a vertical line where it became dark, coloured if the change is simulated."""
    place = {"xanchor": "left", "y": 0.42, "yref": "paper", "yanchor": "bottom"}
    texts = []
    for time_s in clock.change_s.tolist():
        if span[0] <= time_s <= span[1]:
            is_simulated = time_s == clock.simulated_s
            colour = SIMULATED[scheme_of(theme).shade] if is_simulated else LOOK[theme].muted
            rule(figure, "x", time_s, line={"color": colour, "width": 1.5, "dash": "dot"})
            text = "simulated: dark" if is_simulated else "dark"
            texts.append(written(text, size=12, color=colour, x=time_s, **place))
    figure.layout.annotations = (*figure.layout.annotations, *texts)


def driver_threshold_plot(
    counts: pd.DataFrame,
    names: tuple[str, str],
    *,
    threshold: float,
    theme: Theme,
    objects: Objects,
) -> go.Figure:
    """Draw encounters seen by the driver, useful alerts of X and of Y, and unprotected ones.

    Parameters
    ----------
    counts
        Of `nvcore.driver.comparison.encounters.over_driver_threshold`.
    names
        Names of X and Y.
    threshold
        `driver_threshold` as it is set, 0 to 1, marked.
    """
    if counts.empty:
        text = f"Of no encounter is it known whether the driver sees the {objects.singular}."
        return empty_figure(text, theme=theme)
    looks = [("seen", "the driver sees", *_own("muted", "dot", "triangle-up-open", 1, theme))]
    for letter, name in zip("xy", names, strict=True):
        label = f"useful alerts of {system_label(letter, name)}"
        marker = system_marker(letter, MARK_PX, theme)
        looks.append((f"useful_{letter}", label, system_line(letter, theme), marker))
    own = _own("ink", "longdash", "x-thin", 1.6, theme)
    looks.append(("nobody", "unprotected by both", *own))
    thresholds = counts["driver_threshold"].tolist()
    lines = [
        curve_line(
            thresholds,
            counts[column].tolist(),
            row_texts(
                "threshold {threshold:g}<br>{name}: {count}",
                name=name,
                threshold=thresholds,
                count=[count_text(n, "encounter") for n in counts[column].tolist()],
            ),
            name=name,
            line=line,
            marker=marker,
        )
        for column, name, line, marker in looks
    ]
    n = count_text(int(counts["known"].iloc[0]), "near encounter")
    words = "{n} of which it is known; the threshold decides {what} the driver sees"
    x_title = f"threshold: share of drivers who would see the {objects.singular} (driver_threshold)"
    form: dict[str, Any] = {"range": [0, 1], "fixedrange": True, "dtick": 0.1, "tickformat": ".1f"}
    figure = draw(
        lines,
        theme,
        title="Seen and warned of",
        subtitle=objects.say(words, n=n),
        height=360,
        xaxis=axis(theme, x_title, **form),
        yaxis=counts_axis(theme),
    )
    mark_value(figure, threshold, f"now {threshold:g}", theme, name="now", left_from=0.8)
    return figure


def _own(
    colour: str, dash: str, symbol: str, rim: float, theme: Theme
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a line and a marker that are neither X's nor Y's."""
    shade = getattr(LOOK[theme], colour)
    marker = {"color": shade, "size": MARK_PX, "symbol": symbol}
    marker["line"] = {"width": rim, "color": shade}
    return {"width": 1.8, "color": shade, "dash": dash}, marker
