"""Figures of an evaluation: errors, estimates, pairs of features, detectability by period."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd

from nvcore.common.extras import needs
from nvcore.common.palette import Theme
from nvcore.common.wording import count_text, minus, number, percent
from nvcore.subjects.driver.features import words_of

with needs("report", "figures need"):
    import plotly.graph_objects as go

    from nvcore.figures.marks import HOVER, cells, curve_line, marks, row_texts, still_line
    from nvcore.figures.style import HEADING_PX, LOOK, ChartLook, plain, written

PERIOD: Final = "adaptation period (s)"
HEIGHT_PX: Final = 340
ROW_PX: Final = 22
CELL_PX: Final = 32
"""Height of a row for a pair of features or of a cell of the rank correlations."""
AROUND_PX: Final = 130
"""Height of a figure of cells without its rows."""
TITLES_PX: Final = 26
"""Height of the period titles above the histograms."""
GAP: Final = 0.02
"""Gap between two histograms, as a share of the width."""
_LINES: Final = (
    ("switched", "switched: one for each period", "solid", "circle"),
    ("single", "single: one for all", "dash", "diamond"),
    ("constant", "constant: mean of the others", "dot", "square"),
    ("published_switched", "paper, switched", "solid", "circle-open"),
    ("published_single", "paper, single", "dash", "diamond-open"),
)
"""Column, name, dash and mark of each line of errors."""


def estimator_errors_plot(
    errors: pd.DataFrame, *, theme: Theme, has_published: bool = True
) -> go.Figure:
    """Plot the mean squared error over the adaptation periods, 0 is best.

    Parameters
    ----------
    errors
        Table from `nvcore.subjects.driver.evaluation.tables.errors_table`.
    has_published
        True to draw the paper's errors as well, which are based on other data.
    """
    look, rows = LOOK[theme], errors[errors["period_s"].notna()]
    if rows.empty:
        return look.empty("Nothing was evaluated.")
    traces = []
    for column, name, dash, symbol in _LINES:
        is_published = column.startswith("published")
        if rows[column].isna().all() or (is_published and not has_published):
            continue
        colour = look.muted if is_published or column == "constant" else look.ink
        at, error = rows["period_s"], rows[column]
        texts = row_texts("{name}<br>{at:g} s: {error:.4f}", name=name, at=at, error=error)
        line = {"color": colour, "dash": dash, "width": 1.2 if is_published else 2.2}
        marker = {"color": colour, "symbol": symbol, "size": 8}
        traces.append(curve_line(at, error, texts, name=name, line=line, marker=marker))
    return look.draw(
        traces,
        title="Error on pedestrians left out",
        subtitle=f"{count_text(int(rows['n'].max()), 'pedestrian')} at each period; 0 is best",
        height=360,
        xaxis=_period_axis(look, rows),
        yaxis=look.axis("mean squared error", rangemode="tozero"),
    )


def estimates_plot(estimates: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot detectability over its estimate, one mark for each pedestrian and period.

    The line marks equal values.

    Parameters
    ----------
    estimates
        Table from `nvcore.subjects.driver.evaluation.tables.estimates_table`.
    """
    look = LOOK[theme]
    if estimates.empty:
        return look.empty("Nothing was evaluated.")
    ends = [-0.03, 1.03]
    texts = [
        f"{plain(row['pedestrian'], max_length=40)} of {plain(row['image'], max_length=40)}, "
        f"{row['period_s']:g} s<br>estimate {row['switched']:.2f}, seen by "
        f"{row['detectability']:.2f} of {count_text(row['n_subjects'], 'subject')}"
        for row in estimates.to_dict("records")
    ]
    dotted = {"color": look.muted, "dash": "dot", "width": 1.2, "showlegend": None}
    same = still_line([0, 1], [0, 1], None, **dotted)
    seen, estimated = estimates["detectability"], estimates["switched"]
    marker = {"color": look.ink, "size": 7, "opacity": 0.45}
    is_defined = min(np.ptp(seen), np.ptp(estimated)) > 0
    correlation = np.corrcoef(seen, estimated)[0, 1] if is_defined else np.nan
    return look.draw(
        [same, marks(estimated, seen, texts, marker=marker, cliponaxis=False)],
        title="Estimated and seen",
        subtitle=f"{count_text(len(estimates), 'estimate')}, each by the estimator of its period; "
        f"correlation {number(correlation, '.2f')}; on the line both are the same",
        height=420,
        showlegend=False,
        xaxis=look.axis("estimate", range=ends),
        yaxis=look.axis("detectability (share of the subjects)", range=ends),
    )


