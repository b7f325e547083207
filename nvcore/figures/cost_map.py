"""What missing a pedestrian would cost over the picture, small, for the sidebar."""

from __future__ import annotations

from typing import Final

import numpy as np
import plotly.graph_objects as go

from nvcore.figures.style import HEADING_PX, LOOK, axis, draw, loss_scale
from nvcore.metrics.cost_map import CostMap
from nvcore.objects import Objects
from nvcore.palette import Theme

SMALL_PX: Final = 190
STEP: Final = 0.1
"""Between the lines of equal cost."""


def cost_plot(cost_map: CostMap, *, theme: Theme, objects: Objects) -> go.Figure:
    """Cost of missing a pedestrian, 0 to 1, by lateral position and row of the feet.

    As the picture is seen: the lower, the nearer. Empty where nobody can stand.
    """
    look, feet = LOOK[theme], objects.say("{feet}")
    line = {"width": 0.6, "color": look.surface}
    font = {"size": 11, "color": look.muted}
    costs = go.Contour(
        x=cost_map.centre_px,
        y=cost_map.foot_px,
        z=cost_map.cost.astype(np.float32),  # half the bytes
        zmin=0,
        zmax=1,
        contours={"start": STEP, "end": 1 - STEP, "size": STEP},
        line=line,
        colorscale=loss_scale(theme),
        colorbar={"tickvals": [0, 0.5, 1], "tickfont": font, "thickness": 8, "outlinewidth": 0},
        hovertemplate=feet + " at x %{x:.0f}, row %{y:.0f}: cost %{z:.2f}<extra></extra>",
        name="cost",
    )
    across, down = (_span(centres) for centres in (cost_map.centre_px, cost_map.foot_px))
    return draw(
        costs,
        theme,
        title="Cost of a miss",
        height=SMALL_PX + HEADING_PX,
        margin={"r": 0},
        xaxis=axis(theme, "lateral position (px)", range=across, fixedrange=True, showgrid=False),
        yaxis=axis(theme, f"{feet} (row)", range=down[::-1], fixedrange=True, showgrid=False),
    )


def _span(centres: np.ndarray) -> list[float]:
    """From the first cell's outer edge to the last one's, by their centres at one distance."""
    half = 0.5 * float(centres[1] - centres[0])
    return [float(centres[0]) - half, float(centres[-1]) + half]
