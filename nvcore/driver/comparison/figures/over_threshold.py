"""What the threshold of seeing changes: whom the driver sees, and what that leaves to X and Y."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import HOVER, line_up, system_marker
from nvcore.figures.style import (
    LOOK,
    axis,
    counts_axis,
    draw,
    empty_figure,
    system_label,
    write,
)
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.wording import count_text

HEIGHT_PX: Final = 360
MARK_PX: Final = 7
NOW_LEFT_OF: Final = 0.8
"""Up to here the text of the threshold that is set stands right of its line."""


def driver_threshold_plot(
    counts: pd.DataFrame,
    names: tuple[str, str],
    *,
    threshold: float,
    theme: Theme,
    objects: Objects,
) -> go.Figure:
    """Encounters seen by the driver, useful alerts of X and of Y, and unprotected ones.

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
    lines = [
        _line(counts, "seen", "the driver sees", _own("muted", "dot", "triangle-up-open", theme)),
        *(
            _line(counts, f"useful_{letter}", _useful(letter, name), _of_system(letter, theme))
            for letter, name in zip("xy", names, strict=True)
        ),
        _line(counts, "nobody", "unprotected by both", _own("ink", "longdash", "x-thin", theme)),
    ]
    n = count_text(int(counts["known"].iloc[0]), "near encounter")
    figure = draw(
        lines,
        theme,
        title="Seen and warned of",
        subtitle=objects.say(
            "{n} of which it is known; the threshold decides {what} the driver sees", n=n
        ),
        height=HEIGHT_PX,
        xaxis=axis(
            theme,
            f"threshold: share of drivers who would see the {objects.singular} (driver_threshold)",
            range=[0, 1],
            fixedrange=True,
            dtick=0.1,
            tickformat=".1f",
        ),
        yaxis=counts_axis(theme),
    )
    line_up(figure, threshold, "now", theme)
    is_right = threshold <= NOW_LEFT_OF
    write(
        figure,
        f"now {threshold:g}",
        size=11,
        color=LOOK[theme].ink,
        x=threshold,
        y=1,
        yref="paper",
        yanchor="top",
        xanchor="left" if is_right else "right",
        xshift=4 if is_right else -4,
    )
    return figure


def _useful(letter: str, name: str) -> str:
    return f"useful alerts of {system_label(letter, name)}"


def _line(counts: pd.DataFrame, column: str, name: str, style: dict[str, Any]) -> go.Scatter:
    values = counts[column].tolist()
    thresholds = counts["driver_threshold"].tolist()
    texts = [
        f"threshold {threshold:g}<br>{name}: {count_text(value, 'encounter')}"
        for threshold, value in zip(thresholds, values, strict=True)
    ]
    return go.Scatter(
        x=thresholds,
        y=values,
        mode="lines+markers",
        name=name,
        text=texts,
        hovertemplate=HOVER,
        cliponaxis=False,
        **style,
    )


def _of_system(letter: str, theme: Theme) -> dict[str, Any]:
    look = LOOK[theme]
    line = {"width": 2.4, "color": look.of(letter), "dash": look.dash(letter)}
    return {"line": line, "marker": system_marker(letter, MARK_PX, theme)}


def _own(colour: str, dash: str, symbol: str, theme: Theme) -> dict[str, Any]:
    """Of what is no system: neither its colour nor its mark is one of theirs."""
    look = LOOK[theme]
    shade = getattr(look, colour)
    rim = {"width": 1.6 if symbol.endswith("thin") else 1, "color": shade}
    marker = {"color": shade, "size": MARK_PX, "symbol": symbol, "line": rim}
    return {"line": {"width": 1.8, "color": shade, "dash": dash}, "marker": marker}
