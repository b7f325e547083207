"""Venn diagram of driver, X and Y: three circles with a count in each region."""

from __future__ import annotations

from typing import Any, Final

import plotly.graph_objects as go

from nvcore.driver.comparison.judging import DriverVenn
from nvcore.driver.comparison.kinds import DRIVER_REGION_TEXT, DriverRegion
from nvcore.figures.marks import marks
from nvcore.figures.style import HIDDEN_AXIS, LOOK, draw, empty_figure, faded, plain, written
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
"""Where each region's count stands."""
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
    regions = list(PLACES)
    counts = [venn.counts[region] for region in regions]
    texts = [
        f"{count_text(count, 'encounter')}<br>{objects.say(DRIVER_REGION_TEXT[region])}"
        for region, count in zip(regions, counts, strict=True)
    ]
    points = marks(
        [PLACES[region][0] for region in regions],
        [PLACES[region][1] for region in regions],
        texts,
        customdata=[region.value for region in regions],
        marker={"opacity": 0, "size": CLICK_PX, "color": "#000"},
    )
    numbers = [
        written(f"<b>{count:,}</b>", size=17, color=look.ink, x=x, y=y)
        for count, (x, y) in zip(counts, PLACES.values(), strict=True)
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
        shapes=[_circle(who, theme) for who in CENTRES],
        annotations=[*_labels(names, theme), *numbers],
        xaxis=HIDDEN_AXIS | {"range": [-2.0, 2.0], "constrain": "domain"},
        yaxis=HIDDEN_AXIS | {"range": [-1.45, 1.65], "constrain": "domain", "scaleanchor": "x"},
    )


def _circle(who: str, theme: Theme) -> dict[str, Any]:
    look = LOOK[theme]
    colour = look.muted if who == "driver" else look.of(who)
    dash = "dot" if who == "driver" else look.dash(who)
    x, y = CENTRES[who]
    return {
        "type": "circle",
        "layer": "below",
        "x0": x - RADIUS,
        "x1": x + RADIUS,
        "y0": y - RADIUS,
        "y1": y + RADIUS,
        "fillcolor": faded(colour, 0.14),
        "line": {"color": colour, "width": 2.5, "dash": dash},
    }


def _labels(names: tuple[str, str], theme: Theme) -> list[dict[str, Any]]:
    look = LOOK[theme]
    x, y = (f"{letter.upper()} {plain(name)}" for letter, name in zip("xy", names, strict=True))
    return [
        written("Driver", size=14, color=look.muted, x=0, y=1.48, yanchor="bottom"),
        written(x, size=14, color=look.x, x=-1.05, y=-1.2, yanchor="top"),
        written(y, size=14, color=look.y, x=1.05, y=-1.2, yanchor="top"),
        written("none of them", size=12, color=look.muted, x=1.6, y=1.08, yanchor="bottom"),
    ]
