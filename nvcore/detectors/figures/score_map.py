"""What became of every window of a picture at one scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np
import plotly.graph_objects as go

from nvcore.detectors.figures.pictures import picture_axes, picture_layer
from nvcore.figures.style import LOOK, draw, faded
from nvcore.palette import Theme
from nvcore.pictures import Picture
from nvcore.wording import count_text

if TYPE_CHECKING:
    from nvcore.detectors.icf.displays import CoarseMap
    from nvcore.detectors.icf.settings import IcfSettings

MapOf: TypeAlias = Literal["trees", "confidence"]
TITLES: Final[dict[MapOf, str]] = {
    "trees": "Trees that each window came through",
    "confidence": "Confidence of the windows that came through",
}
HEIGHT_PX: Final = 460
OPACITY: Final = 0.9
"""Of the highest value; of the lowest 0, so that the picture is seen."""
BAR_PX: Final = 40


def score_map_plot(
    windows: CoarseMap,
    settings: IcfSettings,
    picture: Picture,
    *,
    theme: Theme,
    of: MapOf = "trees",
) -> go.Figure:
    """Windows of one scale over the picture, each at its middle.

    Parameters
    ----------
    windows
        Of `nvcore.detectors.icf.displays.map_at`.
    settings
        Of the run.
    of
        How many trees each window came through, on a logarithmic scale; or the confidence of those
        that came through all.
    """
    height, width = picture.shape[:2]
    level, step = windows.level, windows.step
    values = windows.score
    if of != "confidence":  # NaN where nothing was looked at
        values = np.log10(np.where(windows.depth > 0, windows.depth, np.nan))
    down, across = ((np.arange(n) * step + (step - 1) / 2) * settings.stride for n in values.shape)
    look = LOOK[theme]
    bar = {
        "thickness": 8,
        "outlinewidth": 0,
        "tickfont": {"size": 11, "color": look.muted},
        "title": {"text": of, "side": "right", "font": {"size": 11, "color": look.muted}},
        "orientation": "h",
        "len": 0.3,
        "x": 0,
        "xanchor": "left",
        "y": 0,
        "yanchor": "top",
    }
    unit = "confidence %{z:.3g}"
    if of == "trees":
        ticks = [1, 10, 100, 1000, 10_000]
        bar |= {"tickvals": np.log10(ticks), "ticktext": [f"{tick:,}" for tick in ticks]}
        unit = "%{customdata} trees"
    heat = go.Heatmap(
        x=(across + settings.window_width / 2) * level.across,
        y=(down + settings.window_height / 2) * level.down,
        z=values.astype(np.float32),
        customdata=windows.depth if of == "trees" else None,
        colorscale=[(share, faded(look.y, share * OPACITY)) for share in (0.0, 0.5, 1.0)],
        zmin=0 if of == "trees" else None,
        colorbar=bar,
        hovertemplate=f"{unit}<extra></extra>",
        name=TITLES[of],
    )
    return draw(
        heat,
        theme,
        title=TITLES[of],
        subtitle=f"scale {level.scale:g}: {count_text(windows.n_windows, 'window')} of "
        f"{settings.window_width * level.across:.0f} × {settings.window_height * level.down:.0f} "
        f"px, {windows.n_through:,} came through",
        height=HEIGHT_PX,
        margin={"l": 0, "r": 0, "b": BAR_PX},
        images=[picture_layer(picture, width, height)],
        **picture_axes(width, height),
    )
