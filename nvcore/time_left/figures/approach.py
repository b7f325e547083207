"""Plot of each urgent encounter from first sight to contact, with last chance and confirmations."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line, system_marker, with_gaps
from nvcore.figures.style import (
    CLEAR,
    LOOK,
    axis,
    draw,
    empty_figure,
    faded,
    plain,
    rows_axis,
    system_label,
    written,
)
from nvcore.notes import phrase
from nvcore.palette import Theme
from nvcore.time_left.notes import responses
from nvcore.wording import count_text

MOST_ROWS: Final = 20
"""Encounters drawn, if not fewer are asked for: a screen full."""
MOST_S: Final = 12.0
"""Time before contact that is drawn at most, unless last chances are earlier; what was before
that stands at the edge."""
ROW_PX: Final = 26
TOP_PX: Final = 98
"""Height of heading and legend, which in a narrow window has two rows."""
AXIS_PX: Final = 42
HEAD_PX: Final = 32
"""Height of the titles of the impact speeds, inside the plot: the legend above it may wrap."""
APART: Final = 0.2
"""How far the mark of X stands above a row's middle, and Y's below, in rows."""
BAND: Final = 0.4
"""Half the height of the time that is too late, in rows."""
NEVER: Final = 0.035
"""How far right of contact a system's mark stands that is never sure, as a share of the axis."""
RIGHT_PX: Final = 108
NO_URGENT: Final = "No encounter is urgent: nobody has to be told in time."


def approach_plot(
    result: Result,
    urgent: pd.DataFrame,
    *,
    theme: Theme,
    first: int = 0,
    most: int = MOST_ROWS,
) -> go.Figure:
    """Plot each urgent encounter as a line from the first annotated frame to contact.

    The last chance is a bar; right of it, in the band, it is too late to stop. Filled marks: X and
    Y confirm the pedestrian. Open marks, right of contact: never. A click gives frame and
    encounter: `customdata` is the row in ``dataset.frames`` and that in ``result.encounters``.

    Parameters
    ----------
    urgent
        `nvcore.time_left.encounters.urgent_encounters`: the order is that of its rows.
    first, most
        Rows drawn: so many, from this one on, counted from 0.
    """
    if urgent.empty:
        return empty_figure(NO_URGENT, theme=theme)
    look, part = LOOK[theme], urgent.iloc[first : first + most]
    reach = _reach_s(urgent)
    n, row = len(part), np.arange(len(part), dtype=float)
    ends = [n - 0.4, -0.6 - HEAD_PX / ROW_PX]
    traces = [*_lines(part, row, reach, theme), _last_chances(result, part, row, theme)]
    for letter, _ in result.sides:
        traces += _system_marks(result, part, letter, reach, theme)
    labels = _labels(result, part)
    extent = f"{count_text(len(urgent), 'urgent encounter')}, the fastest impact on top"
    if n < len(urgent):
        extent += f", {first + 1} to {first + n} drawn"
    if (urgent["first_s"] > reach).any():
        extent += f"; what was more than {reach:g} s before contact stands at the left edge"
    return draw(
        [trace for trace in traces if len(trace.x)],
        theme,
        title="From the first sight to contact",
        subtitle=extent,
        height=TOP_PX + HEAD_PX + ROW_PX * n + AXIS_PX,
        hoverdistance=-1,
        margin={"r": RIGHT_PX, "t": TOP_PX},
        annotations=_impacts(part, theme),
        xaxis=axis(
            theme,
            "seconds before contact",
            range=[reach * 1.01, -2 * NEVER * reach],
            fixedrange=True,
            zeroline=True,
            zerolinewidth=1.5,
            zerolinecolor=look.ink,
        ),
        yaxis=rows_axis(theme, labels, range=ends, fixedrange=True, showgrid=False),
    )


def _lines(part: pd.DataFrame, row: np.ndarray, reach: float, theme: Theme) -> list[go.Scatter]:
    """Return a line for each encounter, dotted after its last frame, and the "too late" bands."""
    look, zero = LOOK[theme], np.zeros(len(part))
    start = np.minimum(part["first_s"].to_numpy(), reach)
    stop, chance = np.maximum(part["last_s"].to_numpy(), 0), part["ttc_s"].to_numpy()
    corners = chance, zero, zero, chance, chance
    sides = row - BAND, row - BAND, row + BAND, row + BAND, row - BAND
    line = {"color": look.muted, "width": 2}
    band = {"fill": "toself", "fillcolor": faded(look.pale, 0.55), "line": {"width": 0}}
    return [
        still_line(
            with_gaps(*corners), with_gaps(*sides), "too late to stop", showlegend=None, **band
        ),
        still_line(with_gaps(start, stop), with_gaps(row, row), "annotated", line=line),
        still_line(
            with_gaps(stop, zero),
            with_gaps(row, row),
            "no longer annotated",
            showlegend=None,
            line={**line, "width": 1, "dash": "dot"},
        ),
    ]


def _reach_s(urgent: pd.DataFrame) -> float:
    """Return the left end of the time axis, seconds. It is the same for all parts of the plot."""
    most = max(MOST_S, np.ceil(1.2 * urgent["ttc_s"].max()))  # the last chances are always on it
    return float(min(most, np.ceil(urgent["first_s"].max())))


