"""Figures on the driver: detectability over time, counts by threshold, who sees which encounter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Shade, Theme, scheme_of
from nvcore.common.wording import count_text
from nvcore.figures.curves import mark_value
from nvcore.figures.marks import curve_line, marks, row_texts, rule, still_line
from nvcore.figures.over_time import decimate
from nvcore.figures.style import LOOK, ChartLook, Names, faded, plain, system_label, written
from nvcore.figures.venn import Frame, filled, square_axes
from nvcore.settings.objects import Objects
from nvcore.subjects.driver.comparison.judging import DRIVER_REGION_TEXT, DriverRegion
from nvcore.subjects.driver.illumination import LightSource
from nvcore.subjects.driver.illumination.clock import AdaptationClock

HEIGHT_PX: Final = 300
WITH_LIGHT_PX: Final = 540
ADAPTING_S: Final = (5.0, 10.0)
"""Minimum and maximum upper end of the adaptation axis, as the first seconds matter most."""
OUTSIDE_AT: Final = -0.06
"""Position of the marks for doubtful frames, below 0 so that no estimate is there."""
ROOM_S: Final = 0.5
"""Time shown before and after the pedestrian."""
SIMULATED: Final[dict[Shade, str]] = {"light": "#8E3A8A", "dark": "#D68FD0"}
"""Colours of simulated values, distinct from those of X, Y and truth."""
LIGHT: Final = {
    LightSource.METER: ("light (lx)", "light by the light meter"),
    LightSource.PICTURE: ("picture's mean", "light by the pictures' mean luminance, a stand-in"),
}
"""Title of the light axis, and words for the subtitle."""
UNKNOWN: Final = "nothing is known of the light"
MARK_PX: Final = 7
RADIUS: Final = 0.9
CENTRES: Final = {"driver": (0.0, 0.55), "x": (-0.52, -0.33), "y": (0.52, -0.33)}
PLACES: Final[dict[DriverRegion, tuple[float, float]]] = {
    DriverRegion.DRIVER_X_Y: (0.0, -0.02),
    DriverRegion.DRIVER_X: (-0.55, 0.28),
    DriverRegion.DRIVER_Y: (0.55, 0.28),
    DriverRegion.DRIVER: (0.0, 1.0),
    DriverRegion.X_Y: (0.0, -0.68),
    DriverRegion.X: (-0.95, -0.6),
    DriverRegion.Y: (0.95, -0.6),
    DriverRegion.NOBODY: (1.6, 0.9),
}
"""Position of each region's count."""


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
        Course from `nvcore.subjects.driver.comparison.encounters.detectability_course`.
    threshold
        Minimum detectability at which the driver sees the pedestrian, 0..1.
    clock
        Light and adaptation of the pedestrian's recording. None: the light is unknown.
    simulated
        The course with `detectability` after a simulated change of light
        (`nvcore.subjects.driver.running.estimate.simulate_change`). `clock` then has that change as
        well.
    caution
        Origin of the estimates, if some of the underlying answers were simulated.
    """
    look, known = LOOK[theme], course[course["detectability"].notna()]
    if known.empty:
        text = f"It is not known how detectable this {objects.singular} is, in any frame."
        return look.empty(text)
    is_early = known["is_up_to_relevant"]
    traces = [
        _band(known, look),
        _dots(known[is_early], "up to the first frame that counts", look.ink, "circle"),
        _dots(known[~is_early], "later, or distant", look.ink, "circle-open"),
        _outside(known, look),
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
        lines, axes = _light(clock, span, look)
        traces += lines
        subtitle += f"; {UNKNOWN if np.isnan(clock.level).all() else LIGHT[clock.source][1]}"
    title = f"share of drivers who see the {objects.singular}"
    figure = look.draw(
        traces,
        title="Detectability over time",
        subtitle=subtitle,
        height=WITH_LIGHT_PX if clock else HEIGHT_PX,
        xaxis=look.axis("time (s)", can_zoom=True, range=span, anchor="y3" if clock else "y"),
        yaxis=look.axis(title, domain=[0.5 if clock else 0, 1], range=[-0.09, 1.04]),
        **axes,
    )
    figure.add_hline(
        y=threshold,
        line={"color": look.muted, "width": 1.5, "dash": "dash"},
        annotation_text=f"sees from {threshold:g} on",
        annotation_position="bottom right",
    )
    if clock is not None:
        _mark_changes(figure, clock, span, look)
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


def _band(known: pd.DataFrame, look: ChartLook) -> go.Scatter:
    """Draw ± 1 standard deviation, split where frames lack one."""
    frames = known[known["sd"].notna()]
    stretch = np.cumsum(frames["row"].diff().ne(1))
    x: list[float | None] = []
    y: list[float | None] = []
    for _, part in frames.groupby(stretch):  # a handful per encounter
        low, high = ((part["detectability"] + way * part["sd"]).clip(0, 1) for way in (-1, 1))
        x += [*part["time_s"], *part["time_s"][::-1], None]
        y += [*high, *low[::-1], None]
    pale = faded(look.muted, 0.2)
    return still_line(
        x,
        y,
        "± 1 standard deviation",
        showlegend=bool((known["sd"] > 0).any()),
        fill="toself",
        fillcolor=pale,
        color=pale,
        width=1,  # a single frame has no area
    )


def _outside(known: pd.DataFrame, look: ChartLook) -> go.Scatter:
    """Mark frames whose estimates are outside the training range by strokes at the bottom."""
    times = known["time_s"][known["is_outside"].astype(bool)]
    return marks(
        times,
        np.full(len(times), OUTSIDE_AT),
        None,
        hover="",
        hoverinfo="skip",
        name="estimated outside the range of the training",
        showlegend=len(times) > 0,
        marker={"symbol": "line-ns", "size": 6, "line": {"width": 2, "color": look.muted}},
    )


def _light(
    clock: AdaptationClock, span: list[float], look: ChartLook
) -> tuple[list[go.Scatter], dict[str, Any]]:
    """Return lines of brightness and of the seconds since it became dark, and their axes."""
    is_inside = (clock.time_s >= span[0]) & (clock.time_s <= span[1])
    bright = clock.level[clock.level > 0]
    low, high = -1, 0  # exponents of ten that enclose all readings
    if len(bright):
        low, high = math.floor(np.log10(bright.min())), math.ceil(np.log10(bright.max()))
    level = np.where(clock.level <= 0, 10.0**low, clock.level)  # the logarithmic axis has no 0
    traces = []
    for values, place, name in (
        (level, "y2", "light"),
        (clock.period_s, "y3", "seconds since the change"),
    ):
        shown = np.where(is_inside, values, np.nan)
        rows = decimate(np.nan_to_num(shown, nan=-1.0))
        line = {"color": look.ink, "width": 1.5, "shape": "hv"}
        traces.append(still_line(clock.time_s[rows], shown[rows], name, yaxis=place, line=line))
    log: dict[str, Any] = {"type": "log", "dtick": 1, "exponentformat": "none"}
    log |= {"range": [low, max(high, low + 1)], "domain": [0.25, 0.42]}
    longest_s = float(np.nanmax(clock.period_s[is_inside], initial=0.0))
    top = [0, float(np.clip(longest_s, *ADAPTING_S))]
    period = look.axis("adapting (s)", domain=[0, 0.17], range=top)
    return traces, {"yaxis2": look.axis(LIGHT[clock.source][0], **log), "yaxis3": period}


def _mark_changes(
    figure: go.Figure, clock: AdaptationClock, span: list[float], look: ChartLook
) -> None:
    """Draw a vertical line where it became dark, coloured if the change is simulated."""
    place = {"xanchor": "left", "y": 0.42, "yref": "paper", "yanchor": "bottom"}
    texts = []
    for time_s in clock.change_s.tolist():
        if span[0] <= time_s <= span[1]:
            is_simulated = time_s == clock.simulated_s
            colour = SIMULATED[look.scheme.shade] if is_simulated else look.muted
            rule(figure, "x", time_s, color=colour, dash="dot")
            text = "simulated: dark" if is_simulated else "dark"
            texts.append(written(text, size=12, color=colour, x=time_s, **place))
    figure.layout.annotations = (*figure.layout.annotations, *texts)


def driver_threshold_plot(
    counts: pd.DataFrame, names: Names, *, threshold: float, theme: Theme, objects: Objects
) -> go.Figure:
    """Draw encounters seen by the driver, useful alerts of X and of Y, and unprotected ones.

    Parameters
    ----------
    counts
        Counts from `nvcore.subjects.driver.comparison.encounters.over_driver_threshold`.
    threshold
        Marked `driver_threshold`, 0 to 1.
    """
    look = LOOK[theme]
    if counts.empty:
        text = f"Of no encounter is it known whether the driver sees the {objects.singular}."
        return look.empty(text)
    looks = [("seen", "the driver sees", *_own("muted", "dot", "triangle-up-open", 1, look))]
    for letter, name in zip("xy", names, strict=True):
        label = f"useful alerts of {system_label(letter, name)}"
        marker = look.marker(letter, MARK_PX)
        looks.append((f"useful_{letter}", label, look.line(letter), marker))
    looks.append(("nobody", "unprotected by both", *_own("ink", "longdash", "x-thin", 1.6, look)))
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
    figure = look.draw(
        lines,
        title="Seen and warned of",
        subtitle=objects.say(words, n=n),
        height=360,
        xaxis=look.axis(x_title, range=[0, 1], dtick=0.1, tickformat=".1f"),
        yaxis=look.counts_axis(),
    )
    mark_value(figure, threshold, f"now {threshold:g}", look, name="now", left_from=0.8)
    return figure


def _own(
    colour: str, dash: str, symbol: str, rim: float, look: ChartLook
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a line and a marker that are neither X's nor Y's."""
    shade = getattr(look, colour)
    marker = {"color": shade, "size": MARK_PX, "symbol": symbol}
    marker["line"] = {"width": rim, "color": shade}
    return {"width": 1.8, "color": shade, "dash": dash}, marker


