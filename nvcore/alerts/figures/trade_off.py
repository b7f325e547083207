"""The trade-off: urgent pedestrians alerted in time against unwanted alerts, over the threshold."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.alerts.episodes import UNWANTED
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.figures.marks import marks, system_marker
from nvcore.figures.style import LOOK, axis, draw, empty_figure, system_label
from nvcore.palette import Theme
from nvcore.wording import LEAST_HOURLY_S, count_text, duration_text, number

HEIGHT_PX: Final = 380
IN_USE_PX: Final = 13
LOG_PX: Final = 15


def alert_trade_off(result: Result, *, theme: Theme) -> go.Figure:
    """Urgent encounters alerted in time over unwanted alerts an hour; up and left is better.

    A line for each system over its score threshold, the policy as it is; a large mark where its
    threshold stands, and a star where its own log does. `customdata` is the threshold. Of short
    recordings no rate an hour is shown but the number.
    """
    view, duration_s = alerts_in(result), result.duration_s
    n_urgent = view.n_urgent
    if not n_urgent:
        return empty_figure(
            "No encounter is urgent: nobody has to be alerted in time.", theme=theme
        )
    is_short = duration_s < LEAST_HOURLY_S
    column = "unwanted" if is_short else "unwanted_per_hour"
    traces: list[go.Scatter] = []
    for letter, system in result.sides:
        own = view.curve[view.curve["system"] == letter]
        traces += _of_system(own, column, letter, system_label(letter, system.name), theme)
    return draw(
        traces,
        theme,
        title="Alerted in time against unwanted alerts",
        subtitle=f"{count_text(n_urgent, 'urgent encounter')}; over the score threshold, the rest "
        "of the policy as it is; up and left is better",
        height=HEIGHT_PX,
        xaxis=axis(
            theme,
            f"unwanted alerts {f'in {duration_text(duration_s)}' if is_short else 'per hour'}: "
            "false, nuisance or redundant",
            rangemode="tozero",
            fixedrange=True,
        ),
        yaxis=axis(
            theme,
            "urgent encounters alerted in time",
            range=[-0.04 * n_urgent, 1.06 * n_urgent],
            fixedrange=True,
            tickformat=",d",
        ),
    )


def _of_system(
    own: pd.DataFrame, column: str, letter: str, label: str, theme: Theme
) -> list[go.Scatter]:
    look, traces = LOOK[theme], []
    line = {"width": 2.4, "color": look.of(letter), "dash": look.dash(letter)}
    for of, mode, size, symbol in (
        ("policy", "lines+markers", 5, None),
        ("in use", "markers", IN_USE_PX, None),
        ("log", "markers", LOG_PX, "star"),
    ):
        points = own[own["of"] == of]
        if points.empty:
            continue
        marker: dict[str, Any] = system_marker(letter, size, theme)
        marker |= {"symbol": symbol} if symbol else {}
        name = label if of == "policy" else f"{label}, {'in use' if of == 'in use' else 'its log'}"
        trace = marks(
            points[column],
            points["in_time"],
            _texts(points),
            name=name,
            customdata=points["threshold"],
            marker=marker,
            cliponaxis=False,
        )
        traces.append(trace.update(mode=mode, line=line if mode != "markers" else None))
    return traces


def _texts(points: pd.DataFrame) -> list[str]:
    """For the mouse: the numbers behind a point."""
    texts = []
    for row in points.to_dict("records"):
        is_all = np.isneginf(row["threshold"])
        where = "every box" if is_all else f"score from {row['threshold']:.4g}"
        where = "its own log" if row["of"] == "log" else where
        kinds = ", ".join(f"{number(row[kind.value], 'd')} {kind.value}" for kind in UNWANTED)
        text = f"{row['in_time']} alerted in time, {row['unwanted']} unwanted: {kinds}"
        texts.append(f"{where}<br>{text}")
    return texts
