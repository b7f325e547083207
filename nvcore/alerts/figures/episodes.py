"""Alerts of a recording over time: a row for each system and kind."""

from __future__ import annotations

from itertools import product
from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.alerts.episodes import AlertKind
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line, system_marker, with_gaps
from nvcore.figures.over_time import time_axis
from nvcore.figures.style import LEFT_PX, LOOK, draw, empty_figure, plain, rows_axis
from nvcore.palette import Theme
from nvcore.wording import count_text

ROW_PX: Final = 22
AROUND_PX: Final = 100


def alerts_over_time(result: Result, recording: int, theme: Theme) -> go.Figure:
    """A bar for each alert, from its onset on.

    `customdata` of the mark at the onset is the row in ``dataset.frames`` and that in
    ``result.encounters`` (-1: about nobody).

    Parameters
    ----------
    recording
        Row of ``dataset.recordings``.
    """
    view = alerts_in(result)
    alerts = pd.concat([view.of(system) for _, system in result.sides], ignore_index=True)
    table = view.table.assign(row=alerts["first_row"], whom=alerts["encounter"])
    table = table[alerts["recording"] == recording]
    traces: list[go.Scatter] = []
    labels: list[str] = []
    for letter, kind in product("xy", AlertKind):
        own = table[(table["system"] == letter) & (table["kind"] == kind.value)]
        if own.empty:
            continue
        place = np.full(len(own), float(len(labels)))
        labels.append(f"{letter.upper()} {kind.value}")
        start_s, length_s = own["start_s"].to_numpy(), own["duration_s"].to_numpy()
        line = {"width": 9, "color": LOOK[theme].of(letter)}
        ends = with_gaps(start_s, start_s + length_s)
        traces.append(still_line(ends, with_gaps(place, place), "", line=line))
        texts = [
            f"{letter.upper()}, {kind.value}: frame {frame}, {start:.2f} s, for {length:.1f} s"
            + ("" if pd.isna(who) else f"<br>{result.objects.singular} {who}")
            for frame, start, length, who in zip(
                own["start_frame"], start_s, length_s, own["encounter"], strict=True
            )
        ]
        trace = marks(
            start_s,
            place,
            texts,
            name=labels[-1],
            customdata=own[["row", "whom"]].to_numpy(),
            marker=system_marker(letter, 10, theme),
        )
        traces.append(trace)
    if not labels:
        return empty_figure("Nothing alerts the driver in this recording.", theme=theme)
    return draw(
        traces,
        theme,
        title=f"Alerts, {plain(result.dataset.recordings['name'][recording])}",
        subtitle=count_text(len(table), "alert"),
        height=AROUND_PX + ROW_PX * len(labels),
        hoverdistance=-1,
        showlegend=False,
        margin={"l": LEFT_PX},
        xaxis=time_axis(result, recording, theme, ticksuffix=" s"),
        yaxis=rows_axis(theme, labels, fixedrange=True, showgrid=False),
    )
