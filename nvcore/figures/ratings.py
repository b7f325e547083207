"""Ratings of people against saliency (paper, figure 9), and how far participants agree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.marks import marks, system_marker
from nvcore.figures.style import LOOK, axis, draw, empty_figure, plain, rows_axis, system_label
from nvcore.palette import Theme
from nvcore.studies.ratings.agreement import Agreement
from nvcore.studies.ratings.validation import Correlation
from nvcore.wording import count_text

MOST_CLIPS: Final = 2_000
MOST_PARTICIPANTS: Final = 60
ROW_PX: Final = 20


def rating_plot(
    clips: pd.DataFrame,
    correlations: Sequence[Correlation],
    names: tuple[str, str],
    *,
    theme: Theme,
) -> go.Figure:
    """Saliency of every clip against its mean rank; one mark for each clip.

    Parameters
    ----------
    clips
        Of `nvcore.studies.ratings.validation.join_clips`.
    correlations
        Of `nvcore.studies.ratings.validation.correlate`; the subtitle has the first defined one.
    names
        Names of X and Y.
    """
    if clips.empty:
        return empty_figure("No clip has both a rating and a saliency.", theme=theme)
    traces = []
    for letter, name in zip("xy", names, strict=True):
        mine = clips[clips["system"] == name].head(MOST_CLIPS)
        text = [
            f"{plain(clip)}, boxes of {letter.upper()}<br>mean rank {rank:.1f} of "
            f"{count_text(n, 'rating')}<br>saliency {saliency:.2f} s"
            for clip, rank, n, saliency in zip(
                mine["clip"], mine["mean_rank"], mine["n_ratings"], mine["saliency_s"], strict=True
            )
        ]
        traces.append(
            marks(
                mine["mean_rank"],
                mine["saliency_s"],
                text,
                cliponaxis=False,
                name=system_label(letter, name),
                customdata=mine.index.to_numpy(),
                **system_marker(letter, 10, theme),
            )
        )
    first = next(
        (f"; {told_in_words(correlation)}" for correlation in correlations if not correlation.note),
        "",
    )
    return draw(
        traces,
        theme,
        title="Saliency against the ratings",
        subtitle=f"{count_text(len(clips), 'clip')}{first}",
        height=420,
        xaxis=axis(theme, "mean rank (1 = least annoying)"),
        yaxis=axis(theme, "saliency (s)", rangemode="tozero"),
    )


def told_in_words(correlation: Correlation) -> str:
    """The coefficient with its interval, such as ``Pearson's r 0.81 (95 %: 0.55 to 0.93)``."""
    if not np.isfinite(correlation.value):
        return f"{correlation.name} –: {correlation.note}"
    if not np.isfinite(correlation.low):
        return f"{correlation.name} {correlation.value:.2f} ({correlation.note})"
    interval = f"95 %: {correlation.low:.2f} to {correlation.high:.2f}"
    return f"{correlation.name} {correlation.value:.2f} ({interval})"


def participants_plot(agreement: Agreement, *, theme: Theme) -> go.Figure:
    """How well each participant's ranks agree with the mean of the others', lowest on top."""
    people = agreement.participants
    judged = people[np.isfinite(people["agreement"])].sort_values("agreement", kind="stable")
    if judged.empty:
        return empty_figure(
            "No participant rated enough clips that others rated, too.", theme=theme
        )
    participants = judged.head(MOST_PARTICIPANTS)
    look = LOOK[theme]
    is_outlier = participants["is_outlier"]
    marker = {
        "color": np.where(is_outlier, look.ink, look.muted),
        "symbol": np.where(is_outlier, "x", "circle"),
        "size": 10,
    }
    labels = [plain(name, max_length=24) for name in participants["participant"]]
    n_odd = int(judged["is_outlier"].sum())
    odd = f"; {n_odd or 'none'} going another way (marked x)" if agreement.knows_outliers else ""
    trace = go.Scatter(
        x=participants["agreement"],
        y=np.arange(len(participants)),
        mode="markers",
        hoverinfo="skip",
        showlegend=False,
        marker=marker,
    )
    ends = [min(-0.1, float(participants["agreement"].min()) - 0.05), 1.03]
    return draw(
        trace,
        theme,
        title="Agreement of each participant with the others",
        subtitle=f"{count_text(len(judged), 'participant')}{odd}",
        height=130 + ROW_PX * max(len(participants), 4),
        showlegend=False,
        xaxis=axis(theme, "correlation with the mean rank of the others", range=ends),
        yaxis=rows_axis(theme, labels, room=0.5, showgrid=False),
    )
