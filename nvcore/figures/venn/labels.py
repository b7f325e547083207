"""The texts of the diagram: how large they are, and where they stand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from html import unescape
from typing import Final, NamedTuple

import numpy as np

from nvcore.figures.venn.circles import Circles, Frame
from nvcore.schema import Category

CHARACTER: Final = 0.6
"""Width of a character over the size of its font, where the font is a wide one."""
LINE: Final = 1.3
"""Height of a line over the size of its font."""
BASE_PX: Final = 14
"""Font size of the whole label: no line is lower."""


class LabelLine(NamedTuple):
    """One line of a label; names in `text` went through `nvcore.figures.style.plain`."""

    text: str
    size: float
    colour: str = ""
    is_bold: bool = False


@dataclass(frozen=True)
class Label:
    """A text of one or more lines."""

    lines: tuple[LabelLine, ...]

    @property
    def html(self) -> str:
        """The text as Plotly takes it."""
        return "<br>".join(
            f'<span style="font-size:{line.size:g}px'
            + (f";color:{line.colour}" if line.colour else "")
            + (f'"><b>{line.text}</b></span>' if line.is_bold else f'">{line.text}</span>')
            for line in self.lines
        )

    @property
    def width(self) -> float:
        """Width, px."""
        return max(CHARACTER * line.size * len(unescape(line.text)) for line in self.lines)

    @property
    def height(self) -> float:
        """Height, px."""
        return sum(LINE * max(line.size, BASE_PX) for line in self.lines)


@dataclass(frozen=True)
class Labels:
    """All labels inside the frame.

    Attributes
    ----------
    inside, beside
        Of the regions that have encounters: to stand in the region, or next to it.
    x, y
        The systems, in the upper corners.
    """

    inside: Mapping[Category, Label]
    beside: Mapping[Category, Label]
    x: Label
    y: Label


class Anchor(NamedTuple):
    """Where a label stands, in the circles' unit, and which of its points that is."""

    x: float
    y: float
    xanchor: str = "center"
    yanchor: str = "middle"


def anchor_of(
    kind: Category | str, circles: Circles, frame: Frame, is_inside: Mapping[Category, bool]
) -> Anchor:
    """Where the label of a region, or of the system "x" or "y", stands."""
    left, right, bottom, top = frame
    pad, gap = 0.02 * (top - bottom), 0.06 * (right - left)
    if kind == "x":
        return Anchor(left + pad, top - pad, "left", "top")
    if kind == "y":
        return Anchor(right - pad, top - pad, "right", "top")
    if kind is Category.NEITHER:
        return Anchor(right - pad, bottom + pad, "right", "bottom")
    assert isinstance(kind, Category)
    middle = sum(circles.region_ends(kind)) / 2
    if is_inside[kind]:
        return Anchor(middle, 0)
    if kind is Category.X_ONLY:
        return Anchor(circles.left - gap, 0, "right")
    if kind is Category.Y_ONLY:
        return Anchor(circles.right + gap, 0, "left")
    return Anchor(middle, 0.94 * bottom, "center", "bottom")


class Box(NamedTuple):
    """A rectangle that a text takes up, px."""

    left: float
    right: float
    bottom: float
    top: float

    def distance(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Of places from the rectangle, 0 inside of it."""
        across = np.maximum(np.maximum(self.left - x, x - self.right), 0)
        up = np.maximum(np.maximum(self.bottom - y, y - self.top), 0)
        distance: np.ndarray = np.hypot(across, up)
        return distance


TO_THE_LEFT: Final = {"left": 0.0, "center": 0.5, "right": 1.0}
BELOW: Final = {"bottom": 0.0, "middle": 0.5, "top": 1.0}


def text_boxes(
    labels: Labels, circles: Circles, frame: Frame, is_inside: Mapping[Category, bool]
) -> dict[Category | str, Box]:
    """What the labels take up, px."""
    texts: dict[Category | str, Label] = {"x": labels.x, "y": labels.y}
    texts |= {
        kind: label if is_inside.get(kind, True) else labels.beside[kind]
        for kind, label in labels.inside.items()
    }
    boxes = {}
    for kind, label in texts.items():
        anchor = anchor_of(kind, circles, frame, is_inside)
        left = anchor.x * frame.scale - TO_THE_LEFT[anchor.xanchor] * label.width
        bottom = anchor.y * frame.scale - BELOW[anchor.yanchor] * label.height
        boxes[kind] = Box(left, left + label.width, bottom, bottom + label.height)
    return boxes
