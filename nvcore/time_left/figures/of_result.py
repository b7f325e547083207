"""The figures of time left, each from a comparison alone."""

from __future__ import annotations

from typing import Final

import plotly.graph_objects as go

from nvcore.comparison import Result
from nvcore.palette import Theme
from nvcore.time_left.encounters import urgent_encounters
from nvcore.time_left.figures.approach import approach_plot
from nvcore.time_left.figures.margins import margins_plot
from nvcore.time_left.figures.over_speed import OverSpeed, over_speed_plot
from nvcore.time_left.steps import time_left_in


def time_left(result: Result, *, theme: Theme) -> go.Figure:
    """Urgent encounters up to contact, with the last chance and when X and Y confirm."""
    return approach_plot(result, urgent_encounters(result), theme=theme)


def over_speed(result: Result, measure: OverSpeed = "share_in_time", *, theme: Theme) -> go.Figure:
    """Time left of X and Y over the speed of the car.

    Parameters
    ----------
    measure
        ``"share_in_time"`` or ``"mean_impact_kmh"``.
    """
    view = time_left_in(result)
    return over_speed_plot(
        view.over_speed,
        result.names,
        speed_kmh=view.assumed_speed_kmh,
        theme=theme,
        measure=measure,
    )


def margins(result: Result, *, theme: Theme) -> go.Figure:
    """How long before the last chance X and Y confirm each urgent pedestrian."""
    return margins_plot(result, urgent_encounters(result), theme=theme)


FIGURES: Final = {"time_left": time_left, "over_speed": over_speed, "margins": margins}
"""By their names in `nvcore.api.figures.Figures`."""
