"""Alerts of a recording over time: a row for each system and kind."""

from __future__ import annotations

from typing import Final

import numpy as np
import plotly.graph_objects as go

from nvcore.alerts.kinds import AlertKind
from nvcore.alerts.steps import alerts_in
from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line, system_marker, with_gaps
from nvcore.figures.over_time.similarity import end_of, time_range
from nvcore.figures.style import LEFT_PX, LOOK, axis, draw, empty_figure, plain, rows_axis
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
    frames, view = result.dataset.frames, alerts_in(result)
    frame, time_s = frames["frame"].to_numpy(), frames["time_s"].to_numpy()
    step_s = result.dataset.frame_columns.step_s
    traces: list[go.Scatter] = []
    labels: list[str] = []
    n_alerts = 0
    for letter, system in result.sides:
        alerts = view.of(system)
        alerts = alerts[alerts["recording"].to_numpy() == recording]
        n_alerts += len(alerts)
        for kind in AlertKind:
            own = alerts[(alerts["kind"] == kind.value).to_numpy()]
            if own.empty:
                continue
            place = np.full(len(own), float(len(labels)))
            labels.append(f"{letter.upper()} {kind.value}")
            first, last = own["first_row"].to_numpy(), own["last_row"].to_numpy()
            encounter = own["encounter"].to_numpy()
            line = {"width": 9, "color": LOOK[theme].of(letter)}
            ends = time_s[first], time_s[last] + step_s[last]
            traces.append(still_line(with_gaps(*ends), with_gaps(place, place), "", line=line))
            texts = [
                f"{letter.upper()}, {kind.value}: frame {number}, {start:.2f} s, for {length:.1f} s"
                + (
                    f"<br>{result.objects.singular} {result.encounters.track[who]}"
                    if who >= 0
                    else ""
                )
                for number, start, length, who in zip(
                    frame[first], ends[0], ends[1] - ends[0], encounter, strict=True
                )
            ]
            traces.append(
                marks(
                    *(ends[0], place, texts),
                    name=labels[-1],
                    customdata=np.column_stack([first, encounter]),
                    marker=system_marker(letter, 10, theme),
                )
            )
    if not labels:
        return empty_figure("Nothing alerts the driver in this recording.", theme=theme)
    return draw(
        traces,
        theme,
        title=f"Alerts, {plain(result.dataset.recordings['name'][recording])}",
        subtitle=count_text(n_alerts, "alert"),
        height=AROUND_PX + ROW_PX * len(labels),
        hoverdistance=-1,
        showlegend=False,
        margin={"l": LEFT_PX},
        xaxis=axis(theme, ticksuffix=" s", range=time_range(end_of(result, recording))),
        yaxis=rows_axis(theme, labels, fixedrange=True, showgrid=False),
    )
