"""Pictures in figures: below marks of their pixels, and several side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import cv2
import numpy as np
import plotly.graph_objects as go

from nvcore.figures.style import HEADING_PX, HIDDEN_AXIS, LOOK, draw, plain, written
from nvcore.palette import Theme
from nvcore.pictures import Picture, jpeg, picture_address, stretch
from nvcore.pictures.stretch import STRETCH

WIDEST_PX: Final = 1280
"""Of a picture in a figure: larger ones are shrunk."""
SMALL_PX: Final = 320
"""Width of one of several pictures."""
ROW_PX: Final = 165
LABEL_SHARE: Final = 0.16
"""Height of a label above a picture, as a share of the picture's, with few columns."""
FEW_COLUMNS: Final = 3
NARROW_LABEL_SHARE: Final = 0.38
"""The same with more of them: the pictures are smaller, the letters are not."""


def picture_layer(picture: Picture, width: float, height: float, **more: Any) -> dict[str, Any]:
    """A picture for a layout's ``images``, over 0..width and 0..height of the axes.

    Contrast is stretched as in the viewer: night pictures are dim.
    """
    return {
        "source": _address(stretch(picture, *STRETCH), WIDEST_PX),
        "xref": "x",
        "yref": "y",
        "x": 0,
        "y": 0,
        "sizex": width,
        "sizey": height,
        "sizing": "stretch",
        "layer": "below",
        **more,
    }


def picture_axes(width: float, height: float, *, can_zoom: bool = False) -> dict[str, Any]:
    """The axes of a layout on which a picture has its shape, rows downwards, on the left."""
    common = {**HIDDEN_AXIS, "fixedrange": not can_zoom}
    return {
        "xaxis": {
            **common,
            "range": [0, width],
            "constrain": "domain",
            "constraintoward": "left",
        },
        "yaxis": {
            **common,
            "range": [height, 0],
            "scaleanchor": "x",
            "constrain": "domain",
            "constraintoward": "top",
        },
    }


def pictures_plot(
    pictures: Mapping[str, Picture],
    *,
    theme: Theme,
    title: str,
    subtitle: str = "",
    columns: int = 5,
    stretched: bool = False,
) -> go.Figure:
    """Small pictures side by side, each below its name.

    Parameters
    ----------
    pictures
        Of one shape, 8 bit.
    stretched
        Whether the contrast of each is stretched: most gradients are faint.
    """
    height, width = next(iter(pictures.values())).shape[:2]
    columns = min(columns, len(pictures))
    label_share, size = (LABEL_SHARE, 12) if columns <= FEW_COLUMNS else (NARROW_LABEL_SHARE, 11)
    step = (1.04 * width, (1 + label_share) * height + 0.04 * height)
    rows = -(-len(pictures) // columns)
    images, labels = [], []
    for number, (name, picture) in enumerate(pictures.items()):
        left, top = (number % columns) * step[0], (number // columns) * step[1]
        place = {"x": left, "y": top + label_share * height}
        images.append(picture_layer(picture, width, height, **place))
        shown = stretch(picture, 0, STRETCH[1]) if stretched else picture
        images[-1]["source"] = _address(shown, SMALL_PX)
        text = written(plain(name), size=size, color=LOOK[theme].ink, x=left, y=place["y"])
        labels.append({**text, "xanchor": "left", "yanchor": "bottom", "xshift": -2})
    extent = columns * step[0] - 0.04 * width, rows * step[1]
    return draw(
        [],
        theme,
        title=title,
        subtitle=subtitle,
        height=HEADING_PX + 12 + ROW_PX * rows,
        margin={"l": 0, "r": 0},
        showlegend=False,
        images=images,
        annotations=labels,
        **picture_axes(*extent),
    )


def _address(picture: Picture, widest: int) -> str:
    """The picture in 8 bit as an address that holds its content."""
    height, width = picture.shape[:2]
    shown = np.ascontiguousarray(picture)
    if width > widest:
        size = widest, max(1, round(height * widest / width))
        shown = cv2.resize(shown, size, interpolation=cv2.INTER_AREA)
    return picture_address(jpeg(shown))
