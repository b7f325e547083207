"""Dots with intervals: differences of subgroups, pairs of recordings, and the power of studies."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from itertools import chain
from typing import Any, Final, Literal

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import capitalised, count_text, number, percent
from nvcore.comparison.measures.entry import HIGHER
from nvcore.comparison.measures.table import difference_text, inference_of, measure_of
from nvcore.evidence.planning.notes import ASSUMPTIONS
from nvcore.evidence.planning.plan import Plan
from nvcore.evidence.subgroups import ALL
from nvcore.figures.marks import click_markers, curve_line, joined, marks, row_texts
from nvcore.figures.style import LETTER_PX, LOOK, Names, plain, which_is_which, written

MOST_GROUPS: Final = 40
MAX_RECORDINGS: Final = 40
"""Maximum number of recordings drawn, those with the largest differences first."""

ByRecording = Literal["mean_similarity", "saliency"]


AXES: Final[dict[ByRecording, tuple[str, str, tuple[float, float]]]] = {
    "mean_similarity": ("Similarity by recording", "mean similarity (1 = perfect)", (0.5, 1.0)),
    "saliency": ("Saliency by recording", "saliency (s, 0 = nothing to notice)", (0.0, 1.0)),
}
"""Titles of figure and axis, and the least range shown, so that small gains look small."""


def forest_in_words(subgroups: pd.DataFrame) -> str:
    """Return the sentence that replaces a forest plot without anything to compare, else "".

    Parameters
    ----------
    subgroups
        As for `subgroup_forest`.
    """
    defined = subgroups[np.isfinite(subgroups["difference"].to_numpy(dtype=float))]
    groups = defined[defined["factor"] != ALL]
    if defined.empty or (len(groups) and defined["difference"].any()):
        return ""
    label = capitalised(str(defined["label"].iloc[0]))
    if groups.empty:
        return f"{label}: there are no groups to compare."
    return f"{label}: X and Y are the same in all {count_text(len(groups), 'group')}."


def subgroup_forest(subgroups: pd.DataFrame, *, theme: Theme) -> go.Figure:
    """Plot the difference X - Y of one measure with its 95 % interval in each group.

    Groups in which it is undefined are left out.

    Parameters
    ----------
    subgroups
        `nvcore.evidence.subgroups.table.subgroup_table` of one measure.
    """
    look, is_defined = LOOK[theme], np.isfinite(subgroups["difference"].to_numpy(dtype=float))
    table = subgroups[is_defined].head(MOST_GROUPS)
    if table.empty:
        return look.empty("There is no group in which this measure is defined.")
    key, label, better, unit = table[["figure", "label", "better", "unit"]].iloc[0]
    scale = inference_of(key).scale
    difference, low, high = (100.0 if scale.is_share else 1.0) * table[
        ["difference", "low", "high"]
    ].to_numpy(dtype=float).T
    gain = difference if better == HIGHER else -difference
    has_interval = np.isfinite(low) & np.isfinite(high)
    rows, place = table.to_dict("records"), np.arange(len(table), dtype=float)
    differences = marks(
        difference,
        place,
        [_group_text(row) for row in rows],
        name="difference",
        showlegend=False,
        marker={
            "color": np.where(gain > 0, look.x, np.where(gain < 0, look.y, look.muted)),
            "size": 7 + 9 * np.sqrt(table["n"] / table["n"].max()),
            "symbol": np.where(has_interval, "square", "square-open"),
        },
    )
    factors = table["factor"].replace({"tag": "recordings tagged"})
    labels = [
        "<b>all</b>" if factor == ALL else f"{factor}: {plain(group)}"
        for factor, group in zip(factors, table["group"], strict=True)
    ]
    form, beside = scale.form.lstrip(","), {"x": 1.01, "xref": "x domain", "xanchor": "left"}
    words = [
        f"{row['n']:,}: X {number(row['x'], form)}, Y {number(row['y'], form)}{_corrected(row)}"
        for row in rows
    ]
    counts = [
        written(text, size=12, color=look.muted, y=y, **beside)
        for text, y in zip(words, place, strict=True)
    ]
    n_most = count_text(int(table["n"].max()), unit.removesuffix("s"))
    near = " near enough to count" if unit == "encounters" else ""
    axis_unit = "percentage points" if scale.is_share else scale.unit
    side = "right" if better == HIGHER else "left"
    values = np.concatenate([difference, low, high, [0.0]])
    least, most = float(np.nanmin(values)), float(np.nanmax(values))
    room = 0.05 * max(most - least, scale.least)
    figure = look.draw(
        [joined(low, high, place, "95 % interval", color=look.muted, width=2), differences],
        title=f"{plain(capitalised(label), max_length=80)}: X minus Y, by group",
        subtitle=f"{n_most}{near}; larger squares: more {unit}; open: no interval; "
        f"in brackets: p corrected for all groups{which_is_which(theme)}",
        height=130 + 30 * len(table),
        showlegend=False,
        margin={"r": LETTER_PX * max(map(len, words))},
        xaxis=look.axis(
            f"difference{f' in {axis_unit}' if axis_unit else ''} ({side}: X is better)",
            can_zoom=True,
            range=[least - room, most + room],
        ),
        yaxis=look.rows_axis(labels, room=0.5, tickvals=place.tolist(), showgrid=False),
        annotations=counts,
    )
    return figure.add_vline(0, line={"color": look.ink, "width": 1})


def _corrected(row: dict[Hashable, Any]) -> str:
    """Return p of all encounters, or p of a group with the p corrected for all groups."""
    p, p_corrected = float(row["p"]), float(row["p_corrected"])
    if row["factor"] == ALL:
        return f"; p {p:.2g}" if np.isfinite(p) else ""
    return f"; p {p:.2g} ({p_corrected:.2g})" if np.isfinite(p_corrected) else ""


def _group_text(row: dict[Hashable, Any]) -> str:
    """Return the hover text of a group."""
    counts = (
        f"both {row['both']:,}, only X {row['x_only']:,}, only Y {row['y_only']:,}, neither "
        f"{row['neither']:,}"
    )
    of = f"{row['n']:,} {row['unit']}"
    parts = [of, f"encounters detected by {counts}"]
    if row["unit"] == "encounters":
        parts = [f"of {of}: {counts}"]
    p, holm = float(row["p"]), float(row["p_corrected"])
    if np.isfinite(p):
        parts.append(f"p = {p:.2g}" + (f", {holm:.2g} for all groups" if np.isfinite(holm) else ""))
    if row["note"]:
        parts += [plain(note, max_length=200) for note in row["note"].split("; ")]
    return "<br>".join(parts)


def recordings_plot(
    recordings: pd.DataFrame,
    names: Names,
    *,
    theme: Theme,
    measure: ByRecording = "mean_similarity",
) -> go.Figure:
    """Plot X and Y joined by a line for each recording.

    The more X is better, the higher a recording stands. The subtitle says in how many it is better.
    `customdata` is the recording's row.

    Parameters
    ----------
    recordings
        `nvcore.tables.result.recordings_table`, or rows of it with the same index.
    measure
        ``mean_similarity`` (1 is best) or ``saliency`` (0 is best).
    """
    look = LOOK[theme]
    title, axis_title, least = AXES[measure]
    values = recordings[[f"{measure}_x", f"{measure}_y"]].to_numpy(dtype=float)
    recordings, values = (part[np.isfinite(values).all(axis=1)] for part in (recordings, values))
    if recordings.empty:
        return look.empty("There is no recording to compare.")
    gain = values[:, 0] - values[:, 1]
    if measure_of(measure).better != HIGHER:
        gain = values[:, 1] - values[:, 0]
    largest = np.argsort(-np.abs(gain), kind="stable")[:MAX_RECORDINGS]
    largest = largest[np.argsort(-gain[largest], kind="stable")]
    x, y = values[largest].T
    labels = [plain(name, max_length=24) for name in recordings["recording"].to_numpy()[largest]]
    rows, place = recordings.index.to_numpy()[largest], np.arange(len(largest), dtype=float)
    template = "{label}<br>X {x:.3f}   Y {y:.3f}   X − Y {gain:+.3f}"
    text = row_texts(template, label=labels, x=x, y=y, gain=x - y)
    systems = [
        look.marks(letter, name, 11, along, place, text, customdata=rows)
        for letter, name, along in zip("xy", names, (x, y), strict=True)
    ]
    extent = count_text(len(gain), "recording")
    has_all = len(gain) == len(largest)
    if not has_all:
        extent += f", the {len(largest)} that differ most drawn"
    if len(gain) > 1:
        extent += f"; X is better in {int((gain > 0).sum()):,}, Y in {int((gain < 0).sum()):,}"
        extent += "; best for X on top" if has_all else ""  # no room for both
    low, high = min(least[0], values[largest].min()), max(least[1], values[largest].max())
    room = 0.03 * (high - low)
    ends = [low - room, high + room]
    return look.draw(
        [
            joined(x, y, place, "difference", width=3, color=look.pale),
            *systems,
            click_markers((x + y) / 2, place, text, customdata=rows, name="recordings"),
        ],
        title=title,
        subtitle=extent,
        height=150 + 24 * len(largest),
        hoverdistance=-1,
        xaxis=look.axis(axis_title, begins=ends[0], can_zoom=True, range=ends),
        yaxis=look.rows_axis(labels, tickvals=place),
    )


def power_plot(plan: Plan, *, theme: Theme) -> go.Figure:
    """Plot the share of simulated studies that show the effect, with a line per assumption.

    Bars are 95 % Monte Carlo intervals. The level line is the desired power.
    """
    look, sizes = LOOK[theme], [size for size in plan.sizes if size.points]
    if not sizes:
        return look.empty("No study was simulated.")
    traces = []
    looks = (("solid", "circle", look.ink), ("dash", "diamond", look.muted))
    for size, (dash, symbol, colour) in zip(sizes, looks, strict=False):
        points, name = size.points, ASSUMPTIONS[size.assumption]
        if size.assumption != "equal":
            name += f" ({difference_text(size.difference, plan.evidence.figure)})"
        interval = {
            "type": "data",
            "symmetric": False,
            "array": [point.high - point.power for point in points],
            "arrayminus": [point.power - point.low for point in points],
            "thickness": 1,
            "width": 0,
        }
        texts = [
            f"{count_text(point.n_recordings, 'recording')}<br>{percent(point.power)} of "
            f"{point.n_studies:,} studies ({percent(point.low)} to {percent(point.high)})"
            for point in points
        ]
        line = curve_line(
            [point.n_recordings for point in points],
            [point.power for point in points],
            texts,
            error_y=interval,
            line={"color": colour, "width": 1.5, "dash": dash},
            marker={"color": colour, "symbol": symbol, "size": 7},
            name=name,
            showlegend=True,
        )
        traces.append(line)
    numbers = list(chain(*(trace.x for trace in traces)))
    along = look.axis("recordings", can_zoom=True, rangemode="tozero")
    if max(numbers) > 8 * min(numbers):
        along = look.axis("recordings, logarithmic", can_zoom=True, **_log_ticks(numbers))
    figure = look.draw(
        traces,
        title="How many recordings would show it",
        subtitle=f"{plan.evidence.label}; simulated from "
        f"{count_text(plan.evidence.n, 'recording')} with "
        f"{count_text(plan.n_encounters, 'encounter')}{which_is_which(theme)}",
        height=340,
        xaxis=along,
        yaxis=look.axis(
            "power: share of studies that show it", can_zoom=True, range=[0, 1], tickformat=".0%"
        ),
    )
    font = {"size": 12, "color": look.muted}
    words = {"text": percent(plan.power), "xanchor": "right", "font": font}
    return figure.add_hline(plan.power, line=look.dotted, annotation=words)


def _log_ticks(numbers: Sequence[int]) -> dict[str, Any]:
    """Return settings of a logarithmic axis with ticks at 1, 2, 5, 10, 20 and so on."""
    powers = range(len(str(max(numbers))))
    ticks = [digit * 10**power for power in powers for digit in (1, 2, 5)]
    ticks = [tick for tick in ticks if min(numbers) <= tick <= max(numbers)]
    return {"type": "log", "tickvals": ticks, "ticktext": [f"{tick:,}" for tick in ticks]}
