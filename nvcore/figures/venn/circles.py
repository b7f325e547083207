"""Two circles whose areas are counts, and the regions that they make."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, pi, sin, sqrt
from typing import Final, NamedTuple

import numpy as np
from scipy.optimize import brentq

from nvcore.schema import Category


@dataclass(frozen=True)
class Circles:
    """X's circle around (0, 0) and Y's around (`apart`, 0); areas are counts.

    Attributes
    ----------
    radius_x, radius_y
        ``pi * radius**2`` is the number of encounters that the system detects.
    apart
        Distance of the centres at which the overlap's area is the number that both detect.
    """

    radius_x: float
    radius_y: float
    apart: float

    @property
    def left(self) -> float:
        """Leftmost point of the two circles."""
        return min(-self.radius_x, self.apart - self.radius_y)

    @property
    def right(self) -> float:
        """Rightmost point of the two circles."""
        return max(self.radius_x, self.apart + self.radius_y)

    def region_ends(self, category: Category) -> tuple[float, float]:
        """Where a region begins and ends on the line through both centres."""
        left_y, right_y = self.apart - self.radius_y, self.apart + self.radius_y
        if category is Category.X_ONLY:
            return -self.radius_x, min(self.radius_x, left_y)
        if category is Category.Y_ONLY:
            return max(self.radius_x, left_y), right_y
        return max(-self.radius_x, left_y), min(self.radius_x, right_y)

    def depth(self, category: Category, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """How far inside a region places are, from its nearest circle; below 0 outside of it."""
        in_x: np.ndarray = self.radius_x - np.hypot(x, y)
        in_y: np.ndarray = self.radius_y - np.hypot(x - self.apart, y)
        sign_x = 1 if category in (Category.BOTH, Category.X_ONLY) else -1
        sign_y = 1 if category in (Category.BOTH, Category.Y_ONLY) else -1
        depth: np.ndarray = np.minimum(sign_x * in_x, sign_y * in_y)
        return depth


def overlap_area(radius_x: float, radius_y: float, apart: float) -> float:
    """Area of the overlap of two circles."""
    if apart >= radius_x + radius_y:
        return 0.0
    if apart <= abs(radius_x - radius_y):
        return pi * min(radius_x, radius_y) ** 2
    # two circular segments: angles at the centres, less the kite between centres and corners
    half_x = acos((apart**2 + radius_x**2 - radius_y**2) / (2 * apart * radius_x))
    half_y = acos((apart**2 + radius_y**2 - radius_x**2) / (2 * apart * radius_y))
    corner = radius_x**2 * sin(2 * half_x) + radius_y**2 * sin(2 * half_y)
    return radius_x**2 * half_x + radius_y**2 * half_y - corner / 2


def circles_of(both: float, x_only: float, y_only: float) -> Circles:
    """Circles by the areas of their three regions: the counts of a Venn diagram.

    A circle inside the other touches it; circles without overlap stand a little apart.
    """
    radius_x, radius_y = sqrt((both + x_only) / pi), sqrt((both + y_only) / pi)
    least, most = abs(radius_x - radius_y), radius_x + radius_y
    if both == 0:
        return Circles(radius_x, radius_y, most + 0.15 * max(radius_x, radius_y))
    if x_only == 0 or y_only == 0:
        return Circles(radius_x, radius_y, least)
    apart = brentq(
        lambda distance: overlap_area(radius_x, radius_y, distance) - both,
        least,
        most,
        xtol=1e-13,
    )
    return Circles(radius_x, radius_y, apart)


ASPECT: Final = 1.75
"""Width of the frame around the circles by its height, at least."""
PLOT_PX: Final = (340, 255)
"""Room for the circles that can be counted on, width and height: a phone's window."""


class Frame(NamedTuple):
    """The frame around the circles, which also holds the encounters that neither detects."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def scale(self) -> float:
        """Pixels that a unit has at least."""
        return min(PLOT_PX[0] / (self.right - self.left), PLOT_PX[1] / (self.top - self.bottom))


def frame_of(circles: Circles) -> Frame:
    """A frame with room for the words beside the circles."""
    width = max(circles.right - circles.left, 1.0)
    height = max(2 * max(circles.radius_x, circles.radius_y), 0.35 * width)
    pad = 0.1 * height
    half_width = max(width / 2 + pad, 0.5 * ASPECT * (height + 3.2 * pad))
    middle = (circles.left + circles.right) / 2
    # lower down there is room for those that neither detects
    bottom, top = -height / 2 - 2.4 * pad, height / 2 + 1.6 * pad
    return Frame(middle - half_width, middle + half_width, bottom, top)
