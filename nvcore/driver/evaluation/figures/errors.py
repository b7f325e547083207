"""How far estimates of pedestrians left out are from what people saw."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import HOVER
from nvcore.figures.style import LOOK, axis, draw, empty_figure
from nvcore.palette import Theme
from nvcore.wording import count_text

HEIGHT_PX: Final = 360
PERIOD: Final = "adaptation period (s)"
_LINES: Final = (
    ("switched", "switched: one for each period", "solid", "circle", False),
    ("single", "single: one for all", "dash", "diamond", False),
    ("constant", "constant: mean of the others", "dot", "square", False),
    ("published_switched", "paper, switched", "solid", "circle-open", True),
    ("published_single", "paper, single", "dash", "diamond-open", True),
)
"""Column, name, dash, mark, and whether it is another's."""


def estimator_errors_plot(
    errors: pd.DataFrame, *, theme: Theme, has_published: bool = True
) -> go.Figure:
    """Mean squared error over the adaptation periods; 0 is best.

    Parameters
    ----------
    errors
        Of `nvcore.driver.evaluation.tables.errors_table`.
    has_published
        Whether the paper's errors, of other data, are drawn, too.
    """
    rows = errors[errors["period_s"].notna()]
    if rows.empty:
        return empty_figure("Nothing was evaluated.", theme=theme)
    look = LOOK[theme]
    traces = []
    for column, name, dash, symbol, is_published in _LINES:
        if rows[column].isna().all() or (is_published and not has_published):
            continue
        colour = look.muted if is_published or column == "constant" else look.ink
        texts = [
            f"{name}<br>{period:g} s: {error:.4f}"
            for period, error in zip(rows["period_s"], rows[column], strict=True)
        ]
        traces.append(
            go.Scatter(
                x=rows["period_s"],
                y=rows[column],
                mode="lines+markers",
                name=name,
                line={"color": colour, "dash": dash, "width": 1.2 if is_published else 2.2},
                marker={"color": colour, "symbol": symbol, "size": 8},
                text=texts,
                hovertemplate=HOVER,
                cliponaxis=False,
            )
        )
    return draw(
        traces,
        theme,
        title="Error on pedestrians left out",
        subtitle=f"{count_text(int(rows['n'].max()), 'pedestrian')} at each period; 0 is best",
        height=HEIGHT_PX,
        xaxis=period_axis(theme, rows["period_s"]),
        yaxis=axis(theme, "mean squared error", rangemode="tozero", fixedrange=True),
    )


def period_axis(theme: Theme, periods_s: pd.Series, **more: Any) -> dict[str, Any]:
    """An axis of adaptation periods, each with its tick."""
    periods = sorted(set(periods_s.tolist()))
    ticks = {"tickvals": periods, "ticktext": [f"{period:g}" for period in periods]}
    return axis(theme, PERIOD, rangemode="tozero", fixedrange=True, **ticks, **more)
