"""Venn diagram of driver, X and Y: three circles with a count in each region."""

from __future__ import annotations

from typing import Any, Final

import plotly.graph_objects as go

from nvcore.driver.comparison.judging import DriverVenn
from nvcore.driver.comparison.kinds import DRIVER_REGION_TEXT, DriverRegion
from nvcore.figures.marks import marks
from nvcore.figures.style import LOOK, ChartLook, draw, empty_figure, faded, plain, written
from nvcore.figures.venn import Frame, filled, square_axes
from nvcore.objects import Objects
from nvcore.palette import Theme
from nvcore.wording import count_text

HEIGHT_PX: Final = 400
RADIUS: Final = 0.9
CENTRES: Final = {"driver": (0.0, 0.55), "x": (-0.52, -0.33), "y": (0.52, -0.33)}
PLACES: Final[dict[DriverRegion, tuple[float, float]]] = {
    DriverRegion.DRIVER_X_Y: (0.0, -0.02),
    DriverRegion.DRIVER_X: (-0.55, 0.28),
    DriverRegion.DRIVER_Y: (0.55, 0.28),
    DriverRegion.DRIVER: (0.0, 1.0),
    DriverRegion.X_Y: (0.0, -0.68),
    DriverRegion.X: (-0.95, -0.6),
    DriverRegion.Y: (0.95, -0.6),
    DriverRegion.NOBODY: (1.6, 0.9),
}
"""Place of each region's count."""
CLICK_PX: Final = 44


def driver_venn_plot(
    venn: DriverVenn, names: tuple[str, str], *, theme: Theme, objects: Objects
) -> go.Figure:
    """Draw a Venn diagram of the near encounters that the driver, X and Y see.

    A click on a count gives its region (`nvcore.schema.DriverRegion`) as `customdata`. The circles
    are of one size: three counts and their overlaps cannot be areas of circles.

    Parameters
    ----------
    names
        Names of X and Y.
    """
    if not venn.n_known:
        return empty_figure("It is not known of any encounter who sees it.", theme=theme)
    look = LOOK[theme]
    texts = [
        f"{count_text(venn.counts[region], 'encounter')}<br>{objects.say(text)}"
        for region, text in DRIVER_REGION_TEXT.items()
        if region in PLACES
    ]
    x, y = zip(*PLACES.values(), strict=True)
    look_of_marks = {"opacity": 0, "size": CLICK_PX, "color": "#000"}
    points = marks(x, y, texts, customdata=[*PLACES], marker=look_of_marks)
    numbers = [
        written(f"<b>{venn.counts[region]:,}</b>", size=17, color=look.ink, x=x, y=y)
        for region, (x, y) in PLACES.items()
    ]
    n_unknown, n_distant = (
        venn.counts[region] for region in (DriverRegion.UNKNOWN, DriverRegion.DISTANT)
    )
    return draw(
        points,
        theme,
        title=f"Who sees the {objects.singular}",
        subtitle=f"{count_text(venn.n_known, 'near encounter')} of which it is known; not drawn: "
        f"{n_unknown:,} unknown, {n_distant:,} distant; circles are not to scale",
        height=HEIGHT_PX,
        showlegend=False,
        shapes=[_circle(who, look) for who in CENTRES],
        annotations=[*_labels(names, look), *numbers],
        **square_axes((-2.0, 2.0), (-1.45, 1.65)),
    )


def _circle(who: str, look: ChartLook) -> dict[str, Any]:
    colour = look.muted if who == "driver" else look.of(who)
    dash = "dot" if who == "driver" else look.dash(who)
    line = {"color": colour, "width": 2.5, "dash": dash}
    x, y = CENTRES[who]
    box = Frame(x - RADIUS, x + RADIUS, y - RADIUS, y + RADIUS)
    return filled("circle", box, line, faded(colour, 0.14))


def _labels(names: tuple[str, str], look: ChartLook) -> list[dict[str, Any]]:
    x, y = (f"{letter.upper()} {plain(name)}" for letter, name in zip("xy", names, strict=True))
    return [
        written("Driver", size=14, color=look.muted, x=0, y=1.48, yanchor="bottom"),
        written(x, size=14, color=look.x, x=-1.05, y=-1.2, yanchor="top"),
        written(y, size=14, color=look.y, x=1.05, y=-1.2, yanchor="top"),
        written("none of them", size=12, color=look.muted, x=1.6, y=1.08, yanchor="bottom"),
    ]
