"""A measure for each part of the encounters: differences with their intervals."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.evidence.subgroups import ALL
from nvcore.figures.marks import marks, still_line, with_gaps
from nvcore.figures.style import (
    LETTER_PX,
    LOOK,
    axis,
    draw,
    empty_figure,
    plain,
    rows_axis,
    which_is_which,
    written,
)
from nvcore.measures.table import inference_of
from nvcore.palette import Theme
from nvcore.wording import capitalised, count_text, number

ROW_PX: Final = 30
MOST_GROUPS: Final = 40
FACTOR_WORDS: Final = {"tag": "recordings tagged"}
"""Of factors that are not called by their own name."""


def forest_in_words(subgroups: pd.DataFrame) -> str:
    """What a forest plot would say that has nothing to compare; empty: it has.

    Parameters
    ----------
    subgroups
        As for `subgroup_forest`.
    """
    defined = subgroups[np.isfinite(subgroups["difference"].to_numpy(dtype=float))]
    groups = defined[defined["factor"] != ALL]
    if defined.empty or (len(groups) and defined["difference"].any()):
        return ""
    label = str(defined["label"].iloc[0])
    if groups.empty:
        return f"{capitalised(label)}: there are no groups to compare."
    n = count_text(len(groups), "group")
    return f"{capitalised(label)}: X and Y are the same in all {n}."


def subgroup_forest(subgroups: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Difference X - Y of one measure with its 95 % interval, by group; undefined ones left out.

    Parameters
    ----------
    subgroups
        `nvcore.evidence.subgroup_table.subgroup_table` of one measure.
    """
    is_defined = np.isfinite(subgroups["difference"].to_numpy(dtype=float))
    table = subgroups[is_defined].head(MOST_GROUPS)
    if table.empty:
        return empty_figure("There is no group in which this measure is defined.", theme=theme)
    key, label, better, unit = table[["figure", "label", "better", "unit"]].iloc[0]
    scale = inference_of(key).scale
    factor = 100.0 if scale.is_share else 1.0
    look = LOOK[theme]
    place = np.arange(len(table), dtype=float)
    difference, low, high = (
        factor * table[name].to_numpy(dtype=float) for name in ("difference", "low", "high")
    )
    has_interval = np.isfinite(low) & np.isfinite(high)
    intervals = still_line(
        with_gaps(low, high),
        with_gaps(place, place),
        "95 % interval",
        line={"color": look.muted, "width": 2},
    )
    gain = difference if better == "higher" else -difference
    marker = {
        "color": np.where(gain > 0, look.x, np.where(gain < 0, look.y, look.muted)),
        "size": 7 + 9 * np.sqrt(table["n"] / table["n"].max()),
        "symbol": np.where(has_interval, "square", "square-open"),
    }
    rows = table.to_dict("records")
    differences = marks(
        difference,
        place,
        [_text(row) for row in rows],
        name="difference",
        marker=marker,
        showlegend=False,
    )
    labels = [
        "<b>all</b>"
        if row["factor"] == ALL
        else f"{FACTOR_WORDS.get(row['factor'], row['factor'])}: {plain(row['group'])}"
        for row in rows
    ]
    n_most = count_text(int(table["n"].max()), unit.removesuffix("s"))
    title = plain(capitalised(label), max_length=80)
    near = " near enough to count" if unit == "encounters" else ""
    side = "right" if better == "higher" else "left"
    fixed = {"tickvals": place.tolist(), "showgrid": False, "fixedrange": True}
    axis_unit = "percentage points" if scale.is_share else scale.unit
    in_unit = f" in {axis_unit}" if axis_unit else ""
    ends = _range(difference, low, high, least=scale.least)
    counts = [
        written(
            f"{row['n']:,}: X {number(row['x'], scale.form.lstrip(','))}, "
            f"Y {number(row['y'], scale.form.lstrip(','))}{_corrected(row)}",
            size=12,
            color=look.muted,
            x=1.01,
            xref="x domain",
            y=y,
            xanchor="left",
        )
        for y, row in zip(place, rows, strict=True)
    ]
    figure = draw(
        [intervals, differences],
        theme,
        title=f"{title}: X minus Y, by group",
        subtitle=f"{n_most}{near}; larger squares: more {unit}; open: no interval; "
        f"in brackets: p corrected for all groups{which_is_which(theme)}",
        height=130 + ROW_PX * len(table),
        showlegend=False,
        margin={"r": LETTER_PX * max(len(count["text"]) for count in counts)},
        xaxis=axis(theme, f"difference{in_unit} ({side}: X is better)", range=ends),
        yaxis=rows_axis(theme, labels, room=0.5, **fixed),
        annotations=counts,
    )
    figure.add_vline(0, line={"color": look.ink, "width": 1})
    return figure


def _range(
    difference: np.ndarray, low: np.ndarray, high: np.ndarray, *, least: float
) -> list[float]:
    """Ends of the axis, with room beside every interval."""
    values = np.concatenate([difference, low, high, [0.0]])
    start, end = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.05 * max(end - start, least)
    return [start - room, end + room]


def _corrected(row: dict[Hashable, Any]) -> str:
    """The p of all encounters; of a group with the p that allows for all groups, or none."""
    p, p_corrected = float(row["p"]), float(row["p_corrected"])
    if row["factor"] == ALL:
        return f"; p {p:.2g}" if np.isfinite(p) else ""
    return f"; p {p:.2g} ({p_corrected:.2g})" if np.isfinite(p_corrected) else ""


def _text(row: dict[Hashable, Any]) -> str:
    """What pointing at a group says."""
    counts = (
        f"both {row['both']:,}, only X {row['x_only']:,}, only Y {row['y_only']:,}, neither "
        f"{row['neither']:,}"
    )
    of = f"{row['n']:,} {row['unit']}"
    if row["unit"] == "encounters":
        parts = [f"of {of}: {counts}"]
    else:
        parts = [of, f"encounters detected by {counts}"]
    p = float(row["p"])
    if np.isfinite(p):
        holm = float(row["p_corrected"])
        parts.append(f"p = {p:.2g}" + (f", {holm:.2g} for all groups" if np.isfinite(holm) else ""))
    if row["note"]:
        parts += [plain(note, max_length=200) for note in row["note"].split("; ")]
    return "<br>".join(parts)
