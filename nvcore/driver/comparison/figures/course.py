"""Plot of a pedestrian's detectability over time, with light and adaptation."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from numpy.typing import NDArray

from nvcore.driver.illumination import LightSource
from nvcore.driver.illumination.clock import AdaptationClock
from nvcore.figures.marks import marks, still_line
from nvcore.figures.over_time import decimate
from nvcore.figures.style import LOOK, axis, draw, empty_figure, faded, written
from nvcore.objects import Objects
from nvcore.palette import Shade, Theme, scheme_of
from nvcore.wording import count_text

HEIGHT_PX: Final = 300
WITH_LIGHT_PX: Final = 540
LEAST_TOP_S: Final = 5.0
"""The axis of the adaptation reaches so far at least, seconds."""
MOST_TOP_S: Final = 10.0
"""And no further: what matters happens in the first seconds."""
OUTSIDE_AT: Final = -0.06
"""Height of the strokes of doubtful frames: below 0, where no estimate can be."""
ROOM_S: Final = 0.5
"""Before and after the pedestrian."""
SOURCES: Final = {
    LightSource.METER: "light (lx)",
    LightSource.PICTURE: "picture's mean",
}
SIMULATED: Final[dict[Shade, str]] = {"light": "#8E3A8A", "dark": "#D68FD0"}
"""Neither X's nor Y's colour, nor the truth's."""
STAND_IN: Final = "light by the pictures' mean luminance, a stand-in"
BY_METER: Final = "light by the light meter"
UNKNOWN: Final = "nothing is known of the light"


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
    known = course[course["detectability"].notna()]
    if known.empty:
        text = f"It is not known how detectable this {objects.singular} is, in any frame."
        return empty_figure(text, theme=theme)
    traces = [
        *_course(known, theme),
        _outside(known, theme),
        *([] if simulated is None else _simulated(course, simulated, theme)),
    ]
    subtitle = f"{count_text(len(known), 'frame')} in which it is known, of {len(course):,}"
    span = [float(course["time_s"].min()) - ROOM_S, float(course["time_s"].max()) + ROOM_S]
    if caution:
        subtitle += f"; {caution}"
    more: dict[str, Any] = {}
    if clock is not None:
        traces += _light(clock, span, theme)
        more = _lower_axes(clock, span, theme)
        subtitle += f"; {_light_words(clock)}"
    title = f"share of drivers who see the {objects.singular}"
    figure = draw(
        traces,
        theme,
        title="Detectability over time",
        subtitle=subtitle,
        height=HEIGHT_PX if clock is None else WITH_LIGHT_PX,
        xaxis=axis(theme, "time (s)", range=span, anchor="y" if clock is None else "y3"),
        yaxis=axis(
            theme,
            title,
            range=[-0.09, 1.04],
            fixedrange=True,
            domain=[0 if clock is None else 0.5, 1],
        ),
        **more,
    )
    figure.add_hline(
        y=threshold,
        line={"color": LOOK[theme].muted, "width": 1.5, "dash": "dash"},
        annotation_text=f"sees from {threshold:g} on",
        annotation_position="bottom right",
    )
    if clock is not None:
        _mark_changes(figure, clock, span, theme)
    return figure


def _course(known: pd.DataFrame, theme: Theme) -> list[go.Scatter]:
    look = LOOK[theme]
    x, y = _band(known)
    band = go.Scatter(
        x=x,
        y=y,
        fill="toself",
        fillcolor=faded(look.muted, 0.2),
        mode="lines",
        line={"color": faded(look.muted, 0.2), "width": 1},  # all there is of a single frame
        hoverinfo="skip",
        name="± 1 standard deviation",
        showlegend=bool((known["sd"] > 0).any()),
    )
    parts = [
        (known[known["is_up_to_relevant"]], "up to the first frame that counts", "circle"),
        (known[~known["is_up_to_relevant"]], "later, or distant", "circle-open"),
    ]
    return [
        band,
        *(
            marks(
                frames["time_s"],
                frames["detectability"],
                None,
                hover="%{x:.2f} s: %{y:.2f}<extra></extra>",
                customdata=frames["row"],
                name=name,
                showlegend=len(frames) > 0,
                marker={"color": look.ink, "size": 6, "symbol": symbol},
            )
            for frames, name, symbol in parts
        ),
    ]


