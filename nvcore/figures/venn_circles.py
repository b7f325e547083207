"""Two circles with areas in proportion to counts: radii and distance."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, pi, sin, sqrt

from scipy.optimize import brentq

from nvcore.schema import Category
from nvcore.venn import Venn


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


def place_circles(venn: Venn) -> Circles:
    """Circles whose areas are the counts of a Venn diagram.

    A circle inside the other touches it; circles without overlap stand a little apart.
    """
    radius_x, radius_y = sqrt((venn.both + venn.x_only) / pi), sqrt((venn.both + venn.y_only) / pi)
    least, most = abs(radius_x - radius_y), radius_x + radius_y
    if venn.both == 0:
        return Circles(radius_x, radius_y, most + 0.15 * max(radius_x, radius_y))
    if venn.x_only == 0 or venn.y_only == 0:
        return Circles(radius_x, radius_y, least)
    apart = brentq(
        lambda at: overlap_area(radius_x, radius_y, at) - venn.both, least, most, xtol=1e-13
    )
    return Circles(radius_x, radius_y, apart)
