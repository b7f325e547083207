"""A detector's boxes in one picture: those that count, those that went, and the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from nvcore.figures.detectors.pictures import picture_axes, picture_layer
from nvcore.figures.marks import click_markers, marks, steady_marker, still_line, with_gaps
from nvcore.figures.style import HEADING_PX, LEGEND, LOOK, draw, faded, plain
from nvcore.palette import Theme, scheme_of
from nvcore.pictures import Picture
from nvcore.wording import count_text

if TYPE_CHECKING:
    from nvcore.detectors.base import Detections

HEIGHT_PX: Final = 560
TOP_PX: Final = HEADING_PX + 34
SUPPRESSED: Final = 0.25
"""Opacity of boxes that went."""


def boxes_plot(
    picture: Picture,
    boxes: Detections,
    is_counting: NDArray[np.bool_],
    *,
    theme: Theme,
    threshold: float,
    title: str = "Boxes",
    truth: NDArray[np.float64] | None = None,
    size: tuple[float, float] | None = None,
    chosen: int | None = None,
) -> go.Figure:
    """Boxes of one picture before and after suppression, beside the truth.

    `customdata` of a mark in the middle of a box is its row in `boxes`.

    Parameters
    ----------
    picture
        What the detector was given.
    boxes
        Candidates in pixels of the picture (`nvcore.detectors.candidates`).
    is_counting
        Which of them count, shape (n,).
    theme
        The detector is drawn as its Y, for pictures.
    threshold
        Those with a lower score are not drawn.
    truth
        Left, top, width, height in pixels of the recording, (n, 4); None: not known.
    size
        Width and height of the recording, px; None: those of the picture.
    chosen
        Row of the box that is marked.
    """
    height, width = picture.shape[:2]
    own_size = size or (float(width), float(height))
    scale = own_size[0] / width, own_size[1] / height
    sides = np.column_stack([boxes.x, boxes.y, boxes.w, boxes.h]) * np.tile(scale, 2)
    is_above = boxes.score >= threshold
    is_gone = is_above & ~is_counting
    look = LOOK[scheme_of(theme)._replace(shade="dark")]  # on a picture, whatever the page's ground
    traces = [
        _outlines(sides[is_gone], "suppressed", color=faded(look.y, SUPPRESSED), width=1),
        *([] if truth is None else [_outlines(truth, "truth", color=look.truth, width=1.5)]),
        _outlines(sides[is_counting], "detected", color=look.y, width=2.4, dash=look.dash("y")),
    ]
    if chosen is not None:
        traces.append(_outlines(sides[[chosen]], "chosen", color="#FFFFFF", width=4))
    middle = sides[:, :2] + sides[:, 2:] / 2
    for name, is_shown in (("gone", is_gone), ("counting", is_counting)):  # these on top
        row = np.flatnonzero(is_shown)
        across, down = middle[row].T
        texts = [_text(boxes, is_counting, k) for k in row.tolist()]
        more: dict[str, Any] = {"name": name, "customdata": row}
        if name == "gone":
            traces.append(click_markers(across, down, texts, **more))
            continue
        more |= steady_marker(size=8, color=look.y, line={"width": 1, "color": look.surface})
        traces.append(marks(across, down, texts, showlegend=False, **more))
    n_above, n_counting = int(is_above.sum()), int(is_counting.sum())
    subtitle = f"{count_text(n_above, 'box', 'boxes')} before suppression, {n_counting:,} after"
    if truth is not None:
        subtitle += f"; the truth has {len(truth):,}"
    return draw(
        traces,
        theme,
        title=title,
        subtitle=subtitle,
        height=HEIGHT_PX,
        margin={"l": 4, "r": 4, "t": TOP_PX, "b": 4},
        legend={**LEGEND, "bgcolor": look.surface, "font": {"size": 12, "color": look.ink}},
        images=[picture_layer(picture, *own_size)],
        **picture_axes(*own_size),
    )


def _text(boxes: Detections, is_counting: NDArray[np.bool_], k: int) -> str:
    """For the mouse."""
    text = f"score {boxes.score[k]:.3g}, {boxes.w[k]:.0f} × {boxes.h[k]:.0f} px"
    text += "" if boxes.label is None else f", {plain(boxes.label[k])}"
    return text if is_counting[k] else f"{text}<br>suppressed"


def _outlines(sides: NDArray[np.float64], name: str, **line: Any) -> go.Scatter:
    """All boxes as one line."""
    left, top, width, height = sides.T
    right, bottom = left + width, top + height
    return still_line(
        with_gaps(left, right, right, left, left),
        with_gaps(top, top, bottom, bottom, top),
        name,
        showlegend=len(sides) > 0,
        line=line,
    )
