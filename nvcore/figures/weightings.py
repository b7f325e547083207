"""Weight of one pedestrian over time, by height, by horizon and by distance."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.figures.marks import marks, still_line
from nvcore.figures.style import LOOK, axis, draw, plain, system_label, which_is_which
from nvcore.metrics.encounters import RELEVANT_K
from nvcore.palette import Theme
from nvcore.tables.encounters.weightings import Weightings
from nvcore.wording import count_text, number

HEIGHT_PX: Final = 370
LABELS: Final = {"height": "by height", "horizon": "by horizon", "distance": "by distance"}
STROKES: Final = {
    "height": ("solid", 2.0, "ink"),
    "horizon": ("dash", 2.0, "muted"),
    "distance": ("dot", 3.0, "ink"),
}
"""Dash, width and colour of a curve: none is a system's."""
LANES: Final = {"x": -0.17, "y": -0.34}
"""Where the detections of X and Y stand below the curves."""


def weightings_plot(
    result: Result, encounter: int, weightings: Weightings, *, theme: Theme
) -> go.Figure:
    """Plot the weight k over time by each weighting, and the frames in which X and Y detect.

    Parameters
    ----------
    encounter
        Row of ``result.encounters``.
    weightings
        Of it, from `nvcore.tables.encounters.weightings.compare_weightings`.
    """
    curves, look, noun = weightings.curves, LOOK[theme], result.objects.singular
    time_s = curves["time_s"].to_numpy()
    traces: list[Any] = []
    for kind, label in LABELS.items():
        k = curves[f"k_{kind}"].to_numpy()
        if np.isnan(k).all():
            continue
        dash, width, colour = STROKES[kind]
        traces.append(
            go.Scatter(
                x=time_s,
                y=k,
                mode="lines",
                name=label,
                line={"dash": dash, "width": width, "color": getattr(look, colour)},
                text=[
                    f"frame {frame}, {second:.2f} s<br>k {label} {number(value, '.2f')}"
                    for frame, second, value in zip(curves["frame"], time_s, k, strict=True)
                ],
                hovertemplate="%{text}<extra></extra>",
            )
        )
    half = still_line(
        time_s[[0, -1]], [RELEVANT_K] * 2, "counts", line={"width": 1, "color": look.muted}
    )
    lanes = [_lane(result, weightings, letter, theme) for letter in "xy"]
    name = plain(result.dataset.recordings["name"].iloc[result.encounters.recording[encounter]])
    return draw(
        [half, *traces, *lanes],
        theme,
        title=f"How near {noun} {result.encounters.track[encounter]} of {name} counts",
        subtitle=f"{count_text(len(curves), 'frame')}, which count from k = {RELEVANT_K:g} on; "
        f"below: those in which X and Y detect the {noun}{which_is_which(theme)}",
        height=HEIGHT_PX,
        xaxis=axis(theme, "time (s)", fixedrange=True),
        yaxis=axis(
            theme,
            "weight k",
            range=[-0.46, 1.05],
            tickvals=[*LANES.values(), 0, 0.5, 1],
            ticktext=[*(letter.upper() for letter in LANES), "0", "0.5", "1"],
            fixedrange=True,
        ),
    )


def _lane(result: Result, weightings: Weightings, letter: str, theme: Theme) -> go.Scatter:
    """Return a mark for each frame in which a system detects the pedestrian."""
    curves, look, noun = weightings.curves, LOOK[theme], result.objects.singular
    detected = curves[curves[f"matched_{letter}"]]
    return marks(
        detected["time_s"],
        np.full(len(detected), LANES[letter]),
        [f"{letter.upper()} detects the {noun}, frame {frame}" for frame in detected["frame"]],
        name=system_label(letter, result.system(letter).name),
        showlegend=False,
        marker={
            "color": look.of(letter),
            "size": 9,
            "symbol": "line-ns",
            "line": {"width": 2, "color": look.of(letter)},
        },
    )
