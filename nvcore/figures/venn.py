"""Venn diagram of the encounters: two circles with areas in proportion to the counts."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, pi, sin, sqrt
from typing import Any, Final

import numpy as np
import plotly.graph_objects as go
from scipy.optimize import brentq

from nvcore.figures.marks import click_markers
from nvcore.figures.style import (
    DASH,
    HIDDEN_AXIS,
    LOOK,
    draw,
    empty_figure,
    faded,
    plain,
    write,
)
from nvcore.metrics.venn import Venn
from nvcore.palette import Theme
from nvcore.schema import Category
from nvcore.wording import count_text

Corners = tuple[float, float, float, float]
"""Left, right, bottom, top."""


@dataclass(frozen=True)
class Circles:
    """X's circle around (0, 0) and Y's around (`apart`, 0); areas are counts.

    Attributes
    ----------
    radius_x, radius_y
        ``pi * radius**2`` is the number of encounters that the system detects.
    apart
        Distance of the centres at which the overlap's area is the number that both detect.
    """

    radius_x: float
    radius_y: float
    apart: float

    @property
    def left(self) -> float:
        """Leftmost point of the two circles."""
        return min(-self.radius_x, self.apart - self.radius_y)

    @property
    def right(self) -> float:
        """Rightmost point of the two circles."""
        return max(self.radius_x, self.apart + self.radius_y)

    def region_ends(self, category: Category) -> tuple[float, float]:
        """Where a region begins and ends on the line through both centres."""
        left_y, right_y = self.apart - self.radius_y, self.apart + self.radius_y
        if category is Category.X_ONLY:
            return -self.radius_x, min(self.radius_x, left_y)
        if category is Category.Y_ONLY:
            return max(self.radius_x, left_y), right_y
        return max(-self.radius_x, left_y), min(self.radius_x, right_y)


def overlap_area(radius_x: float, radius_y: float, apart: float) -> float:
    """Area of the overlap of two circles."""
    if apart >= radius_x + radius_y:
        return 0.0
    if apart <= abs(radius_x - radius_y):
        return pi * min(radius_x, radius_y) ** 2
    # two circular segments: angles at the centres, less the kite between centres and corners
    half_x = acos((apart**2 + radius_x**2 - radius_y**2) / (2 * apart * radius_x))
    half_y = acos((apart**2 + radius_y**2 - radius_x**2) / (2 * apart * radius_y))
    corner = radius_x**2 * sin(2 * half_x) + radius_y**2 * sin(2 * half_y)
    return radius_x**2 * half_x + radius_y**2 * half_y - corner / 2


def place_circles(venn: Venn) -> Circles:
    """Circles whose areas are the counts of a Venn diagram.

    A circle inside the other touches it; circles without overlap stand a little apart.
    """
    radius_x, radius_y = sqrt((venn.both + venn.x_only) / pi), sqrt((venn.both + venn.y_only) / pi)
    least, most = abs(radius_x - radius_y), radius_x + radius_y
    if venn.both == 0:
        return Circles(radius_x, radius_y, most + 0.15 * max(radius_x, radius_y))
    if venn.x_only == 0 or venn.y_only == 0:
        return Circles(radius_x, radius_y, least)
    apart = brentq(
        lambda distance: overlap_area(radius_x, radius_y, distance) - venn.both,
        least,
        most,
        xtol=1e-13,
    )
    return Circles(radius_x, radius_y, apart)


HEIGHT_PX: Final = 380
ASPECT: Final = 1.75
"""Width of the frame around the circles by its height, at least."""
PLOT_PX: Final = (440, 270)
"""Room for the circles that can be counted on, width and height."""
LABEL_PX: Final = 44
"""Width that a count inside a region needs."""
GRID: Final = (36, 22)
"""Places that can be clicked, across and down."""
WORDS: Final = {
    Category.BOTH: "both",
    Category.X_ONLY: "only X",
    Category.Y_ONLY: "only Y",
    Category.NEITHER: "neither",
    Category.DISTANT: "distant",
}


def venn_figure(venn: Venn, names: tuple[str, str], *, theme: Theme) -> go.Figure:
    """Encounters by which system detects them; a click gives the category as `customdata`.

    Parameters
    ----------
    names
        Names of X and Y.

    References
    ----------
    Paper 11-0360, figures 1 and 2.
    """
    if venn.n_near == 0:
        text = "No pedestrian came near enough to count."
        if venn.distant:
            text += f" {count_text(venn.distant, 'encounter')} stayed distant."
        return empty_figure(text, theme=theme, height=HEIGHT_PX)
    circles = place_circles(venn)
    corners = left, right, bottom, top = _frame(circles)
    scale = min(PLOT_PX[0] / (right - left), PLOT_PX[1] / (top - bottom))
    figure = draw(
        [_clicks(venn, circles, corners)],
        theme,
        title="Encounters detected",
        subtitle=f"{count_text(venn.n_near, 'encounter')} near enough to count; areas in "
        "proportion",
        height=HEIGHT_PX,
        hoverdistance=24,
        margin={"l": 8, "r": 8, "t": 60, "b": 30},
        xaxis={**HIDDEN_AXIS, "range": [left, right]},
        yaxis={**HIDDEN_AXIS, "range": [bottom, top], "scaleanchor": "x"},
    )
    pale = LOOK[theme].pale
    line = {"color": pale, "width": 1}
    _fill(figure, "rect", "all encounters", corners, line, faded(pale, 0.12))
    _draw_circles(figure, circles, theme)
    _label_regions(figure, venn, circles, corners, scale, theme)
    _label_outside(figure, venn, names, corners, theme)
    return figure


def _frame(circles: Circles) -> Corners:
    """The frame that also holds those that neither detects."""
    width = max(circles.right - circles.left, 1.0)
    height = max(2 * max(circles.radius_x, circles.radius_y), 0.35 * width)
    pad = 0.1 * height
    half_width = max(width / 2 + pad, 0.5 * ASPECT * (height + 3.2 * pad))
    middle = (circles.left + circles.right) / 2
    return middle - half_width, middle + half_width, -height / 2 - 1.6 * pad, height / 2 + 1.6 * pad


def _draw_circles(figure: go.Figure, circles: Circles, theme: Theme) -> None:
    for letter, centre, radius in (
        ("x", 0.0, circles.radius_x),
        ("y", circles.apart, circles.radius_y),
    ):
        if radius:
            colour = LOOK[theme].of(letter)
            line = {"color": colour, "width": 2, "dash": DASH[letter]}
            corners = centre - radius, centre + radius, -radius, radius
            _fill(figure, "circle", f"circle {letter}", corners, line, faded(colour, 0.30))


def _fill(
    figure: go.Figure, kind: str, name: str, corners: Corners, line: dict[str, Any], colour: str
) -> None:
    sides = dict(zip(("x0", "x1", "y0", "y1"), corners, strict=True))
    figure.add_shape(type=kind, name=name, line=line, fillcolor=colour, layer="below", **sides)


def _label_regions(
    figure: go.Figure,
    venn: Venn,
    circles: Circles,
    corners: Corners,
    scale: float,
    theme: Theme,
) -> None:
    """Count and words in each region; beside it with a line where the region is too narrow."""
    look = LOOK[theme]
    left, right, bottom, _ = corners
    gap = 0.06 * (right - left)
    beside: dict[Category, dict[str, Any]] = {
        Category.X_ONLY: {"ax": circles.left - gap, "ay": 0, "xanchor": "right"},
        Category.BOTH: {"ay": 0.94 * bottom, "yanchor": "bottom"},
        Category.Y_ONLY: {"ax": circles.right + gap, "ay": 0, "xanchor": "left"},
    }
    for category, place in beside.items():
        count = venn.counts()[category.value]
        if not count:
            continue
        start, stop = circles.region_ends(category)
        middle = (start + stop) / 2
        if (stop - start) * scale >= LABEL_PX:
            text = f'<b style="font-size:24px">{count:,}</b><br>{WORDS[category]}'
            place = {}
        else:
            text = f"<b>{count:,}</b> {WORDS[category]}"
            line = {"arrowhead": 0, "arrowwidth": 1, "arrowcolor": look.muted}
            place = {"showarrow": True, "ax": middle, "axref": "x", "ayref": "y", **line, **place}
        write(figure, text, size=14, color=look.ink, x=middle, y=0, name=category.value, **place)


def _label_outside(
    figure: go.Figure,
    venn: Venn,
    names: tuple[str, str],
    corners: Corners,
    theme: Theme,
) -> None:
    left, right, bottom, top = corners
    pad = 0.06 * (top - bottom)
    look = LOOK[theme]
    for letter, name, x, anchor, count in (
        ("x", names[0], left + pad / 3, "left", venn.both + venn.x_only),
        ("y", names[1], right - pad / 3, "right", venn.both + venn.y_only),
    ):
        text = f"<b>{letter.upper()}: {plain(name, max_length=18)}</b><br>"
        place = {"x": x, "y": top - pad / 3, "xanchor": anchor, "yanchor": "top", "align": anchor}
        text += f"{count:,} of {venn.n_near:,}"
        write(figure, text, size=13, color=look.of(letter), name=f"system {letter}", **place)
    place = {"x": right - pad / 3, "y": bottom + pad / 4, "xanchor": "right", "yanchor": "bottom"}
    text = f"<b>{venn.neither:,}</b> neither"
    write(figure, text, size=14, color=look.ink, name=Category.NEITHER.value, **place)
    place = {"x": right, "y": bottom, "xanchor": "right", "yanchor": "top", "yshift": -4}
    text = f"{venn.distant:,} distant, not counted"
    write(figure, text, size=12, color=look.muted, name=Category.DISTANT.value, **place)


def _clicks(venn: Venn, circles: Circles, corners: Corners) -> go.Scatter:
    """Invisible markers all over the diagram, each of the category at its place."""
    left, right, bottom, top = corners
    across, up = np.linspace(left, right, GRID[0]), np.linspace(bottom, top, GRID[1])
    x, y = (grid.ravel() for grid in np.meshgrid(across, up))
    in_x = x**2 + y**2 <= circles.radius_x**2
    in_y = (x - circles.apart) ** 2 + y**2 <= circles.radius_y**2
    kinds = (Category.BOTH, Category.X_ONLY, Category.Y_ONLY, Category.NEITHER)
    category = np.select([in_x & in_y, in_x, in_y], range(3), default=3)
    # a region may be too small for the grid: one marker in its middle
    for code, kind in enumerate(kinds[:3]):
        if venn.counts()[kind.value]:
            x, y = np.append(x, sum(circles.region_ends(kind)) / 2), np.append(y, 0.0)
            category = np.append(category, code)
    x, y = np.append(x, right), np.append(y, bottom - 0.04 * (top - bottom))
    names = [kinds[code].value for code in category] + [Category.DISTANT.value]
    text = [
        f"{count_text(venn.counts()[name], 'encounter')}: {WORDS[Category(name)]}" for name in names
    ]
    return click_markers(x, y, text, customdata=names, name="regions", cliponaxis=False)
