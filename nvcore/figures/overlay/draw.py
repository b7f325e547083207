"""Boxes of one frame on its picture, to show at a glance which system misses whom.

Truth is thin, X solid, Y dashed, each in its colour. A missed pedestrian has corners in the colour
of the system that misses them (if both do, left is X and right is Y) and a tag above. The most
salient one has a triangle there. False alarms are crossed out, ignore regions dotted. Labels avoid
each other and missed pedestrians (`nvcore.figures.overlay.labels`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.schema import DetectionState, TruthState
from nvcore.figures.overlay.brush import (
    ON_DARK,
    Brush,
    Canvas,
    Colour,
    Dashes,
    Inks,
    put_text,
    text_width,
)
from nvcore.figures.overlay.labels import Box, LabelRoom, Place, overlap, tag_places
from nvcore.pictures.base import Picture

_MIN_WIDTH: Final = 960
_MAX_WIDTH: Final = 1920
DASH_SHARE: Final = 7 / 6
"""Length of a dash on a picture, as a multiple of that in the viewer."""
_TINT: Final = 0.6
"""Share of the system's colour in the text of a label. The rest is contrast to the background."""


@dataclass(frozen=True)
class DrawnDetections:
    """Detections of one system in one frame.

    Attributes
    ----------
    xywh
        x, y, w, h in the recording's px; float64, shape (n, 4).
    state
        `DetectionState` of each; int8, shape (n,).
    labels
        A text for each, or none at all.
    """

    xywh: NDArray[np.float64]
    state: NDArray[np.int8]
    labels: Sequence[str] = ()


@dataclass(frozen=True)
class TruthMark:
    """Display of a truth box: the systems that miss it, and its importance."""

    state_x: TruthState
    state_y: TruthState
    is_relevant: bool = False
    is_salient_x: bool = False
    is_salient_y: bool = False

    @property
    def is_ignored(self) -> bool:
        """Whether the truth ignores the box."""
        return self.state_x == TruthState.NOT_JUDGED

    @property
    def is_missed(self) -> bool:
        """Whether X or Y misses the pedestrian."""
        return TruthState.MISSED in (self.state_x, self.state_y)


@dataclass(frozen=True)
class DrawnTruth:
    """Truth boxes of one frame.

    Attributes
    ----------
    xywh
        x, y, w, h in the recording's px; float64, shape (n, 4).
    marks
        One for each box.
    labels
        A text for each, or none at all.
    """

    xywh: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 4)))
    marks: Sequence[TruthMark] = ()
    labels: Sequence[str] = ()


def canvas_size(width: float, height: float) -> tuple[int, int]:
    """Return the size of the drawing, px.

    The numbers are even, and small recordings are enlarged by a whole factor.
    """
    factor = max(1.0, float(int(np.ceil(_MIN_WIDTH / width)))) if width < _MIN_WIDTH else 1.0
    factor = min(factor, 8.0, _MAX_WIDTH / width)
    return max(2, round(width * factor / 2) * 2), max(2, round(height * factor / 2) * 2)


def draw_boxes(
    picture: Picture | None,
    width: float,
    height: float,
    *,
    truth: DrawnTruth | None = None,
    x: DrawnDetections | None = None,
    y: DrawnDetections | None = None,
    inks: Inks = ON_DARK,
    unit: int | None = None,
) -> Canvas:
    """Draw boxes on the picture, or on a blank canvas without one.

    Parameters
    ----------
    picture
        8-bit picture (`nvcore.pictures.stretch`) of any size. It is scaled to the recording.
    width, height
        The recording's size, px.
    truth, x, y
        Boxes to draw; None for a source that is not drawn.
    inks
        The colours.
    unit
        Thickness of thin lines, px of the canvas. Labels are ten times as high. None: suitable for
        a canvas shown at its own size.

    Returns
    -------
    numpy.ndarray
        RGB, uint8, of `canvas_size`.
    """
    size = canvas_size(width, height)
    canvas = _background(picture, size, inks)
    scale = np.array([size[0] / width, size[1] / height] * 2)
    brush = Brush(canvas, scale, max(1, round(size[0] / 960)) if unit is None else unit, inks)
    for boxes, colour, dashes in ((x, inks.x, inks.dash_x), (y, inks.y, inks.dash_y)):
        if boxes is not None:
            _draw_detections(brush, boxes, colour, dashes)
    if truth is not None:
        _draw_truth(brush, truth)
    _draw_labels(brush, truth or DrawnTruth(), x, y)
    return canvas


