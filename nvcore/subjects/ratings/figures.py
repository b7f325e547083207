"""Ratings of people against saliency (paper, figure 9), and the agreement of participants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import count_text
from nvcore.figures.marks import band, still_line
from nvcore.figures.style import LOOK, ChartLook, Names, faded, plain, written
from nvcore.subjects.ratings.agreement import Agreement
from nvcore.subjects.ratings.trend import Trend, fit_trend
from nvcore.subjects.ratings.validation import Correlation

MOST_CLIPS: Final = 2_000
MOST_NAMES: Final = 5
"""Maximum number of outliers that are named."""
MOST_PARTICIPANTS: Final = 60
ROW_PX: Final = 20


def rating_plot(
    clips: pd.DataFrame, correlations: Sequence[Correlation], names: Names, *, theme: Theme
) -> go.Figure:
    """Plot the saliency of every clip against its mean rank, with the line through the clips.

    The line has its 95 % interval as a band. At most five outliers by the rule of
    `nvcore.subjects.ratings.trend.Trend` are named.

    Parameters
    ----------
    clips
        Clips from `nvcore.subjects.ratings.validation.join_clips`.
    correlations
        Correlations from `nvcore.subjects.ratings.validation.correlate`. The subtitle has the first
        defined one.
    """
    look = LOOK[theme]
    if clips.empty:
        return look.empty("No clip has both a rating and a saliency.")
    trend = fit_trend(clips)
    traces, highest_s, texts = [], clips["saliency_s"].max(), []
    if trend is not None:
        traces += _trend_traces(trend, look)
        highest_s = max(highest_s, trend.most_s.max())
        texts = _outlier_names(clips, trend, names, look.ink)
    for letter, name in zip("xy", names, strict=True):
        mine = clips[clips["system"] == name].head(MOST_CLIPS)
        hover = [
            f"{plain(row['clip'])}, boxes of {letter.upper()}<br>mean rank {row['mean_rank']:.1f} "
            f"of {count_text(row['n_ratings'], 'rating')}<br>saliency {row['saliency_s']:.2f} s"
            for row in mine.to_dict("records")
        ]
        places = mine["mean_rank"], mine["saliency_s"], hover
        looks = {"cliponaxis": False, "customdata": mine.index.to_numpy()}
        traces.append(look.marks(letter, name, 10, *places, **looks))
    told = [
        f"; {of.name} {of.value:.2f} (95 %: {of.low:.2f} to {of.high:.2f})"
        for of in correlations
        if not of.note
    ]
    ends = [np.floor(clips["mean_rank"].min() - 0.5), np.ceil(clips["mean_rank"].max() + 0.5)]
    return look.draw(
        traces,
        title="Saliency against the ratings",
        subtitle=f"{count_text(len(clips), 'clip')}{''.join(told[:1])}",
        height=420,
        annotations=texts,
        xaxis=look.axis(
            "mean rank (1 = least annoying)", begins=ends[0], can_zoom=True, range=ends
        ),
        # the axis starts at 0, however far down the interval reaches, since saliency is never
        # negative
        yaxis=look.axis("saliency (s)", can_zoom=True, range=[0, 1.06 * highest_s or 1]),
    )


def _trend_traces(trend: Trend, look: ChartLook) -> list[go.Scatter]:
    """Return the interval as a band, and the line on it."""
    name, pale = "interval of the trend", faded(look.muted, 0.18)
    interval = band(trend.rank, trend.least_s, trend.most_s, name, fillcolor=pale)
    per_rank = (
        f"trend: {trend.slope_s:+.2f} s per rank (95 %: {trend.low_s:+.2f} to {trend.high_s:+.2f})"
    )
    looks = {"width": 2, "color": look.muted, "dash": "dot", "showlegend": True}
    return [interval, still_line(trend.rank, trend.saliency_s, per_rank, **looks)]


def _outlier_names(
    clips: pd.DataFrame, trend: Trend, names: Names, color: str
) -> list[dict[str, Any]]:
    """Return the names of the outliers as annotations, the farthest first."""
    order = np.argsort(-np.abs(trend.residual_s), kind="stable")
    texts = []
    for index in order[trend.is_outlier[order]][:MOST_NAMES]:
        clip = clips.iloc[index]
        text = f"{plain(clip['clip'], max_length=24)}, {'X' if clip['system'] == names[0] else 'Y'}"
        is_left = clip["mean_rank"] < clips["mean_rank"].mean()
        place = {"x": clip["mean_rank"], "y": clip["saliency_s"]}
        place |= {"xanchor": "left", "xshift": 6} if is_left else {"xanchor": "right", "xshift": -6}
        place["yshift"] = 11 if trend.residual_s[index] > 0 else -11  # away from line and clips
        texts.append(written(text, size=12, color=color, name="outlier", **place))
    return texts


def participants_plot(agreement: Agreement, *, theme: Theme) -> go.Figure:
    """Plot the agreement of each participant's ranks with the mean of the others', lowest first."""
    look, people = LOOK[theme], agreement.participants
    judged = people[np.isfinite(people["agreement"])].sort_values("agreement", kind="stable")
    if judged.empty:
        return look.empty("No participant rated enough clips that others rated, too.")
    participants = judged.head(MOST_PARTICIPANTS)
    is_outlier = participants["is_outlier"]
    marker = {"color": np.where(is_outlier, look.ink, look.muted), "size": 10}
    marker["symbol"] = np.where(is_outlier, "x", "circle")
    labels = [plain(name, max_length=24) for name in participants["participant"]]
    n_odd = int(judged["is_outlier"].sum())
    odd = f"; {n_odd or 'none'} ranking differently (marked x)" if agreement.knows_outliers else ""
    rows = np.arange(len(participants))
    trace = still_line(participants["agreement"], rows, None, mode="markers", marker=marker)
    ends = [min(-0.1, float(participants["agreement"].min()) - 0.05), 1.03]
    return look.draw(
        trace,
        title="Agreement of each participant with the others",
        subtitle=f"{count_text(len(judged), 'participant')}{odd}",
        height=130 + ROW_PX * max(len(participants), 4),
        showlegend=False,
        xaxis=look.axis("correlation with the mean rank of the others", can_zoom=True, range=ends),
        yaxis=look.rows_axis(labels, room=0.5, can_zoom=True, showgrid=False),
    )
