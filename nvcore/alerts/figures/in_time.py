"""Shares of urgent encounters in which the driver is in time, by kind of alert and system."""

from __future__ import annotations

from typing import Final

import numpy as np
import plotly.graph_objects as go

from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line, system_marker, with_gaps
from nvcore.figures.style import LOOK, axis, draw, empty_figure, faded, rows_axis, system_label
from nvcore.palette import Theme
from nvcore.wording import count_text

ROW_PX: Final = 64
APART: Final = 0.16
"""How far X and Y stand from the middle of a row."""


def alerts_in_time(result: Result, *, theme: Theme) -> go.Figure:
    """Urgent encounters in which the driver reacts in time, a row for each kind of alert.

    Thick: the interval of the draws (other drivers, these recordings); thin: of both.
    """
    judged = alerts_in(result).in_time_for_drivers
    n = len(judged.chances)
    if not n:
        return empty_figure("Nobody is urgent here.", theme=theme)
    shares = judged.table[judged.table["measure"] == "share"]
    kinds = shares["kind"].unique().tolist()
    traces, others = [], f"<br>other {judged.what_varies}, too: "
    for (letter, system), shift in zip(result.sides, (-APART, APART), strict=True):
        rows = shares[shares["side"] == letter].set_index("kind").loc[kinds]
        place, colour = np.arange(len(kinds)) + shift, LOOK[theme].of(letter)
        for ends, width, opacity in (
            (("low", "high"), 2, 0.8),
            (("draws_low", "draws_high"), 8, 0.35),
        ):
            reach = (100 * rows[end].to_numpy(dtype=float) for end in ends)
            line = {"width": width, "color": faded(colour, opacity)}
            traces.append(still_line(with_gaps(*reach), with_gaps(place, place), "", line=line))
        texts = [
            f"{kind}, {letter.upper()}: in time in {mean:.0%}<br>other drivers: {draws_low:.0%} to "
            f"{draws_high:.0%}" + ("" if np.isnan(low) else f"{others}{low:.0%} to {high:.0%}")
            for kind, mean, draws_low, draws_high, low, high in rows[
                ["mean", "draws_low", "draws_high", "low", "high"]
            ].itertuples()
        ]
        traces.append(
            marks(
                100 * rows["mean"].to_numpy(),
                place,
                texts,
                name=system_label(letter, system.name),
                marker=system_marker(letter, 11, theme),
            )
        )
    return draw(
        traces,
        theme,
        title="Brakes in time, by kind of alert",
        subtitle=f"of {count_text(n, 'urgent encounter')}; thick: other drivers, thin: other "
        f"drivers and {judged.what_varies} (95 %)",
        height=150 + ROW_PX * len(kinds),
        hoverdistance=-1,
        xaxis=axis(theme, "in time (%)", range=[-2, 102], fixedrange=True),
        yaxis=rows_axis(theme, kinds, fixedrange=True),
    )