def _background(picture: Picture | None, size: tuple[int, int], inks: Inks) -> Canvas:
    if picture is None:
        return np.full((size[1], size[0], 3), inks.ground, np.uint8)
    if picture.ndim == 2:
        picture = cv2.cvtColor(picture, cv2.COLOR_GRAY2RGB)
    if picture.shape[1::-1] == size:
        return np.array(picture, dtype=np.uint8)
    method = cv2.INTER_AREA if picture.shape[1] > size[0] else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(picture, size, interpolation=method), dtype=np.uint8)


def _draw_detections(brush: Brush, boxes: DrawnDetections, colour: Colour, dashes: Dashes) -> None:
    unit = brush.unit
    dash = DASH_SHARE * dashes[0] * unit if dashes else None
    # a loop over the boxes of one frame, which are drawn one by one
    for number, box in enumerate(brush.corners(boxes.xywh)):
        brush.rectangle(box, colour, 2 * unit, dash)
        left, top, right, bottom = box
        if boxes.state[number] == DetectionState.FALSE_ALARM:
            arm = min(8.0 * unit, (right - left) / 2, (bottom - top) / 2)
            across, down = (left + right) / 2, (top + bottom) / 2
            for sign in (-1, 1):
                start, end = down - sign * arm, down + sign * arm
                brush.line(across - arm, start, across + arm, end, colour, unit)


def _draw_truth(brush: Brush, boxes: DrawnTruth) -> None:
    # a loop over the boxes of one frame
    for box, mark in zip(brush.corners(boxes.xywh), boxes.marks, strict=True):
        dash = 2.0 * brush.unit if mark.is_ignored else None
        brush.rectangle(box, brush.inks.truth, brush.unit, dash)
        if mark.is_missed:
            _mark_miss(brush, box, mark)


def _mark_miss(brush: Brush, box: Box, mark: TruthMark) -> None:
    unit, inks = brush.unit, brush.inks
    left_colour = inks.x if mark.state_x == TruthState.MISSED else inks.y
    right_colour = inks.y if mark.state_y == TruthState.MISSED else inks.x
    gap = 4.0 * unit
    left, top, right, bottom = box[0] - gap, box[1] - gap, box[2] + gap, box[3] + gap
    arm_x, arm_y = max(4.0 * unit, (right - left) / 3), max(4.0 * unit, (bottom - top) / 5)
    thickness = 3 * unit if mark.is_relevant else unit
    for edge, sign, colour in ((left, 1, left_colour), (right, -1, right_colour)):
        for level, down in ((top, 1), (bottom, -1)):
            brush.line(edge, level, edge + sign * arm_x, level, colour, thickness)
            brush.line(edge, level, edge, level + down * arm_y, colour, thickness)


def _draw_labels(
    brush: Brush, truth: DrawnTruth, x: DrawnDetections | None, y: DrawnDetections | None
) -> None:
    """Draw the tags of the missed pedestrians, tallest first, then labels that still fit."""
    boxes, inks = brush.corners(truth.xywh), brush.inks
    texts = truth.labels or [""] * len(boxes)
    gap = 5.0 * brush.unit
    grown = {i: (b[0] - gap, b[1] - gap, b[2] + gap, b[3] + gap) for i, b in enumerate(boxes)}
    height, width = brush.canvas.shape[:2]
    missed = {
        i: grown[i]
        for i, mark in enumerate(truth.marks)
        if mark.is_relevant and mark.is_missed and overlap(grown[i], (0, 0, width, height))
    }
    room = LabelRoom(width, height, list(missed.values()))
    for i in sorted(missed, key=lambda i: missed[i][1] - missed[i][3]):
        _draw_tag(brush, room, missed[i], truth.marks[i], texts[i])
    for system, colour, is_upper in ((x, inks.x, True), (y, inks.y, False)):
        if system is not None and system.labels:
            for text, box in zip(system.labels, brush.corners(system.xywh), strict=True):
                side = _Side(is_left=True, is_upper=is_upper)
                _draw_label(brush, room, text, box, colour, side)
    for i, (text, box) in enumerate(zip(texts, boxes, strict=True)):
        if i not in missed:
            side = _Side(is_left=False, is_upper=False)
            _draw_label(brush, room, text, box, inks.truth, side)