def feature_pairs_plot(pairs: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot the error of every pair of features at every period, the best on average on top.

    Cells show the rank. 1 is best.

    Parameters
    ----------
    pairs
        Table from `nvcore.subjects.driver.evaluation.tables.pairs_table`.
    """
    look = LOOK[theme]
    if pairs.empty:
        return look.empty("No pair of features was evaluated.")
    names = [words_of(keys) for keys in zip(pairs["feature_1"], pairs["feature_2"], strict=True)]
    named = pairs.assign(pair=names)
    error = named.pivot_table(index="pair", columns="period_s", values="error")
    rank = named.pivot_table(index="pair", columns="period_s", values="rank")
    order = rank.mean(axis=1).sort_values(kind="stable").index
    error, rank = error.loc[order], rank.loc[order]
    periods = [f"{period:g}" for period in error.columns]
    heat = cells(
        error.to_numpy(),
        [[f"{value:.0f}" for value in row] for row in rank.to_numpy().tolist()],
        x=list(range(len(periods))),
        y=list(range(len(error))),
        colorscale=look.loss_scale,
        zmin=0,
        customdata=[[(pair, period) for period in periods] for pair in error.index],
        hovertemplate="%{customdata[0]}<br>%{customdata[1]} s: error %{z:.4f}, rank %{text}"
        "<extra></extra>",
    )
    return look.draw(
        heat,
        title="Pairs of features",
        subtitle=f"{count_text(len(error), 'pair')} by rank at each period, 1 is best; the colour "
        "is the error",
        height=AROUND_PX + ROW_PX * len(error),
        showlegend=False,
        xaxis=look.cells_axis(PERIOD, periods),
        yaxis=look.cells_axis("", error.index.tolist(), autorange="reversed"),
    )


def pair_ranks_plot(ranks: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot rank correlations of the pairs' errors between every two periods. 1 is the same ranking.

    Parameters
    ----------
    ranks
        Table from `nvcore.subjects.driver.evaluation.tables.pair_ranks_table`.
    """
    look = LOOK[theme]
    if ranks.empty:
        return look.empty("One period alone has no ranking to compare with.")
    first, second = "period_1_s", "period_2_s"
    swapped = ranks.rename(columns={first: second, second: first})
    both = pd.concat([ranks, swapped]).pivot_table("spearman", first, second, dropna=False)
    values, periods = both.to_numpy(), [f"{period:g}" for period in both.columns]
    heat = cells(
        values,
        [["–" if np.isnan(v) else minus(f"{v:.2f}") for v in row] for row in values],
        zmin=-1,
        zmax=1,
        colorscale=[(0, look.surface), (0.5, look.grid), (1, look.muted)],
        hoverinfo="skip",
    )
    return look.draw(
        heat,
        title="Does the ranking of the pairs stay?",
        subtitle="Spearman's rank correlation of their errors between two periods",
        height=AROUND_PX + CELL_PX * len(periods),
        showlegend=False,
        xaxis=look.cells_axis(PERIOD, periods),
        yaxis=look.cells_axis(PERIOD, periods, autorange="reversed"),
    )


def detectability_plot(periods: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot mean detectability by adaptation period, with its standard deviation as error bars.

    Parameters
    ----------
    periods
        Table from `nvcore.subjects.driver.evaluation.tables.periods_table`.
    """
    look = LOOK[theme]
    if periods.empty:
        return look.empty("There are no trials.")
    texts = [
        f"{row['period_s']:g} s: {row['mean']:.2f} on average, standard deviation {row['sd']:.2f}"
        f"<br>{percent(row['share_zero'])} seen by nobody, {percent(row['share_one'])} by everybody"
        for row in periods.to_dict("records")
    ]
    ink = look.ink
    means = curve_line(
        periods["period_s"],
        periods["mean"],
        texts,
        error_y={"type": "data", "array": periods["sd"], "thickness": 1, "width": 4},
        line={"color": ink, "width": 2.2},
        marker={"color": ink, "size": 8},
    )
    return look.draw(
        means,
        title="Detectability after a change of light",
        subtitle=f"mean and standard deviation of "
        f"{count_text(int(periods['n'].max()), 'pedestrian')} at each period",
        height=HEIGHT_PX,
        showlegend=False,
        xaxis=_period_axis(look, periods),
        yaxis=look.axis("detectability", range=[0, 1]),
    )


def detectability_histograms_plot(histograms: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot a histogram of detectability for each adaptation period.

    Parameters
    ----------
    histograms
        Table from `nvcore.subjects.driver.evaluation.tables.histograms_table`.
    """
    look = LOOK[theme]
    if histograms.empty:
        return look.empty("There are no trials.")
    by_period = histograms.groupby("period_s", sort=False)
    width = (1 - GAP * (len(by_period) - 1)) / len(by_period)
    above = {"xref": "paper", "yref": "paper", "y": 1.02, "yanchor": "bottom", "xanchor": "center"}
    traces, titles, axes = [], [], {}
    for index, (period_s, rows) in enumerate(by_period):
        name, start = str(index + 1) if index else "", index * (width + GAP)
        texts = [
            f"{period_s:g} s: {count_text(n, 'pedestrian')} with a detectability of {middle:.2g}"
            for middle, n in zip(rows["detectability"], rows["n"].tolist(), strict=True)
        ]
        looks = {"marker": {"color": look.muted}, "textposition": "none", "hovertemplate": HOVER}
        x, y = rows["detectability"], rows["n"]
        traces.append(go.Bar(x=x, y=y, xaxis=f"x{name}", text=texts, **looks))
        axes[f"xaxis{name}"] = look.axis(
            "detectability" if index == len(by_period) // 2 else "",
            domain=[start, min(start + width, 1.0)],
            range=[-0.13, 1.13],
            tickvals=[0, 0.5, 1],
            showgrid=False,
        )
        place = {"x": start + width / 2, **above}
        titles.append(written(f"{period_s:g} s", size=12, color=look.ink, **place))
    n = count_text(int(by_period["n"].sum().max()), "pedestrian")
    return look.draw(
        traces,
        title="Detectability at each adaptation period",
        subtitle=f"{n} at each; 0: seen by nobody, 1: by everybody",
        height=HEIGHT_PX,
        showlegend=False,
        margin={"t": HEADING_PX + TITLES_PX},
        bargap=0.08,
        annotations=titles,
        yaxis=look.axis("pedestrians", rangemode="tozero", tickformat=",d"),
        **axes,
    )


def _period_axis(look: ChartLook, rows: pd.DataFrame) -> dict[str, Any]:
    """Return an axis of adaptation periods, each with its tick."""
    periods = sorted(set(rows["period_s"]))
    labels = [f"{period:g}" for period in periods]
    return look.axis(PERIOD, rangemode="tozero", tickvals=periods, ticktext=labels)
