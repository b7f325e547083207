"""Margins of X against Y: how long before the last chance each confirms whom."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line
from nvcore.figures.style import (
    CLEAR,
    LOOK,
    axis,
    draw,
    empty_figure,
    plain,
    system_label,
    write,
)
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
"""Margin that is drawn at most; larger ones stand at the edge."""
NEVER: Final = 0.12
"""How far below the least margin who is never confirmed stands, as a share of the span."""
LEAST_SPAN_S: Final = 1.0
"""Margins that the axis shows at least, to either side of the last chance."""


def margins_plot(result: Result, urgent: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Margin of Y over that of X, a mark for each urgent encounter; right and up is earlier.

    Above the diagonal Y is first. Who is never confirmed stands at the edge. `customdata` is the
    row of the last chance in ``dataset.frames`` and that in ``result.encounters``.

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
    low, high, never = _span(urgent)
    if (urgent[["margin_s_x", "margin_s_y"]] > high).any(axis=None):
        extent += f"; margins of more than {high:g} s stand at the edge"
    place = {
        letter: np.where(
            np.isnan(margin := urgent[f"margin_s_{letter}"].to_numpy(dtype=float)),
            never,
            np.clip(margin, low, high),
        )
        for letter in "xy"
    }
    texts = [
        f"{result.objects.singular} {track}, {plain(recording)}<br>{of_both}"
        for of_both, track, recording in zip(
            responses_text(result, urgent.index.to_numpy()),
            urgent["track"],
            urgent["recording"],
            strict=True,
        )
    ]
    places = np.column_stack([urgent["urgent_row"].to_numpy(), urgent.index.to_numpy()])
    ends = [never - 0.06 * (high - low), high + 0.04 * (high - low)]
    line = {"color": look.muted, "width": 1, "dash": "dot"}
    # over all marks, but clear of a word in its corner
    diagonal = [
        low if _is_taken(place, CORNERS["neither"], ends) else low + 0.22 * (high - low),
        high if _is_taken(place, CORNERS["both"], ends) else high - 0.12 * (high - low),
    ]
    traces = [still_line(diagonal, diagonal, "X as early as Y", showlegend=None, line=line)]
    for name in QUADRANTS:
        is_in = (urgent["in_time"] == name).to_numpy()
        if is_in.any():
            traces.append(
                marks(
                    place["x"][is_in],
                    place["y"][is_in],
                    [text for text, is_it in zip(texts, is_in, strict=True) if is_it],
                    customdata=places[is_in],
                    name=f"{WORDS[name]} ({counts[name]:,})",
                    cliponaxis=False,
                    marker=_marker(name, theme),
                )
            )
    figure = draw(
        traces,
        theme,
        title="Margin of X against Y",
        subtitle=extent,
        height=420,
        hoverdistance=24,
        xaxis=_axis("x", result, (low, high, never), ends, theme),
        yaxis=_axis("y", result, (low, high, never), ends, theme),
    )
    for letter in "xy":
        _last_chance(figure, letter, theme)
    for name, (right, up) in CORNERS.items():
        if _is_taken(place, (right, up), ends):
            continue  # the legend has the word as well
        sides: dict[str, Any] = {
            **({"x": 1, "xref": "paper"} if right else {"x": low}),
            **({"y": 1, "yref": "paper"} if up else {"y": low}),
            "xanchor": "right" if right else "left",
            "yanchor": "top" if up else "bottom",
            "xshift": -6 if right else 6,
            "yshift": -4 if up else 4,
        }
        write(figure, WORDS[name], size=12, color=look.muted, **sides)
    return figure


def _is_taken(place: dict[str, np.ndarray], corner: tuple[int, int], ends: list[float]) -> bool:
    """Whether a mark stands where the word of a corner would."""
    span = ends[1] - ends[0]
    from_corner = [
        np.abs(place[letter] - ends[is_high]) / span
        for letter, is_high in zip("xy", corner, strict=True)
    ]
    is_near = (from_corner[0] < WORD_SHARE[0]) & (from_corner[1] < WORD_SHARE[1])
    return bool(is_near.any())


def _span(urgent: pd.DataFrame) -> tuple[float, float, float]:
    """Least and largest margin on both axes, 0 between them; and where those without one stand."""
    margins = urgent[["margin_s_x", "margin_s_y"]].to_numpy(dtype=float)
    known = margins[np.isfinite(margins)]
    low = min(float(known.min(initial=0)) - 0.2, -LEAST_SPAN_S)
    high = min(max(float(known.max(initial=0)), LEAST_SPAN_S), MOST_MARGIN_S)
    return low, high, low - (NEVER if len(known) < margins.size else 0) * (high - low)


def _marker(name: str, theme: Theme) -> dict[str, Any]:
    """The system that alone is in time gives its colour and mark."""
    look = LOOK[theme]
    if name in ("only_x", "only_y"):
        letter = name[-1]
        line = {"width": 1, "color": look.surface}
        return {"color": look.of(letter), "symbol": look.symbol(letter), "size": 12, "line": line}
    if name == "both":
        line = {"width": 1.5, "color": look.muted}
        return {"color": CLEAR, "symbol": "circle", "size": 9, "line": line}
    return {"color": look.ink, "symbol": "x", "size": 10, "line": {"width": 0}}


def _axis(
    letter: str,
    result: Result,
    span: tuple[float, float, float],
    ends: list[float],
    theme: Theme,
) -> dict[str, Any]:
    low, high, never = span
    step = next(step for step in (0.5, 1, 2, 5) if (high - low) / step <= 8 or step == 5)
    ticks = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step + 0.0
    has_never = never < low
    return axis(
        theme,
        f"margin of {system_label(letter, result.system(letter).name)} (s)",
        range=ends,
        fixedrange=True,
        tickvals=[*([never] if has_never else []), *ticks],
        ticktext=[*(["never"] if has_never else []), *(minus(f"{tick:g}") for tick in ticks)],
    )


def _last_chance(figure: go.Figure, letter: str, theme: Theme) -> None:
    """The line of a margin of 0."""
    other = "y" if letter == "x" else "x"
    ends = {f"{letter}0": 0, f"{letter}1": 0, f"{other}ref": "paper", f"{other}0": 0}
    line = {"color": LOOK[theme].ink, "width": 1.2}
    shape = {"type": "line", "name": f"last chance {letter}", "line": line, "layer": "below"}
    figure.add_shape(**shape, **ends, **{f"{other}1": 1})