def _draw_tag(brush: Brush, room: LabelRoom, box: Box, mark: TruthMark, text: str) -> None:
    """Draw a filled field for each system that misses the pedestrian, and the label."""
    unit, inks = brush.unit, brush.inks
    chips = [
        (letter, colour, is_salient)
        for letter, colour, state, is_salient in (
            ("X", inks.x, mark.state_x, mark.is_salient_x),
            ("Y", inks.y, mark.state_y, mark.is_salient_y),
        )
        if state == TruthState.MISSED
    ]
    size = 0.4 * unit
    width = sum(_chip_width(is_salient, unit) + 2 * unit for _, _, is_salient in chips)
    if text:
        width += text_width(text, size) + 2 * unit
    extent = (float(width), 15.0 * unit)
    left, top, _, _ = room.must_take(extent, tag_places(box, extent))
    base = top + 12 * unit
    for letter, colour, is_salient in chips:
        _draw_chip(brush, (left, base), letter, colour, is_salient)
        left += _chip_width(is_salient, unit) + 2 * unit
    if text:
        right = left + text_width(text, size) + unit
        brush.plate((left - unit, top, right, top + extent[1]))
        put_text(brush.canvas, text, (left, base), size, inks.truth)


class _Side(NamedTuple):
    """Side of its box at which a label is placed: left or right, top or bottom."""

    is_left: bool
    is_upper: bool


def _draw_label(
    brush: Brush, room: LabelRoom, text: str, box: Box, colour: Colour, side: _Side
) -> None:
    """Draw a text beside, above or below its box, if it fits."""
    if not text:
        return
    unit = brush.unit
    size = 0.4 * unit
    width, height, gap = text_width(text, size), 13.0 * unit, 5.0 * unit
    left, top, right, bottom = box
    level = top if side.is_upper else bottom - 10 * unit
    aligned = left if side.is_left else right - width
    beside: list[Place] = [(left - gap - width, level), (right + gap, level)]
    upright: list[Place] = [(aligned, top - gap - height), (aligned, bottom + gap)]
    places = beside if side.is_left else beside[::-1]
    places = places + (upright if side.is_upper else upright[::-1])
    place = room.take((width, height), places)
    if place is not None:
        brush.plate(place)
        contrast = np.array(brush.inks.contrast)
        red, green, blue = np.round(_TINT * np.array(colour) + (1 - _TINT) * contrast).tolist()
        stronger = int(red), int(green), int(blue)
        put_text(brush.canvas, text, (place[0], place[1] + 10 * unit), size, stronger)


def _chip_width(is_salient: bool, unit: int) -> int:
    return (25 if is_salient else 15) * unit


def _draw_chip(brush: Brush, place: Place, letter: str, colour: Colour, is_salient: bool) -> None:
    """Draw a filled field with the letter, and a triangle if most salient, based at `place`."""
    canvas, unit, ground = brush.canvas, brush.unit, brush.inks.ground
    left_px, base_px = round(place[0]), round(place[1])
    upper_left = (left_px, base_px - 12 * unit)
    lower_right = (left_px + _chip_width(is_salient, unit), base_px + 3 * unit)
    cv2.rectangle(canvas, upper_left, lower_right, colour, -1)
    put_text(canvas, letter, (left_px + 3 * unit, base_px), 0.42 * unit, ground)
    if is_salient:
        tip = np.array([[15, -8], [23, -8], [19, -1]]) * unit + [left_px, base_px]
        cv2.fillPoly(canvas, [tip.astype(np.int32)], ground, cv2.LINE_AA)
