"""What the car's speed changes: share in time and mean impact speed of X and Y over it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import HOVER, system_marker
from nvcore.figures.style import LOOK, axis, draw, empty_figure, system_label, write
from nvcore.palette import Theme
from nvcore.time_left.judging import turning_speeds
from nvcore.wording import count_text, percent

OverSpeed = Literal["share_in_time", "mean_impact_kmh"]
HEIGHT_PX: Final = 340
OWN_REPLACED: Final = "speed of all recordings, in place of their own (km/h)"
TURNS: Final = 3
"""Most turns of the order that are marked; more are no matter of the speed."""


@dataclass(frozen=True)
class _Look:
    """How a measure is drawn, which way is better, and whether its lines leave room below."""

    title: str
    better: str
    along: dict[str, Any]
    is_high: bool


LOOKS: Final[dict[OverSpeed, _Look]] = {
    "share_in_time": _Look(
        "Share in time over speed",
        "higher is better",
        {"title": "confirmed in time", "range": [-0.03, 1.05], "tickformat": ".0%"},
        is_high=True,
    ),
    "mean_impact_kmh": _Look(
        "Mean impact speed over speed",
        "lower is better",
        {"title": "mean impact speed (km/h)"},
        is_high=False,
    ),
}


def over_speed_plot(
    curve: pd.DataFrame,
    names: tuple[str, str],
    *,
    speed_kmh: float | None,
    theme: Theme,
    measure: OverSpeed = "share_in_time",
) -> go.Figure:
    """A measure of X and Y over the speed, with where the order turns.

    Parameters
    ----------
    curve
        Of `nvcore.time_left.judging.curve_over_speed`.
    names
        Names of X and Y.
    speed_kmh
        The speed that all recordings are assumed to have, marked
        (`nvcore.comparison.Result.assumed_speed_kmh`); None: some state their own, in whose place
        the curve puts each speed.
    measure
        ``share_in_time`` (higher is better) or ``mean_impact_kmh`` (lower is better).
    """
    defined = curve[curve["urgent"] > 0]
    if defined.empty:
        return empty_figure("No encounter is urgent at any speed up to 130 km/h.", theme=theme)
    style, look = LOOKS[measure], LOOK[theme]
    speeds = defined["speed_kmh"].to_numpy()
    traces = []
    for letter, name in zip("xy", names, strict=True):
        values = defined[f"{measure}_{letter}"].to_numpy(dtype=float)
        traces.append(
            go.Scatter(
                x=speeds,
                y=values,
                mode="lines+markers",
                line={"width": 2.4, "color": look.of(letter), "dash": look.dash(letter)},
                text=_texts(defined, letter),
                hovertemplate=HOVER,
                cliponaxis=False,
                name=system_label(letter, name),
                marker=system_marker(letter, 6, theme),
            )
        )
    n = defined["urgent"].to_numpy()
    most = np.nanmax(defined[[f"{measure}_x", f"{measure}_y"]].to_numpy(dtype=float))
    across = {"range": [-0.04 * most, 1.08 * most or 1.0], **style.along, "fixedrange": True}
    figure = draw(
        traces,
        theme,
        title=style.title,
        subtitle=f"{count_text(n[0], 'urgent encounter')} at {speeds[0]:g} km/h, {n[-1]:,} at "
        f"{speeds[-1]:g}; {style.better}",
        height=HEIGHT_PX,
        hoverdistance=-1,
        xaxis=axis(
            theme,
            OWN_REPLACED if speed_kmh is None else "speed of the car (km/h)",
            range=[5, 135],
            fixedrange=True,
            tickvals=np.arange(10, 131, 20),
        ),
        yaxis=axis(theme, across.pop("title"), **across),
    )
    if speed_kmh is not None:
        place = 0.0 if style.is_high else 1.0
        _mark(figure, speed_kmh, f"now {speed_kmh:g}", "speed", place, theme, "solid")
    turns = turning_speeds(defined, measure)
    for speed in turns if len(turns) <= TURNS else ():
        place = 0.09 if style.is_high else 0.91
        _mark(figure, speed, f"turns at {speed:g}", f"turn {speed:g}", place, theme, "dot")
    return figure


def _texts(curve: pd.DataFrame, letter: str) -> list[str]:
    """For the mouse: the numbers behind a point."""
    columns = (f"in_time_{letter}", f"share_in_time_{letter}", f"mean_impact_kmh_{letter}")
    return [
        f"{speed:g} km/h: {urgent} urgent<br>{letter.upper()}: {in_time:.0f} in time "
        f"({percent(share)}), mean impact {impact:.1f} km/h"
        for speed, urgent, in_time, share, impact in zip(
            curve["speed_kmh"], curve["urgent"], *(curve[name] for name in columns), strict=True
        )
    ]


def _mark(
    figure: go.Figure, speed: float, text: str, name: str, y: float, theme: Theme, dash: str
) -> None:
    """A line over the whole height with its text, at a share of the height."""
    colour = LOOK[theme].ink if dash == "solid" else LOOK[theme].muted
    line = {"color": colour, "width": 1.5, "dash": dash}
    ends = {"x0": speed, "x1": speed, "yref": "paper", "y0": 0, "y1": 1}
    figure.add_shape(type="line", name=name, line=line, layer="below", **ends)
    is_right = speed > 100
    anchor = {"xanchor": "right" if is_right else "left", "xshift": -4 if is_right else 4}
    place = {
        "x": speed,
        "y": y,
        "yref": "paper",
        "yanchor": "top" if y > 0.5 else "bottom",
        **anchor,
    }
    write(figure, text, size=11, color=colour, **place)
