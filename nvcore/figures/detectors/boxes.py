"""A detector's boxes in one picture: those that count, those that went, and the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from nvcore.figures.detectors.pictures import picture_axes, picture_layer
from nvcore.figures.marks import marks, steady_marker, still_line, with_gaps
from nvcore.figures.style import CLEAR, HEADING_PX, LEGEND, LOOK, draw, plain
from nvcore.palette import Theme, scheme_of
from nvcore.pictures import Picture
from nvcore.wording import count_text

if TYPE_CHECKING:
    from nvcore.detectors.base import Detections

HEIGHT_PX: Final = 560
TOP_PX: Final = HEADING_PX + 34


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
        _outlines(sides[is_gone], "suppressed", color=look.muted, width=1),
        *([] if truth is None else [_outlines(truth, "truth", color=look.truth, width=1.5)]),
        _outlines(sides[is_counting], "detected", color=look.y, width=2.4, dash=look.dash("y")),
    ]
    if chosen is not None:
        traces.append(_outlines(sides[[chosen]], "chosen", color="#FFFFFF", width=4))
    row = np.flatnonzero(is_above)
    across, down = (sides[row, :2] + sides[row, 2:] / 2).T
    texts = [
        f"score {boxes.score[k]:.3g}, {boxes.w[k]:.0f} × {boxes.h[k]:.0f} px"
        + ("" if boxes.label is None else f", {plain(boxes.label[k])}")
        + ("" if is_counting[k] else "<br>suppressed")
        for k in row
    ]
    middles = marks(
        across,
        down,
        texts,
        customdata=row,
        name="score",
        showlegend=False,
        **steady_marker(
            size=np.where(is_counting[row], 11, 7),
            color=[look.y if counts else CLEAR for counts in is_counting[row].tolist()],
            line={"width": 1, "color": look.y},
        ),
    )
    n_above, n_counting = int(is_above.sum()), int(is_counting.sum())
    subtitle = f"{count_text(n_above, 'box', 'boxes')} before suppression, {n_counting:,} after"
    if truth is not None:
        subtitle += f"; the truth has {len(truth):,}"
    return draw(
        [*traces, middles],
        theme,
        title=title,
        subtitle=subtitle,
        height=HEIGHT_PX,
        margin={"l": 4, "r": 4, "t": TOP_PX, "b": 4},
        legend={**LEGEND, "bgcolor": look.surface, "font": {"size": 12, "color": look.ink}},
        images=[picture_layer(picture, *own_size)],
        **picture_axes(*own_size),
    )


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
