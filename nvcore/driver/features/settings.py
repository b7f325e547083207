"""What the paper leaves open about the features."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from nvcore.driver.shapes import check_ranges

COLOUR_BINS: Final = 16
"""Bins of each colour's histogram, as in the paper."""
_RANGES: Final = {"surround": (1.1, 10.0), "bin_distance": (0.001, 1000.0)}


@dataclass(frozen=True, kw_only=True)
class FeatureSettings:
    """How features are computed where the paper is silent; all of it is ours.

    Attributes
    ----------
    surround
        Sides of the region around a pedestrian, as a multiple of the box's; what the box covers is
        not part of it.
    bin_distance
        Ground distance of the Earth Mover's Distance from one bin to the next: 1 counts bins, 16
        grey levels.
    """

    surround: float = 2.0
    bin_distance: float = 1.0

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES)
