"""A figure that only the report has, and Plotly for a page without network."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Collection
from functools import cache
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go
from plotly.offline import get_plotlyjs
from plotly.subplots import make_subplots

from nvcore.figures.style import LOOK, axis, empty_figure, layout, plain
from nvcore.palette import Theme

THEME: Final[Theme] = "light"
INTERVAL_PX: Final = 88
"""Height of one figure's row."""
REACH: Final = 1.12
"""Half an axis, in the largest value that it shows."""
ZERO: Final[dict[str, Any]] = {"zeroline": True, "zerolinewidth": 1.5}


@cache
def packed_plotly() -> str:
    """Plotly's JavaScript, compressed, in base64: the page unpacks it."""
    return base64.b64encode(gzip.compress(get_plotlyjs().encode(), 9, mtime=0)).decode()


def figure_json(figure: go.Figure) -> str:
    """The figure as JSON that may stand in a ``script`` element: it cannot end it."""
    # to_json by the standard library's encoder: the same text wherever it is made
    text = json.dumps(json.loads(figure.to_json(engine="json")), separators=(",", ":"))
    for sign, escape in (("<", "\\u003c"), (">", "\\u003e"), ("&", "\\u0026")):
        text = text.replace(sign, escape)
    return text


def interval_plot(evidence: pd.DataFrame, shares: Collection[str] = ()) -> go.Figure:
    """Difference X - Y of every figure with its 95 % interval, each on an axis of its own.

    Right of the line X is better in all of them: where less is better, the axis runs backwards.

    Parameters
    ----------
    evidence
        `nvcore.significance.significance_table`.
    shares
        Figures whose axes are in per cent.
    """
    known = evidence[np.isfinite(evidence["difference"])]
    if known.empty:
        return empty_figure("No figure is defined for both systems.", theme=THEME)
    look = LOOK[THEME]
    figure = make_subplots(rows=len(known), cols=1, vertical_spacing=0.62 / len(known))
    for row, one in enumerate(known.itertuples(), 1):
        has_interval = np.isfinite(one.low)
        reach = REACH * max(np.nanmax(np.abs([one.low, one.high, one.difference])), 1e-9)
        sign = 1 if one.better == "higher" else -1
        if has_interval:
            figure.add_scatter(
                x=[one.low, one.high], y=[0, 0], mode="lines", hoverinfo="skip", row=row, col=1,
                line={"color": look.muted, "width": 3},
            )  # fmt: skip
        figure.add_scatter(
            x=[one.difference], y=[0], mode="markers", hoverinfo="x", row=row, col=1,
            marker={"color": _side(sign * one.difference), "size": 12,
                    "symbol": "circle" if has_interval else "circle-open"},
        )  # fmt: skip
        figure.update_xaxes(
            axis(THEME, range=[-sign * reach, sign * reach], fixedrange=True, nticks=7,
                 zerolinecolor=look.muted, tickformat="~%" if one.figure in shares else "",
                 **ZERO), row=row, col=1,
        )  # fmt: skip
        figure.update_yaxes(visible=False, range=[-1, 1], fixedrange=True, row=row, col=1)
        figure.add_annotation(
            text=plain(one.label, max_length=80), x=0, xref="paper", xanchor="left", y=1.1,
            yref=f"y{row if row > 1 else ''} domain", yanchor="bottom", showarrow=False,
            font={"size": 12.5, "color": look.ink},
        )  # fmt: skip
    figure.update_layout(
        layout(
            THEME,
            title="Differences X − Y with 95 % intervals",
            subtitle="right of the line X is better, left of it Y; open: no interval can be given",
            height=110 + INTERVAL_PX * len(known),
            showlegend=False,
            margin={"l": 24, "r": 24, "t": 92, "b": 30},
        )
    )
    return figure


def _side(gain: float) -> str:
    """Colour of the system that is better; grey where they are equal."""
    look: Any = LOOK[THEME]
    colour: str = look.x if gain > 0 else look.y if gain < 0 else look.muted
    return colour