def _band(known: pd.DataFrame) -> tuple[list[float | None], list[float | None]]:
    """Return the outline of ± 1 standard deviation, split where frames lack one."""
    known = known[known["sd"].notna()]
    stretch = np.cumsum(known["row"].diff().ne(1))
    x: list[float | None] = []
    y: list[float | None] = []
    for _, frames in known.groupby(stretch):  # a handful for each encounter
        low = (frames["detectability"] - frames["sd"]).clip(0, 1)
        high = (frames["detectability"] + frames["sd"]).clip(0, 1)
        x += [*frames["time_s"], *frames["time_s"][::-1], None]
        y += [*high, *low[::-1], None]
    return x, y


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


def _simulated(course: pd.DataFrame, simulated: pd.DataFrame, theme: Theme) -> list[go.Scatter]:
    """Draw detectability after a simulated change of light, in the frames that it affects."""
    own = simulated["is_simulated"].to_numpy(bool) & simulated["detectability"].notna().to_numpy()
    return [
        marks(
            course["time_s"][own],
            simulated["detectability"][own],
            None,
            hover="simulated, %{x:.2f} s: %{y:.2f}<extra></extra>",
            customdata=course["row"][own],
            name="simulated",
            marker={"color": SIMULATED[scheme_of(theme).shade], "size": 6, "symbol": "diamond"},
        )
    ]


def _light(clock: AdaptationClock, span: list[float], theme: Theme) -> list[Any]:
    """Draw brightness, and the seconds since it became dark, over time."""
    look = LOOK[theme]
    lines = []
    inside = _is_inside(clock, span)
    low, _ = _decades(clock.level)
    level = np.where(clock.level <= 0, 10.0**low, clock.level)  # 0 has no place on such an axis
    for values, place, name in (
        (level, "y2", "light"),
        (clock.period_s, "y3", "seconds since the change"),
    ):
        known = np.where(inside, values, np.nan)
        rows = decimate(np.nan_to_num(known, nan=-1.0))
        lines.append(
            still_line(
                clock.time_s[rows],
                known[rows],
                name,
                yaxis=place,
                line={"color": look.ink, "width": 1.5, "shape": "hv"},
            )
        )
    return lines


def _light_words(clock: AdaptationClock) -> str:
    if np.isnan(clock.level).all():
        return UNKNOWN
    return BY_METER if clock.source is LightSource.METER else STAND_IN


def _is_inside(clock: AdaptationClock, span: list[float]) -> NDArray[np.bool_]:
    return (clock.time_s >= span[0]) & (clock.time_s <= span[1])


def _lower_axes(clock: AdaptationClock, span: list[float], theme: Theme) -> dict[str, Any]:
    shown = clock.period_s[_is_inside(clock, span)]
    longest_s = float(np.nanmax(shown, initial=0.0))
    return {
        "yaxis2": axis(
            theme,
            SOURCES[clock.source],
            domain=[0.25, 0.42],
            type="log",
            dtick=1,
            exponentformat="none",
            fixedrange=True,
            range=_decades(clock.level),
        ),
        "yaxis3": axis(
            theme,
            "adapting (s)",
            domain=[0, 0.17],
            fixedrange=True,
            range=[0, min(max(LEAST_TOP_S, longest_s), MOST_TOP_S)],
        ),
    }


def _decades(level: NDArray[np.float64]) -> list[int]:
    """Return the range of a logarithmic axis as exponents of ten that enclose all readings."""
    bright = level[level > 0]
    if not len(bright):
        return [-1, 0]
    low, high = math.floor(np.log10(bright.min())), math.ceil(np.log10(bright.max()))
    return [low, max(high, low + 1)]


def _mark_changes(
    figure: go.Figure, clock: AdaptationClock, span: list[float], theme: Theme
) -> None:
    """Draw a vertical line where it became dark, coloured if the change is simulated."""
    look = LOOK[theme]
    place = {"yref": "paper", "yanchor": "bottom", "xanchor": "left", "y": 0.42}
    texts = []
    for time_s in clock.change_s.tolist():
        if not span[0] <= time_s <= span[1]:
            continue
        is_simulated = time_s == clock.simulated_s
        colour = SIMULATED[scheme_of(theme).shade] if is_simulated else look.muted
        figure.add_shape(
            type="line", x0=time_s, x1=time_s, yref="paper", y0=0, y1=1,
            line={"color": colour, "width": 1.5, "dash": "dot"},
        )  # fmt: skip
        text = "simulated: dark" if is_simulated else "dark"
        texts.append(written(text, size=12, color=colour, x=time_s, **place))
    figure.layout.annotations = (*figure.layout.annotations, *texts)
