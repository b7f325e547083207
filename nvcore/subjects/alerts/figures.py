"""Figures of alerts: over time, against unwanted ones, and the share that is in time."""

from __future__ import annotations

from itertools import product
from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.common.palette import Theme
from nvcore.common.wording import LEAST_HOURLY_S, count_text, duration_text, number
from nvcore.comparison.compare import Result
from nvcore.figures.marks import joined, marks, row_texts
from nvcore.figures.over_time import OverTime
from nvcore.figures.style import LOOK, faded, system_label
from nvcore.subjects.alerts.episodes import UNWANTED, AlertKind
from nvcore.subjects.alerts.steps import alerts_in

ROW_PX: Final = 22
KIND_PX: Final = 64
APART: Final = 0.16
"""Distance of X and Y from the middle of a row, in rows."""
POINTS: Final = (("policy", 5, ""), ("in use", 13, ", in use"), ("log", 15, ", its log"))
"""Points of the trade-off: size of their marks, and suffix of their name."""


def alerts_over_time(result: Result, recording: int, theme: Theme) -> go.Figure:
    """Draw a row for each system and kind, with a bar for each alert from its onset on.

    `customdata` of the mark at the onset is its row in ``dataset.frames`` and the row of the
    encounter in ``result.encounters`` (-1: no encounter).

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    """
    look, view, noun = LOOK[theme], alerts_in(result), result.objects.singular
    alerts = pd.concat([view.of(system) for _, system in result.sides], ignore_index=True)
    table = view.table.assign(row=alerts["first_row"], whom=alerts["encounter"])
    table = table[alerts["recording"] == recording]
    traces: list[go.Scatter] = []
    labels: list[str] = []
    for letter, kind in product("xy", AlertKind):
        own = table[(table["system"] == letter) & (table["kind"] == kind.value)]
        if own.empty:
            continue
        place, start_s = np.full(len(own), float(len(labels))), own["start_s"].to_numpy()
        labels.append(f"{letter.upper()} {kind.value}")
        end_s = start_s + own["duration_s"].to_numpy()
        traces.append(joined(start_s, end_s, place, "", width=9, color=look.of(letter)))
        texts = row_texts(
            "{letter}, {kind}: frame {frame}, {start_s:.2f} s, for {duration_s:.1f} s{whom}",
            letter=letter.upper(),
            kind=kind.value,
            frame=own["start_frame"],
            start_s=start_s,
            duration_s=own["duration_s"],
            whom=["" if pd.isna(who) else f"<br>{noun} {who}" for who in own["encounter"]],
        )
        looks = {"customdata": own[["row", "whom"]].to_numpy(), "name": labels[-1]}
        traces.append(look.marks(letter, "", 10, start_s, place, texts, **looks))
    if not labels:
        return look.empty("Nothing alerts the driver in this recording.")
    over_time = OverTime(result, recording, look)
    return over_time.draw(
        traces,
        "",
        "Alerts",
        subtitle=count_text(len(table), "alert"),
        height=100 + ROW_PX * len(labels),
        showlegend=False,
        xaxis=over_time.axis(ticksuffix=" s"),
        yaxis=look.rows_axis(labels, showgrid=False),
    )


