"""Chart of a planned study's power against its number of recordings."""

from __future__ import annotations

from typing import Any, Final

import plotly.graph_objects as go

from nvcore.evidence.planning.notes import ASSUMPTIONS
from nvcore.evidence.planning.plan import Plan
from nvcore.figures.style import LOOK, axis, draw, empty_figure, which_is_which
from nvcore.measures.table import difference_text
from nvcore.palette import Theme
from nvcore.wording import count_text, percent

DASHES: Final = ("solid", "dash")
SYMBOLS: Final = ("circle", "diamond")
LOG_FACTOR: Final = 8
"""Ratio of the numbers of recordings above which the axis is logarithmic."""


def power_plot(plan: Plan, *, theme: Theme) -> go.Figure:
    """Plot the share of simulated studies that show the effect, with a line per assumption.

    Bars are 95 % Monte Carlo intervals. The level line is the desired power.
    """
    sizes = [size for size in plan.sizes if size.points]
    if not sizes:
        return empty_figure("No study was simulated.", theme=theme)
    look = LOOK[theme]
    traces = []
    for size, dash, symbol in zip(sizes, DASHES, SYMBOLS, strict=False):
        points = size.points
        texts = [
            f"{count_text(point.n_recordings, 'recording')}<br>{percent(point.power)} of "
            f"{point.n_studies:,} studies ({percent(point.low)} to {percent(point.high)})"
            for point in points
        ]
        amount = difference_text(size.difference, plan.evidence.figure)
        name = ASSUMPTIONS[size.assumption]
        colour = look.ink if dash == "solid" else look.muted
        traces.append(
            go.Scatter(
                x=[point.n_recordings for point in points],
                y=[point.power for point in points],
                error_y={
                    "type": "data",
                    "symmetric": False,
                    "array": [point.high - point.power for point in points],
                    "arrayminus": [point.power - point.low for point in points],
                    "thickness": 1,
                    "width": 0,
                },
                mode="lines+markers",
                cliponaxis=False,
                line={"color": colour, "width": 1.5, "dash": dash},
                marker={"color": colour, "symbol": symbol, "size": 7},
                name=name if size.assumption == "equal" else f"{name} ({amount})",
                text=texts,
                hovertemplate="%{text}<extra></extra>",
                showlegend=True,
            )
        )
    numbers = [point.n_recordings for size in sizes for point in size.points]
    is_log = max(numbers) > LOG_FACTOR * min(numbers)
    figure = draw(
        traces,
        theme,
        title="How many recordings would show it",
        subtitle=f"{plan.evidence.label}; simulated from "
        f"{count_text(plan.evidence.n, 'recording')} with "
        f"{count_text(plan.n_encounters, 'encounter')}{which_is_which(theme)}",
        height=340,
        xaxis=axis(
            theme,
            "recordings" + (", logarithmic" if is_log else ""),
            **(_log_ticks(numbers) if is_log else {"rangemode": "tozero"}),
        ),
        yaxis=axis(theme, "power: share of studies that show it", range=[0, 1], tickformat=".0%"),
    )
    figure.add_hline(
        plan.power,
        line={"color": look.muted, "width": 1, "dash": "dot"},
        annotation={
            "text": percent(plan.power),
            "xanchor": "right",
            "font": {"size": 12, "color": look.muted},
        },
    )
    return figure


def _log_ticks(numbers: list[int]) -> dict[str, Any]:
    """Return settings of a logarithmic axis with ticks at 1, 2, 5, 10, 20 and so on."""
    ticks = [
        digit * 10**power
        for power in range(len(str(max(numbers))))
        for digit in (1, 2, 5)
        if min(numbers) <= digit * 10**power <= max(numbers)
    ]
    return {"type": "log", "tickvals": ticks, "ticktext": [f"{tick:,}" for tick in ticks]}
