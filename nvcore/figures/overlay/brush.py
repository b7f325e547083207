"""Lines, dashed outlines, label backgrounds and text on an RGB canvas."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.common.palette import STYLES, TRUTH_COLOUR, X_COLOUR, Y_COLOUR, Scheme, rgb
from nvcore.figures.overlay.labels import Box

Colour = tuple[int, int, int]
Canvas = NDArray[np.uint8]
Dashes = tuple[int, ...]
"""Lengths of dashes and gaps in px, empty for a solid line."""

X_RGB: Final = rgb(X_COLOUR["dark"])
Y_RGB: Final = rgb(Y_COLOUR["dark"])
TRUTH_RGB: Final = rgb(TRUTH_COLOUR["dark"])
BLANK_RGB: Final[Colour] = (16, 19, 24)


@dataclass(frozen=True)
class Inks:
    """Colours of X, Y, the truth and the background of labels and frames, and dashes of X and Y."""

    x: Colour
    y: Colour
    truth: Colour
    ground: Colour
    dash_x: Dashes = STYLES[0].pattern
    dash_y: Dashes = STYLES[1].pattern

    @property
    def contrast(self) -> Colour:
        """White on a dark background, black on a light one."""
        return (255, 255, 255) if sum(self.ground) < 3 * 128 else (0, 0, 0)


ON_DARK: Final = Inks(X_RGB, Y_RGB, TRUTH_RGB, BLANK_RGB)
"""Inks for pictures."""
ON_LIGHT: Final = Inks(
    rgb(X_COLOUR["light"]), rgb(Y_COLOUR["light"]), rgb(TRUTH_COLOUR["light"]), (244, 246, 248)
)
"""Inks for paper (frames without a picture)."""


def inks_for(scheme: Scheme) -> Inks:
    """Return the inks of a scheme: ``dark`` for pictures, ``light`` for paper."""
    base = ON_LIGHT if scheme.shade == "light" else ON_DARK
    x, y = (scheme.style(letter) for letter in "xy")
    of_x, of_y = (rgb(style.colour(scheme.shade)) for style in (x, y))
    return Inks(of_x, of_y, base.truth, base.ground, x.pattern, y.pattern)


_SHIFT: Final = 4  # cv2 takes coordinates in 1/16 px
_PLATE: Final = 0.8
"""Opacity of the background of a label."""
_FONT: Final = cv2.FONT_HERSHEY_SIMPLEX


@dataclass(frozen=True)
class Brush:
    """Canvas, scale of the boxes (x, y, x, y), thickness of thin lines in px, and colours."""

    canvas: Canvas
    scale: NDArray[np.float64]
    unit: int
    inks: Inks

    def corners(self, xywh: NDArray[np.float64]) -> list[Box]:
        """Return the outermost pixels of boxes on the canvas: left, top, right, bottom.

        They are whole pixels, so that thin lines are sharp. Coordinates far outside are clipped, so
        that numbers stay small.
        """
        scaled = xywh * self.scale
        edges = np.column_stack([scaled[:, :2], scaled[:, :2] + scaled[:, 2:] - 1])
        limits = np.array([self.canvas.shape[1], self.canvas.shape[0]] * 2, dtype=float)
        clipped = np.clip(edges, -limits, 2 * limits)
        return [(row[0], row[1], row[2], row[3]) for row in np.round(clipped).tolist()]

    def rectangle(self, box: Box, colour: Colour, thickness: int, dash: float | None) -> None:
        """Draw the outline of a box with dashes of `dash` px, or a solid line if it is None."""
        left, top, right, bottom = box
        corners = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]
        for start, end in pairwise(corners):
            length = float(np.hypot(end[0] - start[0], end[1] - start[1]))
            if dash is None or length <= dash:
                self.line(*start, *end, colour, thickness)
                continue
            n_dashes = max(1, round(length / (1.8 * dash)))
            for number in range(n_dashes):
                share = (number / n_dashes, (number + 0.55) / n_dashes)
                ends = [
                    start[axis] + part * (end[axis] - start[axis])
                    for part in share
                    for axis in (0, 1)
                ]
                self.line(ends[0], ends[1], ends[2], ends[3], colour, thickness)

    def line(
        self, x0: float, y0: float, x1: float, y1: float, colour: Colour, thickness: int
    ) -> None:
        """Draw a straight line, px."""
        start, end = (
            (round(a * (1 << _SHIFT)), round(b * (1 << _SHIFT))) for a, b in ((x0, y0), (x1, y1))
        )
        kind = cv2.LINE_8 if x0 == x1 or y0 == y1 else cv2.LINE_AA  # upright lines stay sharp
        cv2.line(self.canvas, start, end, colour, thickness, kind, _SHIFT)

    def plate(self, box: Box) -> None:
        """Draw the background of a label, so that it can be read on any picture."""
        left, top, right, bottom = (max(0, round(edge)) for edge in box)
        behind = self.canvas[top:bottom, left:right]
        behind[:] = np.round((1 - _PLATE) * behind + _PLATE * np.array(self.inks.ground))


def put_text(
    canvas: Canvas, text: str, base: tuple[float, float], size: float, colour: Colour
) -> None:
    """Draw one line of text with its baseline starting at `base`.

    Characters that the font lacks become `?`.
    """
    plain_text, place = drawable(text), (round(base[0]), round(base[1]))
    thickness = 2 if size > 0.75 else 1
    cv2.putText(canvas, plain_text, place, _FONT, size, colour, thickness, cv2.LINE_AA)


def text_width(text: str, size: float) -> int:
    """Return the width of a text, px."""
    return int(cv2.getTextSize(drawable(text), _FONT, size, 2 if size > 0.75 else 1)[0][0])


def drawable(text: str) -> str:
    """Convert text to characters of OpenCV's font: without accents, others become `?`.

    Examples
    --------
    >>> drawable("Müller – 夜")
    'Muller - ?'
    """
    plain = unicodedata.normalize("NFKD", text.replace("–", "-").replace("ß", "ss"))
    letters = (sign for sign in plain if not unicodedata.combining(sign))
    return "".join(sign if " " <= sign <= "~" else "?" for sign in letters)