def _labels(result: Result, part: pd.DataFrame) -> list[str]:
    has_several = len(result.dataset.recordings) > 1
    short = result.objects.say("{short}")
    return [
        f"{short} {plain(track, max_length=8)}"
        + (f", {plain(recording, max_length=20)}" if has_several else "")
        for track, recording in zip(part["track"], part["recording"], strict=True)
    ]


def _places(part: pd.DataFrame, frame_row: np.ndarray) -> np.ndarray:
    """Return what a click on each mark selects: rows of frames and encounters, shape (n, 2)."""
    return np.column_stack([frame_row, part.index.to_numpy()])


def responses_text(result: Result, encounters: np.ndarray) -> list[str]:
    """Return hover texts with a line for each system's response to an urgent encounter.

    Parameters
    ----------
    encounters
        Rows of ``result.encounters``; shape (n,).
    """
    return [
        "<br>".join(phrase(response, result.objects) for response in of_both)
        for of_both in responses(result, encounters)
    ]


def _texts(result: Result, part: pd.DataFrame, frame_row: np.ndarray, what: str) -> list[str]:
    """Return hover texts on a moment of each encounter and on both systems' responses."""
    frames = result.dataset.frames
    columns = (part[name] for name in ("track", "recording", "ttc_s", "speed_kmh"))
    moments = (frames[name].to_numpy()[frame_row] for name in ("frame", "time_s"))
    of_both, noun = responses_text(result, part.index.to_numpy()), result.objects.singular
    return [
        f"{noun} {track}, {plain(recording)}<br>{what}: frame {frame}, {time_s:.2f} s<br>"
        f"last chance {ttc_s:.2f} s before contact, at {speed_kmh:.4g} km/h<br>{of_both_text}"
        for track, recording, ttc_s, speed_kmh, frame, time_s, of_both_text in zip(
            *columns, *moments, of_both, strict=True
        )
    ]


def _last_chances(result: Result, part: pd.DataFrame, row: np.ndarray, theme: Theme) -> go.Scatter:
    """Return a bar for each encounter's last chance."""
    urgent_row, ink = part["urgent_row"].to_numpy(), LOOK[theme].ink
    line = {"width": 3, "color": ink}
    return marks(
        part["ttc_s"].to_numpy(),
        row,
        _texts(result, part, urgent_row, "last chance"),
        customdata=_places(part, urgent_row),
        name="last chance to stop",
        marker={"symbol": "line-ns", "size": 0.55 * ROW_PX, "color": ink, "line": line},
    )


def _system_marks(
    result: Result, part: pd.DataFrame, letter: str, reach: float, theme: Theme
) -> list[go.Scatter]:
    """Return filled marks where a system confirms pedestrians, open ones where it never does."""
    look, system, confirms = (
        LOOK[theme],
        result.system(letter),
        result.objects.say("confirms the {one}"),
    )
    shift = -APART if letter == "x" else APART
    at_s = part[f"confirmed_s_{letter}"].to_numpy()
    row = np.arange(len(part)) + shift
    is_never = np.isnan(at_s)
    confirmed, never = part[~is_never], part[is_never]
    frame_row = confirmed[f"confirmed_row_{letter}"].to_numpy()
    sure = marks(
        np.clip(at_s[~is_never], 0, reach),
        row[~is_never],
        _texts(result, confirmed, frame_row, f"{letter.upper()} {confirms}"),
        customdata=_places(confirmed, frame_row),
        cliponaxis=False,
        name=f"{system_label(letter, system.name)} confirms",
        marker=system_marker(letter, 11, theme),
    )
    urgent_row = never["urgent_row"].to_numpy()
    line: dict[str, Any] = {"width": 2, "color": look.of(letter)}
    unsure = marks(
        np.full(len(never), -NEVER * reach),
        row[is_never],
        _texts(result, never, urgent_row, "last chance"),
        customdata=_places(never, urgent_row),
        cliponaxis=False,
        name=f"{letter.upper()} never",
        showlegend=False,
        marker={"symbol": look.symbol(letter), "size": 10, "color": CLEAR, "line": line},
    )
    return [sure, unsure]


def _impacts(part: pd.DataFrame, theme: Theme) -> list[dict[str, Any]]:
    """Return impact speeds as two columns of text right of the plot, muted if the car stops."""
    look = LOOK[theme]
    columns = {"x": 48, "y": RIGHT_PX - 16}
    side: dict[str, Any] = {"xref": "paper", "x": 1, "xanchor": "right", "size": 12}
    head: dict[str, Any] = {**side, "yref": "y", "y": -0.6, "yanchor": "bottom"}
    head["color"] = look.muted
    texts = [written("impact, km/h", xshift=columns["y"], yshift=16, **head)]
    texts += [written(letter.upper(), xshift=shift, **head) for letter, shift in columns.items()]
    for place, row in enumerate(part.to_dict("records")):
        for letter, shift in columns.items():
            value = float(row[f"impact_kmh_{letter}"])
            text, colour = (f"<b>{value:.0f}</b>", look.of(letter)) if value else ("0", look.muted)
            texts.append(written(text, yref="y", y=place, xshift=shift, color=colour, **side))
    return texts
