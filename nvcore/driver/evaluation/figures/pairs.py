"""Pairs of features: which estimate best at each adaptation period, and whether that stays."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.driver.estimators.words import words_of
from nvcore.driver.evaluation.figures.errors import PERIOD
from nvcore.figures.style import LOOK, axis, draw, empty_figure, loss_scale
from nvcore.palette import Theme
from nvcore.wording import count_text, minus

ROW_PX: Final = 22
AROUND_PX: Final = 130
SIDE_PX: Final = 64
"""Of a cell of the rank correlations."""


def feature_pairs_plot(pairs: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Error of every pair of features at every period, the best on average on top.

    Cells say the rank, 1 is best.

    Parameters
    ----------
    pairs
        Of `nvcore.driver.evaluation.tables.pairs_table`.
    """
    if pairs.empty:
        return empty_figure("No pair of features was evaluated.", theme=theme)
    names = [words_of(keys) for keys in zip(pairs["feature_1"], pairs["feature_2"], strict=True)]
    named = pairs.assign(pair=names)
    error = named.pivot_table(index="pair", columns="period_s", values="error")
    rank = named.pivot_table(index="pair", columns="period_s", values="rank")
    order = rank.mean(axis=1).sort_values(kind="stable").index
    error, rank = error.loc[order], rank.loc[order]
    periods = [f"{period:g}" for period in error.columns]
    cells = go.Heatmap(
        x=list(range(len(periods))),
        y=list(range(len(error))),
        z=error.to_numpy(),
        text=[[f"{value:.0f}" for value in row] for row in rank.to_numpy().tolist()],
        texttemplate="%{text}",
        colorscale=loss_scale(theme),
        zmin=0,
        showscale=False,
        xgap=1,
        ygap=1,
        customdata=[[(pair, period) for period in periods] for pair in error.index],
        hovertemplate="%{customdata[0]}<br>%{customdata[1]} s: error %{z:.4f}, rank %{text}"
        "<extra></extra>",
    )
    return draw(
        cells,
        theme,
        title="Pairs of features",
        subtitle=f"{count_text(len(error), 'pair')} by rank at each period, 1 is best; the colour "
        "is the error",
        height=AROUND_PX + ROW_PX * len(error),
        showlegend=False,
        xaxis=axis(
            theme,
            PERIOD,
            tickvals=list(range(len(periods))),
            ticktext=periods,
            showgrid=False,
            fixedrange=True,
        ),
        yaxis=axis(
            theme,
            tickvals=list(range(len(error))),
            ticktext=error.index.tolist(),
            autorange="reversed",
            showgrid=False,
            fixedrange=True,
        ),
    )


def pair_ranks_plot(ranks: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Rank correlation of the pairs' errors between every two periods, 1: the same ranking.

    Parameters
    ----------
    ranks
        Of `nvcore.driver.evaluation.tables.pair_ranks_table`.
    """
    if ranks.empty:
        return empty_figure("One period alone has no ranking to compare with.", theme=theme)
    look = LOOK[theme]
    periods = sorted({*ranks["period_1_s"], *ranks["period_2_s"]})
    place = {period: number for number, period in enumerate(periods)}
    values = np.full((len(periods), len(periods)), np.nan)
    for first, second, spearman in ranks[["period_1_s", "period_2_s", "spearman"]].to_numpy():
        values[place[first], place[second]] = values[place[second], place[first]] = spearman
    ticks = {
        "tickvals": list(range(len(periods))),
        "ticktext": [f"{period:g}" for period in periods],
        "showgrid": False,
        "fixedrange": True,
    }
    cells = go.Heatmap(
        z=values,
        zmin=-1,
        zmax=1,
        text=[["–" if np.isnan(v) else minus(f"{v:.2f}") for v in row] for row in values],
        texttemplate="%{text}",
        colorscale=[(0, look.surface), (0.5, look.grid), (1, look.muted)],
        showscale=False,
        xgap=1,
        ygap=1,
        hoverinfo="skip",
    )
    return draw(
        cells,
        theme,
        title="Does the ranking of the pairs stay?",
        subtitle="Spearman's rank correlation of their errors between two periods",
        height=AROUND_PX + SIDE_PX * len(periods) // 2,
        showlegend=False,
        xaxis=axis(theme, PERIOD, **ticks),
        yaxis=axis(theme, PERIOD, autorange="reversed", **ticks),
    )
