"""Who detects more in each part of the encounters: differences with their intervals."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.figures.style import LOOK, axis, count_text, empty_figure, layout, plain
from nvcore.palette import Theme
from nvcore.subgroups import ALL

ROW_PX: Final = 30
MOST_GROUPS: Final = 40
FACTOR_WORDS: Final = {
    "distance": "distance", "place": "place", "occlusion": "occlusion", "pose": "pose",
    "tag": "recordings tagged",
}  # fmt: skip


def subgroup_forest(subgroups: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Difference in the share of encounters detected, X - Y, with its 95 % interval, by group.

    Parameters
    ----------
    subgroups
        `nvcore.subgroups.subgroup_table`.
    """
    table = subgroups.head(MOST_GROUPS)
    if table.empty or not np.isfinite(table["difference"]).any():
        return empty_figure("There is no encounter near enough to count.", theme=theme)
    look = LOOK[theme]
    place = np.arange(len(table), dtype=float)
    difference, low, high = (
        100 * table[name].to_numpy(dtype=float) for name in ("difference", "low", "high")
    )
    has_interval = np.isfinite(low) & np.isfinite(high)
    text = [_text(row) for row in table.to_dict("records")]
    nan = np.full(len(table), np.nan)
    intervals = go.Scatter(
        x=np.column_stack([low, high, nan]).ravel(), y=np.column_stack([place, place, nan]).ravel(),
        mode="lines", line={"color": look.muted, "width": 2}, hoverinfo="skip", showlegend=False,
        name="95 % interval",
    )  # fmt: skip
    leaning = np.where(difference > 0, look.x, np.where(difference < 0, look.y, look.muted))
    points = go.Scatter(
        x=difference, y=place, mode="markers", text=text, hovertemplate="%{text}<extra></extra>",
        showlegend=False, name="difference",
        marker={"color": leaning, "size": 7 + 9 * np.sqrt(table["n"] / table["n"].max()),
                "symbol": np.where(has_interval, "square", "square-open")},
    )  # fmt: skip
    labels = [
        "<b>all</b>" if row["factor"] == ALL
        else f"{FACTOR_WORDS.get(row['factor'], row['factor'])}: {plain(row['group'])}"
        for row in table.to_dict("records")
    ]  # fmt: skip
    counts = [
        f"{row['n']:,}: X {row['x']:.0%}, Y {row['y']:.0%}" for row in table.to_dict("records")
    ]
    figure = go.Figure(
        [intervals, points],
        layout(
            theme, title="Encounters detected, X less Y, by group",
            subtitle=f"{count_text(int(table['n'].iloc[0]), 'encounter')} near enough to count; "
            "larger squares: more encounters; open: too few for an interval",
            height=130 + ROW_PX * len(table), showlegend=False,
            margin={"l": 190, "r": 150, "t": 64, "b": 48},
            xaxis=axis(
                theme, "difference in percentage points (right: X detects more)",
                range=_range(difference, low, high),
            ),
            yaxis=axis(theme)
            | {"tickvals": place.tolist(), "ticktext": labels, "showgrid": False,
               "range": [len(table) - 0.5, -0.5], "fixedrange": True},
        ),
    )  # fmt: skip
    figure.add_vline(0, line={"color": look.ink, "width": 1})
    for at, words in zip(place, counts, strict=True):
        figure.add_annotation(
            x=1.01, xref="x domain", y=at, text=words, showarrow=False, xanchor="left",
            font={"size": 12, "color": look.muted},
        )  # fmt: skip
    return figure


def _range(difference: np.ndarray, low: np.ndarray, high: np.ndarray) -> list[float]:
    """Ends of the axis, with room beside every interval."""
    values = np.concatenate([difference, low, high, [0.0]])
    least, most = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.05 * max(most - least, 1.0)
    return [least - room, most + room]


def _text(row: dict[Hashable, Any]) -> str:
    """What pointing at a group says."""
    parts = [
        f"{row['n']:,} encounters: both {row['both']}, only X {row['x_only']}, only Y "
        f"{row['y_only']}, neither {row['neither']}"
    ]
    p = float(row["p"])
    if np.isfinite(p):
        holm = float(row["p_holm"])
        parts.append(f"p = {p:.2g}" + (f", {holm:.2g} for all groups" if np.isfinite(holm) else ""))
    if row["note"]:
        parts.append(str(row["note"]).replace("; ", "<br>"))
    return "<br>".join(parts)
