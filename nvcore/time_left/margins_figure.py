"""Margins of X against Y: how long before the last chance each confirms whom."""

from __future__ import annotations

from itertools import compress
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line, system_marker
from nvcore.figures.style import CLEAR, LOOK, axis, draw, empty_figure, plain, system_label, written
from nvcore.palette import Theme
from nvcore.time_left.encounters import QUADRANTS, count_in_time
from nvcore.time_left.figures import NO_URGENT, responses_text
from nvcore.wording import count_text, minus

WORDS: Final = {
    "both": "both in time",
    "only_x": "only X in time",
    "only_y": "only Y in time",
    "neither": "neither in time",
}
"""Who confirmed an urgent encounter in time."""
CORNERS: Final = {"both": (1, 1), "only_x": (1, 0), "only_y": (0, 1), "neither": (0, 0)}
"""Corner of the plot of each, as shares of its width and height."""
WORD_SHARE: Final = (0.3, 0.2)
"""Part of the plot's width and height that is kept free for the word in a corner."""
MOST_MARKS: Final = 2000
"""Encounters drawn: those with the fastest impacts."""
MOST_MARGIN_S: Final = 8.0
"""Largest margin that the axes show. Larger ones stand at the edge."""
NEVER: Final = 0.12
"""Distance from the least margin to encounters that are never confirmed, as a share of the span."""
LEAST_SPAN_S: Final = 1.0
"""Margins that the axis shows at least, to either side of the last chance."""


def margins_plot(result: Result, urgent: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot the margin of Y over that of X, a mark for each urgent encounter: up is earlier.

    Above the diagonal Y is first. Encounters that are never confirmed stand at the edge.
    `customdata` is the row of the last chance in ``dataset.frames`` and that in
    ``result.encounters``.

    Parameters
    ----------
    urgent
        `nvcore.time_left.encounters.urgent_encounters`.
    """
    if urgent.empty:
        return empty_figure(NO_URGENT, theme=theme)
    look, counts = LOOK[theme], count_in_time(urgent)
    extent = f"{count_text(len(urgent), 'urgent encounter')}: " + ", ".join(
        f"{WORDS[name]} {counts[name]:,}" for name in QUADRANTS
    )
    if len(urgent) > MOST_MARKS:
        extent += f"; the {MOST_MARKS:,} with the fastest impacts drawn"
    urgent = urgent.head(MOST_MARKS)
    margins = urgent[["margin_s_x", "margin_s_y"]].to_numpy(dtype=float)
    low = min(float(np.nanmin(margins, initial=0)) - 0.2, -LEAST_SPAN_S)
    high = min(max(float(np.nanmax(margins, initial=0)), LEAST_SPAN_S), MOST_MARGIN_S)
    span, is_never = high - low, np.isnan(margins)
    never = low - NEVER * span if is_never.any() else low
    if (margins > high).any():
        extent += f"; margins of more than {high:g} s stand at the edge"
    place = np.where(is_never, never, np.clip(margins, low, high))
    ends = [never - 0.06 * span, high + 0.04 * span]
    is_taken = {
        name: (np.abs(place - np.take(ends, corner)) < np.diff(ends) * WORD_SHARE).all(axis=1).any()
        for name, corner in CORNERS.items()
    }
    # over all marks, but clear of a word in its corner
    diagonal = [
        low if is_taken["neither"] else low + 0.22 * span,
        high if is_taken["both"] else high - 0.12 * span,
    ]
    line = {"color": look.muted, "width": 1, "dash": "dot"}
    traces = [still_line(diagonal, diagonal, "X as early as Y", showlegend=None, line=line)]
    texts = [
        f"{result.objects.singular} {track}, {plain(recording)}<br>{of_both}"
        for of_both, track, recording in zip(
            responses_text(result, urgent.index.to_numpy()),
            urgent["track"],
            urgent["recording"],
            strict=True,
        )
    ]
    rows = np.column_stack([urgent["urgent_row"].to_numpy(), urgent.index.to_numpy()])
    clear = {"color": CLEAR, "symbol": "circle", "size": 9}
    looks = {
        "both": clear | {"line": {"width": 1.5, "color": look.muted}},
        "only_x": system_marker("x", 12, theme),
        "only_y": system_marker("y", 12, theme),
        "neither": {"color": look.ink, "symbol": "x", "size": 10, "line": {"width": 0}},
    }
    for name in QUADRANTS:
        is_in = (urgent["in_time"] == name).to_numpy()
        if is_in.any():
            mark = marks(
                place[is_in, 0],
                place[is_in, 1],
                [*compress(texts, is_in)],
                customdata=rows[is_in],
                name=f"{WORDS[name]} ({counts[name]:,})",
                cliponaxis=False,
                marker=looks[name],
            )
            traces.append(mark)
    step = next(step for step in (0.5, 1, 2, 5) if span / step <= 8 or step == 5)
    ticks = (np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0).tolist()
    ticktext = [minus(f"{tick:g}") for tick in ticks]
    if is_never.any():
        ticks, ticktext = [never, *ticks], ["never", *ticktext]
    scale = {"range": ends, "fixedrange": True, "tickvals": ticks, "ticktext": ticktext}
    along, up = (
        axis(theme, f"margin of {system_label(letter, system.name)} (s)", **scale)
        for letter, system in result.sides
    )
    figure = draw(
        traces,
        theme,
        title="Margin of X against Y",
        subtitle=extent,
        height=420,
        hoverdistance=24,
        xaxis=along,
        yaxis=up,
    )
    for letter, other in ("xy", "yx"):  # the last chance: a margin of 0
        sides = {f"{letter}0": 0, f"{letter}1": 0, f"{other}ref": "paper", f"{other}0": 0}
        line = {"color": look.ink, "width": 1.2}
        shape = {"type": "line", "name": f"last chance {letter}", "line": line, "layer": "below"}
        figure.add_shape(**shape, **sides, **{f"{other}1": 1})
    # of a corner where a mark stands the legend has the word
    figure.update_layout(
        annotations=[
            written(WORDS[name], size=12, color=look.muted, **_corner(*corner, low))
            for name, corner in CORNERS.items()
            if not is_taken[name]
        ]
    )
    return figure


def _corner(right: int, up: int, low: float) -> dict[str, Any]:
    """Return the place of a word in a corner: at an edge of the plot or at the least margin."""
    x, y = (
        {letter: 1, f"{letter}ref": "paper"} if is_high else {letter: low}
        for letter, is_high in (("x", right), ("y", up))
    )
    anchors = {"xanchor": "right" if right else "left", "yanchor": "top" if up else "bottom"}
    return {**x, **y, **anchors, "xshift": -6 if right else 6, "yshift": -4 if up else 4}
