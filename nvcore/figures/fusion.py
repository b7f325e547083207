"""Fusion what-if: encounters detected against false alerts, for X, Y, X or Y, X and Y."""

from __future__ import annotations

from typing import Any, Final

import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.style import LOOK, axis, empty_figure, layout, plain
from nvcore.palette import Theme

LABELS: Final = {"x": "X", "y": "Y", "x_or_y": "X or Y", "x_and_y": "X and Y"}
SYMBOLS: Final = {"x": "circle", "y": "diamond", "x_or_y": "star", "x_and_y": "square"}


def fusion_plot(fusion: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Four points: up is more encounters detected, left is fewer false alerts.

    Parameters
    ----------
    fusion
        `nvcore.encounter_counts.fusion_table`.
    """
    n_encounters = int(fusion["encounters"].max()) if len(fusion) else 0
    known = fusion[fusion["episodes_per_hour"].notna()]
    if not n_encounters or known.empty:
        return empty_figure("There is no encounter that counts.", theme=theme)
    look = LOOK[theme]
    colour = {"x": look.x, "y": look.y, "x_or_y": look.ink, "x_and_y": look.muted}
    rows: list[Any] = list(known.itertuples(index=False))
    traces = [
        go.Scatter(
            x=[row.episodes_per_hour], y=[row.encounters_detected], mode="markers+text",
            text=[LABELS[row.system]], textposition="middle right", cliponaxis=False,
            textfont={"size": 13, "color": colour[row.system]},
            marker={"size": 14, "symbol": SYMBOLS[row.system], "color": colour[row.system]},
            hovertext=[
                f"{LABELS[row.system]}: {plain(row.name)}<br>{row.encounters_detected} of "
                f"{n_encounters} encounters<br>{row.episodes_per_hour:.1f} false-alert episodes "
                "per hour"
            ],
            hovertemplate="%{hovertext}<extra></extra>", name=LABELS[row.system],
        )
        for row in rows
    ]  # fmt: skip
    most = float(known["episodes_per_hour"].max())
    return go.Figure(
        traces,
        layout(
            theme,
            title="What using both would gain and cost",
            subtitle=f"{n_encounters:,} encounters that count; best is top left",
            hoverdistance=24,
            showlegend=False,
            xaxis=axis(theme, "false-alert episodes per hour", fixedrange=True,
                       range=[-0.05 * most, 1.2 * most or 1.0]),
            yaxis=axis(theme, "encounters detected", range=[0, 1.08 * n_encounters],
                       fixedrange=True),
        ),
    )  # fmt: skip
