"""Time to contact over time: who is nearest, and the last chances, for above and in the lanes."""

from __future__ import annotations

from typing import Final

import numpy as np
import pandas as pd
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.lanes import Lanes, Strip
from nvcore.figures.marks import click_markers, marks, still_line
from nvcore.figures.over_time import decimate, evenly
from nvcore.figures.style import LOOK, axis, faded
from nvcore.palette import Theme
from nvcore.time_left.encounters import contact_at, nearest_contact
from nvcore.time_left.figures.approach import responses_text
from nvcore.time_left.judging import needed_time, speed_of_frames
from nvcore.time_left.steps import time_left_in

MOST_S: Final = 6.0
"""Time to contact up to which it is drawn, unless the car needs longer to stop."""
POINTS: Final = 2000
CLICKS: Final = 300


def contact_strip(result: Result, recording: int, theme: Theme) -> Strip | None:
    """Least time to contact in each frame, above the lanes; filled where it is too late to stop.

    A click gives frame and encounter: `customdata` is the row in ``dataset.frames`` and that in
    ``result.encounters``.
    """
    nearest, frames = nearest_contact(result, recording), result.dataset.frame_columns
    speed_kmh = speed_of_frames(frames, result.params.speed_kmh)[frames.rows_of(recording)]
    needed_s = needed_time(speed_kmh, result.params)
    reach_s = max(MOST_S, float(np.ceil(1.2 * needed_s.max(initial=0))))
    if not (nearest["ttc_s"] < reach_s).any():
        return None
    return Strip(
        words=f"; above them the least time to contact, up to {reach_s:g} s",
        traces=_traces(result, recording, nearest, needed_s, reach_s, theme),
        axis=axis(
            theme,
            "time to<br>contact (s)",
            range=[0, reach_s],
            fixedrange=True,
            tickvals=np.arange(3) * np.floor(reach_s / 3),
        ),
    )


def _traces(
    result: Result,
    recording: int,
    nearest: pd.DataFrame,
    needed_s: np.ndarray,
    reach_s: float,
    theme: Theme,
) -> list[go.Scatter]:
    look, rows = LOOK[theme], result.dataset.frame_columns.rows_of(recording)
    time_s = result.dataset.frames["time_s"].to_numpy()[rows]
    ttc_s = np.nan_to_num(nearest["ttc_s"].to_numpy(), nan=np.inf)
    drawn = decimate(np.minimum(ttc_s, reach_s), n_points=POINTS)
    values = np.where(ttc_s < reach_s, ttc_s, np.nan)[drawn]
    is_same = bool(np.ptp(needed_s) == 0)
    at = np.array([0, -1]) if is_same else drawn
    limit = still_line(
        time_s[at],
        needed_s[at],
        f"{needed_s[0]:.1f} s needed to stop" if is_same else "time needed to stop",
        showlegend=None,
        yaxis="y2",
        line={"color": look.muted, "width": 1, "dash": "dot"},
    )
    area = still_line(
        np.concatenate([time_s[drawn], time_s[drawn][::-1]]),
        np.concatenate([np.fmin(values, needed_s[drawn]), needed_s[drawn][::-1]]),
        "too late to stop",
        yaxis="y2",
        fill="toself",
        fillcolor=faded(look.ink, 0.22),
        line={"width": 0},
    )
    line = still_line(
        time_s[drawn],
        values,
        "time to contact",
        yaxis="y2",
        line={"color": look.ink, "width": 1.6},
    )
    places = nearest.to_numpy(dtype=float)
    return [area, limit, line, _clicks(result, rows.start, time_s, places, reach_s)]


def _clicks(
    result: Result, start: int, time_s: np.ndarray, nearest: np.ndarray, reach_s: float
) -> go.Scatter:
    """Markers that are not seen, where the line is: each knows its frame, and who is nearest."""
    known = np.flatnonzero(nearest[:, 0] < reach_s)
    known = known[evenly(len(known), n_points=CLICKS)]
    ttc_s, encounter = nearest[known, 0], nearest[known, 1].astype(np.int64)
    frame, noun = result.dataset.frames["frame"].to_numpy()[start + known], result.objects.singular
    text = [
        f"{noun} {track}, frame {number}, {second:.2f} s<br>{left:.2f} s to contact, the least"
        for track, number, second, left in zip(
            result.encounters.track[encounter], frame, time_s[known], ttc_s, strict=True
        )
    ]
    places = np.column_stack([start + known, encounter])
    return click_markers(time_s[known], ttc_s, text, customdata=places, name="contact", yaxis="y2")


def last_chances(result: Result, encounters: np.ndarray, size: float, theme: Theme) -> go.Scatter:
    """A bar in the lane of each urgent encounter; `encounters` are those of the lanes, in order."""
    lane = np.flatnonzero(time_left_in(result).is_urgent[encounters])
    urgent = encounters[lane]
    row = time_left_in(result).urgency["urgent_row"].to_numpy()[urgent]
    frames = result.dataset.frames
    frame, time_s = frames["frame"].to_numpy()[row], frames["time_s"].to_numpy()[row]
    text = [
        f"{result.objects.singular} {result.encounters.track[encounter]}, last chance to stop: "
        f"frame {number}, {second:.2f} s<br>{of_both}"
        for encounter, number, second, of_both in zip(
            urgent.tolist(), frame, time_s, responses_text(result, urgent), strict=True
        )
    ]
    ink = LOOK[theme].ink
    line = {"width": 3, "color": ink}
    return marks(
        time_s,
        lane.astype(float),
        text,
        customdata=np.column_stack([row, urgent]),
        name="last chance to stop",
        marker={"symbol": "line-ns", "size": size, "color": ink, "line": line},
    )


def _to_contact(result: Result, encounter: np.ndarray, row: np.ndarray) -> list[str]:
    ttc_s = contact_at(result, encounter, row)
    return [f"{left:.1f} s to contact" if np.isfinite(left) else "" for left in ttc_s]


LANES: Final = Lanes(contact_strip, last_chances, _to_contact)
