"""Plots of detectability over the time since the ambient light changed."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd
import plotly.graph_objects as go

from nvcore.driver.evaluation.figures.errors import period_axis
from nvcore.figures.marks import HOVER
from nvcore.figures.style import HEADING_PX, LOOK, axis, draw, empty_figure, written
from nvcore.palette import Theme
from nvcore.wording import count_text, percent

TITLES_PX: Final = 26
"""Height of the periods above the plots."""
HEIGHT_PX: Final = 340
GAP: Final = 0.02
"""Between two histograms, as a share of the width."""


def detectability_plot(periods: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot mean detectability by adaptation period, with its standard deviation as error bars.

    Parameters
    ----------
    periods
        Of `nvcore.driver.evaluation.tables.periods_table`.
    """
    if periods.empty:
        return empty_figure("There are no trials.", theme=theme)
    look = LOOK[theme]
    texts = [
        f"{row['period_s']:g} s: {row['mean']:.2f} on average, standard deviation {row['sd']:.2f}"
        f"<br>{percent(row['share_zero'])} seen by nobody, {percent(row['share_one'])} by everybody"
        for row in periods.to_dict("records")
    ]
    trace = go.Scatter(
        x=periods["period_s"],
        y=periods["mean"],
        error_y={"type": "data", "array": periods["sd"], "thickness": 1, "width": 4},
        mode="lines+markers",
        line={"color": look.ink, "width": 2.2},
        marker={"color": look.ink, "size": 8},
        text=texts,
        hovertemplate=HOVER,
        cliponaxis=False,
    )
    return draw(
        trace,
        theme,
        title="Detectability after a change of light",
        subtitle=f"mean and standard deviation of "
        f"{count_text(int(periods['n'].max()), 'pedestrian')} at each period",
        height=HEIGHT_PX,
        showlegend=False,
        xaxis=period_axis(theme, periods["period_s"]),
        yaxis=axis(theme, "detectability", range=[0, 1], fixedrange=True),
    )


def detectability_histograms_plot(histograms: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot a histogram of detectability for each adaptation period.

    Parameters
    ----------
    histograms
        Of `nvcore.driver.evaluation.tables.histograms_table`.
    """
    if histograms.empty:
        return empty_figure("There are no trials.", theme=theme)
    look = LOOK[theme]
    periods = histograms["period_s"].unique().tolist()
    width = (1 - GAP * (len(periods) - 1)) / len(periods)
    traces, titles, axes = [], [], {}
    for number, period_s in enumerate(periods):
        rows = histograms[histograms["period_s"] == period_s]
        name = "" if number == 0 else str(number + 1)
        start = number * (width + GAP)
        texts = [
            f"{period_s:g} s: {count_text(n, 'pedestrian')} with a detectability of {middle:.2g}"
            for middle, n in zip(rows["detectability"], rows["n"].tolist(), strict=True)
        ]
        traces.append(
            go.Bar(
                x=rows["detectability"],
                y=rows["n"],
                xaxis=f"x{name}",
                marker={"color": look.muted},
                text=texts,
                textposition="none",
                hovertemplate=HOVER,
            )
        )
        axes[f"xaxis{name}"] = _bars_axis(
            theme, start, width, is_middle=number == len(periods) // 2
        )
        titles.append(
            written(
                f"{period_s:g} s",
                size=12,
                color=look.ink,
                x=start + width / 2,
                y=1.02,
                xref="paper",
                yref="paper",
                xanchor="center",
                yanchor="bottom",
            )
        )
    n = int(histograms["n"].groupby(histograms["period_s"]).sum().max())
    return draw(
        traces,
        theme,
        title="Detectability at each adaptation period",
        subtitle=f"{count_text(n, 'pedestrian')} at each; 0: seen by nobody, 1: by everybody",
        height=HEIGHT_PX,
        showlegend=False,
        margin={"t": HEADING_PX + TITLES_PX},
        bargap=0.08,
        annotations=titles,
        yaxis=axis(theme, "pedestrians", rangemode="tozero", fixedrange=True, tickformat=",d"),
        **axes,
    )


def _bars_axis(theme: Theme, start: float, width: float, *, is_middle: bool) -> dict[str, Any]:
    """Return the x axis of one histogram, which has a title if `is_middle`."""
    return axis(
        theme,
        "detectability" if is_middle else "",
        domain=[start, min(start + width, 1.0)],
        range=[-0.13, 1.13],
        tickvals=[0, 0.5, 1],
        fixedrange=True,
        showgrid=False,
    )