def driver_venn_plot(
    counts: Mapping[DriverRegion, int], names: Names, *, theme: Theme, objects: Objects
) -> go.Figure:
    """Draw a Venn diagram of the near encounters that the driver, X and Y see.

    A click on a count gives its region (`nvcore.subjects.driver.comparison.judging.DriverRegion`)
    as `customdata`. All circles have the same size, because the areas of three circles cannot show
    three counts and their overlaps.
    """
    look = LOOK[theme]
    n_known = sum(counts[region] for region in PLACES)
    if not n_known:
        return look.empty("It is not known of any encounter who sees it.")
    texts = [
        f"{count_text(counts[region], 'encounter')}<br>" + objects.say(DRIVER_REGION_TEXT[region])
        for region in PLACES
    ]
    x, y = zip(*PLACES.values(), strict=True)
    hidden = {"opacity": 0, "size": 44, "color": "#000"}
    points = marks(x, y, texts, customdata=[*PLACES], marker=hidden)
    numbers = [
        written(f"<b>{counts[region]:,}</b>", size=17, color=look.ink, x=x, y=y)
        for region, (x, y) in PLACES.items()
    ]
    n_unknown, n_distant = (
        counts[region] for region in (DriverRegion.UNKNOWN, DriverRegion.DISTANT)
    )
    return look.draw(
        points,
        title=f"Who sees the {objects.singular}",
        subtitle=f"{count_text(n_known, 'near encounter')} of which it is known; not drawn: "
        f"{n_unknown:,} unknown, {n_distant:,} distant; circles are not to scale",
        height=400,
        showlegend=False,
        shapes=[_circle(who, look) for who in CENTRES],
        annotations=[*_labels(names, look), *numbers],
        **square_axes((-2.0, 2.0), (-1.45, 1.65)),
    )


def _circle(who: str, look: ChartLook) -> dict[str, Any]:
    is_driver = who == "driver"
    colour, dash = (look.muted, "dot") if is_driver else (look.of(who), look.dash(who))
    line = {"color": colour, "width": 2.5, "dash": dash}
    x, y = CENTRES[who]
    box = Frame(x - RADIUS, x + RADIUS, y - RADIUS, y + RADIUS)
    return filled("circle", box, line, faded(colour, 0.14))


def _labels(names: Names, look: ChartLook) -> list[dict[str, Any]]:
    x, y = (f"{letter.upper()} {plain(name)}" for letter, name in zip("xy", names, strict=True))
    return [
        written("Driver", size=14, color=look.muted, x=0, y=1.48, yanchor="bottom"),
        written(x, size=14, color=look.x, x=-1.05, y=-1.2, yanchor="top"),
        written(y, size=14, color=look.y, x=1.05, y=-1.2, yanchor="top"),
        written("none of them", size=12, color=look.muted, x=1.6, y=1.08, yanchor="bottom"),
    ]
