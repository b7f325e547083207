"""A detector's boxes in one picture: those that count, those that went, and the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from nvcore.detectors.figures.pictures import picture_axes, picture_layer
from nvcore.figures.marks import click_markers, marks, still_line, with_gaps
from nvcore.figures.style import LOOK, draw, faded, plain
from nvcore.metrics.matching import iou_of_pairs
from nvcore.palette import Theme, scheme_of
from nvcore.pictures import Picture
from nvcore.schema import DetectionState
from nvcore.wording import count_text

if TYPE_CHECKING:
    from nvcore.detectors.base import Detections

HEIGHT_PX: Final = 560
SUPPRESSED: Final = 0.25
"""Opacity of boxes that went."""
MARK_PX: Final = (3, 8)
"""Of the mark in the middle of the smallest and of large boxes."""
CHOSEN: Final = "#FFE600"
"""Neither the truth's colour nor a system's."""
OUTCOMES: Final = {
    DetectionState.MATCHED: "matched",
    DetectionState.FALSE_ALARM: "a false alarm",
    DetectionState.ABSORBED: "on ignored truth",
    DetectionState.BELOW: "of a class that does not count",
}
"""What a box that counts is in a comparison."""


def boxes_plot(
    picture: Picture,
    boxes: Detections,
    is_counting: NDArray[np.bool_],
    *,
    theme: Theme,
    threshold: float,
    title: str = "Boxes",
    truth: NDArray[np.float64] | None = None,
    ignored: NDArray[np.float64] | None = None,
    states: NDArray[np.int8] | None = None,
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
    ignored
        The same of truth that is neither to be found nor a false alarm; None: there is none.
    states
        What each box that counts is in a comparison (`nvcore.schema.DetectionState`; BELOW: not of
        a class that counts), int8, (n,); None: not known.
    size
        Width and height of the recording, px; None: those of the picture.
    chosen
        Row of the box that is marked.
    """
    own_size = size or (float(picture.shape[1]), float(picture.shape[0]))
    sides = sides_in(boxes, picture, own_size)
    is_above = boxes.score >= threshold
    is_gone = is_above & ~is_counting
    look = LOOK[scheme_of(theme)._replace(shade="dark")]  # on a picture, whatever the page's ground
    swatch = {"color": faded(look.y, 0.7), "width": 1.5}  # the line itself is too faint for it
    faint = _outlines(sides[is_gone], "suppressed boxes", color=faded(look.y, SUPPRESSED), width=1)
    traces = [
        faint.update(showlegend=False),
        *([] if chosen is None else [_filled(sides[[chosen]], "chosen", CHOSEN, width=6)]),
        still_line([None], [None], "suppressed", showlegend=bool(is_gone.any()), line=swatch),
        *([] if truth is None else [_outlines(truth, "truth", color=look.truth, width=1.5)]),
        # solid, whatever the system's line: its dashes are longer than a distant box
        _outlines(sides[is_counting], "detected", color=look.y, width=2.4),
    ]
    if ignored is not None:
        traces.append(_outlines(ignored, "ignored", color=look.truth, width=1.5, dash="dot"))
    iou = iou_with(sides, truth)
    middle = sides[:, :2] + sides[:, 2:] / 2
    across_px = sides[:, 2:].min(axis=1) * HEIGHT_PX / own_size[1]  # of a box on the screen, about
    mark_px = np.clip(across_px / 2, *MARK_PX)
    for name, is_shown in (("gone", is_gone), ("counting", is_counting)):  # these on top
        row = np.flatnonzero(is_shown)
        across, down = middle[row].T
        texts = [
            box_text(boxes, k, iou=iou[k], is_counting=name == "counting", states=states)
            for k in row.tolist()
        ]
        more: dict[str, Any] = {"name": name, "customdata": row}
        if name == "gone":
            traces.append(click_markers(across, down, texts, **more))
            continue
        rim = {"width": 1, "color": look.surface}
        more["marker"] = {"size": mark_px[row], "color": look.y, "line": rim}
        traces.append(marks(across, down, texts, showlegend=False, **more))
    return draw(
        traces,
        theme,
        title=title,
        subtitle=_counts(int(is_above.sum()), is_counting, truth, states),
        height=HEIGHT_PX,
        margin={"l": 0, "r": 0},
        legend={"bgcolor": look.surface, "font": {"size": 12, "color": look.ink}},
        images=[picture_layer(picture, *own_size)],
        **picture_axes(*own_size, can_zoom=True),
        dragmode="zoom",
        uirevision=f"{title} {own_size}",  # what is enlarged stays while thresholds move
    )


def sides_in(boxes: Detections, picture: Picture, size: tuple[float, float]) -> NDArray[np.float64]:
    """Left, top, width, height of boxes of a picture in pixels of the recording, (n, 4).

    Parameters
    ----------
    size
        Width and height of the recording, px.
    """
    scale = size[0] / picture.shape[1], size[1] / picture.shape[0]
    in_picture = np.column_stack([boxes.x, boxes.y, boxes.w, boxes.h])
    sides: NDArray[np.float64] = in_picture * np.tile(scale, 2)
    return sides


def iou_with(sides: NDArray[np.float64], truth: NDArray[np.float64] | None) -> NDArray[np.float64]:
    """Intersection over union of each box with the truth's nearest, (n,); NaN without truth."""
    if truth is None or not len(truth):
        return np.full(len(sides), np.nan)
    left, top, width, height = sides.T[:, :, np.newaxis]
    iou: NDArray[np.float64] = iou_of_pairs((left, top, width, height), tuple(truth.T)).max(axis=1)
    return iou


def box_text(
    boxes: Detections,
    k: int,
    *,
    iou: float,
    is_counting: bool,
    states: NDArray[np.int8] | None = None,
) -> str:
    """Score, size, class, overlap with the truth and what it is in a comparison, of one box."""
    text = f"score {boxes.score[k]:.3g}, {boxes.w[k]:.0f} × {boxes.h[k]:.0f} px"
    text += "" if boxes.label is None else f", {plain(boxes.label[k])}"
    text += "" if np.isnan(iou) else f", IoU with the truth {iou:.2f}"
    if not is_counting:
        return f"{text}: suppressed"
    return text if states is None else f"{text}: {OUTCOMES[DetectionState(int(states[k]))]}"


def _counts(
    n_above: int,
    is_counting: NDArray[np.bool_],
    truth: NDArray[np.float64] | None,
    states: NDArray[np.int8] | None,
) -> str:
    """How many boxes there are, and what they are in a comparison."""
    text = f"{count_text(n_above, 'box', 'boxes')} before suppression, "
    text += f"{int(is_counting.sum()):,} after"
    n_matched = 0
    if states is not None:
        of_state = np.bincount(states[is_counting], minlength=len(DetectionState))
        n_matched = int(of_state[DetectionState.MATCHED])
        text += f": {n_matched:,} matched, {of_state[DetectionState.FALSE_ALARM]:,} false"
        for other in (DetectionState.ABSORBED, DetectionState.BELOW):
            text += f", {of_state[other]:,} {OUTCOMES[other]}" if of_state[other] else ""
    if truth is not None:
        text += f"; the truth has {len(truth):,}"
        text += "" if states is None else f", {len(truth) - n_matched:,} missed"
    return text


def _filled(sides: NDArray[np.float64], name: str, colour: str, *, width: float) -> go.Scatter:
    """Boxes that cannot be taken for others, even without the colour."""
    outlines = _outlines(sides, name, color=colour, width=width)
    return outlines.update(fill="toself", fillcolor=faded(colour, 0.25))


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
