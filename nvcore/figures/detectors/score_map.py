"""What became of every window of a picture at one scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np
import plotly.graph_objects as go

from nvcore.figures.detectors.pictures import picture_axes, picture_layer
from nvcore.figures.style import HEADING_PX, LOOK, draw, faded
from nvcore.palette import Theme
from nvcore.pictures import Picture
from nvcore.wording import count_text

if TYPE_CHECKING:
    from nvcore.detectors.icf.detector import ScoreMap
    from nvcore.detectors.icf.settings import IcfSettings

MapOf: TypeAlias = Literal["trees", "confidence"]
TITLES: Final[dict[MapOf, str]] = {
    "trees": "Trees that each window came through",
    "confidence": "Confidence of the windows that came through",
}
HEIGHT_PX: Final = 460
MOST_CELLS: Final = 200
"""Along each side: of more, the highest value of several stands for them."""
OPACITY: Final = 0.9
"""Of the highest value; of the lowest 0, so that the picture is seen."""
BAR_PX: Final = 40


def score_map_plot(
    score_map: ScoreMap,
    settings: IcfSettings,
    picture: Picture,
    *,
    theme: Theme,
    of: MapOf = "trees",
) -> go.Figure:
    """Windows of one scale over the picture, each at its middle.

    Parameters
    ----------
    score_map
        Of `nvcore.detectors.icf.IcfDetector.score_maps`.
    settings
        Of the model.
    of
        How many trees each window came through, on a logarithmic scale; or the confidence of those
        that came through all.
    """
    height, width = picture.shape[:2]
    level = score_map.level
    values = score_map.score if of == "confidence" else _logarithm(score_map.depth)
    step = max(1, -(-max(values.shape) // MOST_CELLS))
    across = (np.arange(0, values.shape[1], step) + (step - 1) / 2) * settings.stride
    down = (np.arange(0, values.shape[0], step) + (step - 1) / 2) * settings.stride
    look = LOOK[theme]
    n_through = int(np.isfinite(score_map.score).sum())
    bar = {
        "thickness": 8,
        "outlinewidth": 0,
        "tickfont": {"size": 11, "color": look.muted},
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
        z=_highest(values, step).astype(np.float32),
        customdata=_highest(score_map.depth.astype(float), step) if of == "trees" else None,
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
        subtitle=f"scale {level.scale:g}: {count_text(score_map.n_windows, 'window')} of "
        f"{settings.window_width * level.across:.0f} × {settings.window_height * level.down:.0f} "
        f"px, {n_through:,} came through",
        height=HEIGHT_PX,
        margin={"l": 4, "r": 4, "t": HEADING_PX + 8, "b": BAR_PX},
        images=[picture_layer(picture, width, height)],
        **picture_axes(width, height),
    )


def _logarithm(depth: np.ndarray) -> np.ndarray:
    """Logarithm to base 10; NaN where nothing was looked at."""
    return np.log10(np.where(depth > 0, depth, np.nan))


def _highest(values: np.ndarray, step: int) -> np.ndarray:
    """The highest value of each square of `step` cells; NaN where all are."""
    rows, columns = (-(-side // step) * step for side in values.shape)
    padded = np.full((rows, columns), -np.inf)
    padded[: values.shape[0], : values.shape[1]] = np.where(np.isnan(values), -np.inf, values)
    highest = padded.reshape(rows // step, step, columns // step, step).max(axis=(1, 3))
    return np.where(np.isneginf(highest), np.nan, highest)