def alerts_in_time(result: Result, *, theme: Theme) -> go.Figure:
    """Draw the share of urgent encounters in which the driver reacts in time, by kind of alert.

    Thick: outcomes with other drivers on these recordings; thin: those of another study as large.
    """
    look, judged = LOOK[theme], alerts_in(result).in_time_for_drivers
    n = len(judged.chances)
    if not n:
        return look.empty("Nobody is urgent here.")
    shares = judged.table[judged.table["measure"] == "share"]
    kinds = shares["kind"].unique().tolist()
    traces, others = [], "<br>another study as large: "
    for (letter, system), shift in zip(result.sides, (-APART, APART), strict=True):
        rows = shares[shares["side"] == letter].set_index("kind").loc[kinds]
        place, colour = np.arange(len(kinds)) + shift, look.of(letter)
        for draws, width, opacity in (("", 2, 0.8), ("draws_", 8, 0.35)):
            low, high = 100 * rows[[f"{draws}low", f"{draws}high"]].to_numpy(dtype=float).T
            traces.append(joined(low, high, place, "", width=width, color=faded(colour, opacity)))
        texts = [
            f"{kind}, {letter.upper()}: in time in {row['mean']:.0%}<br>other drivers here: "
            f"{row['draws_low']:.0%} to {row['draws_high']:.0%}"
            + ("" if np.isnan(row["low"]) else f"{others}{row['low']:.0%} to {row['high']:.0%}")
            for kind, row in rows.iterrows()
        ]
        means = 100 * rows["mean"].to_numpy()
        traces.append(look.marks(letter, system.name, 11, means, place, texts))
    return look.draw(
        traces,
        title="Brakes in time, by kind of alert",
        subtitle=f"of {count_text(n, 'urgent encounter')}; thick: other drivers, thin: another "
        f"study with other drivers and {judged.what_varies} (95 %)",
        height=150 + KIND_PX * len(kinds),
        hoverdistance=-1,
        xaxis=look.axis("in time (%)", range=[-2, 102]),
        yaxis=look.rows_axis(kinds),
    )


def alert_trade_off(result: Result, *, theme: Theme) -> go.Figure:
    """Draw urgent encounters alerted in time over unwanted alerts an hour.

    Each system has a line over its score threshold under the current policy, a large mark at its
    threshold, and a star for its own log. `customdata` is the threshold. For short recordings the
    number replaces the rate per hour.
    """
    look, view, duration_s = LOOK[theme], alerts_in(result), result.duration_s
    n_urgent = view.n_urgent
    if not n_urgent:
        return look.empty("No encounter is urgent: nobody has to be alerted in time.")
    is_short = duration_s < LEAST_HOURLY_S
    traces: list[go.Scatter] = []
    for (letter, system), (of, size, ending) in product(result.sides, POINTS):
        points = view.curve[(view.curve["system"] == letter) & (view.curve["of"] == of)]
        if points.empty:
            continue
        looks: dict[str, Any] = {"cliponaxis": False}
        looks["name"] = system_label(letter, system.name) + ending
        looks["marker"] = look.marker(letter, size) | ({"symbol": "star"} if of == "log" else {})
        if of == "policy":
            looks |= {"mode": "lines+markers", "line": look.line(letter)}
        unwanted = points["unwanted" if is_short else "unwanted_per_hour"]
        texts = [_trade_off_text(row) for row in points.to_dict("records")]
        threshold = points["threshold"]
        traces.append(marks(unwanted, points["in_time"], texts, customdata=threshold, **looks))
    per = f"in {duration_text(duration_s)}" if is_short else "per hour"
    x_title = f"unwanted alerts {per}: false, nuisance or redundant"
    ends = [-0.04 * n_urgent, 1.06 * n_urgent]
    return look.draw(
        traces,
        title="Alerted in time against unwanted alerts",
        subtitle=f"{count_text(n_urgent, 'urgent encounter')}; over the score threshold, the rest "
        "of the policy as it is; up and left is better",
        height=380,
        xaxis=look.axis(x_title, rangemode="tozero"),
        yaxis=look.axis("urgent encounters alerted in time", range=ends, tickformat=",d"),
    )


def _trade_off_text(row: dict[Any, Any]) -> str:
    where = "every box" if np.isneginf(row["threshold"]) else f"score from {row['threshold']:.4g}"
    where = "its own log" if row["of"] == "log" else where
    kinds = ", ".join(f"{number(row[kind.value], 'd')} {kind.value}" for kind in UNWANTED)
    return f"{where}<br>{row['in_time']} alerted in time, {row['unwanted']} unwanted: {kinds}"


FIGURES: Final = {"alert_trade_off": alert_trade_off, "alerts_in_time": alerts_in_time}
"""Figures by name in `nvcore.api.figures.Figures`."""
