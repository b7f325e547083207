"""Estimates of pedestrians left out beside what people saw."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import HOVER
from nvcore.figures.style import LOOK, axis, draw, empty_figure, plain
from nvcore.palette import Theme
from nvcore.wording import count_text, number

HEIGHT_PX: Final = 420


def estimates_plot(estimates: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Detectability over its estimate, one mark for each pedestrian and period.

    On the line both are the same.

    Parameters
    ----------
    estimates
        Of `nvcore.driver.evaluation.tables.estimates_table`.
    """
    if estimates.empty:
        return empty_figure("Nothing was evaluated.", theme=theme)
    look = LOOK[theme]
    texts = [
        f"{plain(str(row['pedestrian']), max_length=40)} of "
        f"{plain(str(row['image']), max_length=40)}, {row['period_s']:g} s<br>"
        f"estimate {row['switched']:.2f}, seen by {row['detectability']:.2f} of "
        f"{count_text(row['n_subjects'], 'subject')}"
        for row in estimates.to_dict("records")
    ]
    same = go.Scatter(
        x=[0, 1],
        y=[0, 1],
        mode="lines",
        line={"color": look.muted, "dash": "dot", "width": 1.2},
        hoverinfo="skip",
    )
    marks = go.Scatter(
        x=estimates["switched"],
        y=estimates["detectability"],
        mode="markers",
        marker={"color": look.ink, "size": 7, "opacity": 0.45},
        text=texts,
        hovertemplate=HOVER,
        cliponaxis=False,
    )
    correlation = number(_correlation(estimates), ".2f")
    return draw(
        [same, marks],
        theme,
        title="Estimated and seen",
        subtitle=f"{count_text(len(estimates), 'estimate')}, each by the estimator of its period; "
        f"correlation {correlation}; on the line both are the same",
        height=HEIGHT_PX,
        showlegend=False,
        xaxis=axis(theme, "estimate", range=[-0.03, 1.03], fixedrange=True),
        yaxis=axis(
            theme, "detectability (share of the subjects)", range=[-0.03, 1.03], fixedrange=True
        ),
    )


def _correlation(estimates: pd.DataFrame) -> float:
    """Pearson's; NaN where either is the same everywhere."""
    seen, estimated = (estimates[name].to_numpy(float) for name in ("detectability", "switched"))
    if len(seen) < 2 or np.ptp(seen) == 0 or np.ptp(estimated) == 0:
        return np.nan
    return float(np.corrcoef(seen, estimated)[0, 1])
