"""Registry of the eight features of a pedestrian, and settings of their computation.

References
----------
"Can a Driver Assistance System Determine if a Driver is Perceiving a Pedestrian? Consideration of
the Driver's Visual Adaptation to Illumination Change": the eight features.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from nvcore.subjects.driver.illumination.shapes import check_ranges

COLOUR_BINS: Final = 16
"""Number of bins of each colour's histogram, as in the paper."""
_RANGES: Final = {"surround": (1.1, 10.0), "bin_distance": (0.001, 1000.0)}


@dataclass(frozen=True, kw_only=True)
class FeatureSettings:
    """Settings of the feature computation that the paper does not specify. All are our choice.

    Attributes
    ----------
    surround
        Side lengths of the region around a pedestrian, as a multiple of the box's. The box itself
        is excluded.
    bin_distance
        Ground distance of the Earth Mover's Distance between neighbouring bins: 1 counts bins, 16
        counts grey levels.
    """

    surround: float = 2.0
    bin_distance: float = 1.0

    def __post_init__(self) -> None:
        check_ranges(self, _RANGES)


@dataclass(frozen=True)
class Feature:
    """Number that describes how well a pedestrian can be seen.

    Attributes
    ----------
    key
        Column name.
    label, unit
        Text for people.
    meaning
        Description in a sentence, for help texts.
    is_of_scale
        Whether the value for the same view changes with the resolution of the picture.
    """

    key: str
    label: str
    unit: str
    meaning: str
    is_of_scale: bool = False


FEATURES: Final = (
    Feature("width_px", "Width", "px", "Width of the pedestrian.", is_of_scale=True),
    Feature("height_px", "Height", "px", "Height of the pedestrian.", is_of_scale=True),
    Feature(
        "luminance_sd",
        "Luminance SD",
        "grey levels",
        "Standard deviation of the 8-bit luminance of the pedestrian: their own contrast.",
    ),
    Feature(
        "luminance_contrast",
        "Luminance contrast",
        "grey levels",
        "Difference of the mean 8-bit luminance of the pedestrian and their surround.",
    ),
    Feature(
        "lab_distance",
        "Lab distance",
        "ΔE",
        "Distance of the mean colours of the pedestrian and their surround in CIE L*a*b*.",
    ),
    Feature(
        "edge_contrast",
        "Edge contrast",
        "grey levels",
        "Difference of the mean Sobel gradient of the pedestrian and their surround.",
        is_of_scale=True,
    ),
    Feature(
        "colour_emd",
        "Colour EMD",
        "bins",
        "Earth Mover's Distance of the histograms of R, G and B (16 bins each) of the pedestrian "
        "and their surround, summed over the three.",
    ),
    Feature(
        "fixation_distance_px",
        "Distance from fixation",
        "px",
        "From the middle of the pedestrian to where the driver looks.",
        is_of_scale=True,
    ),
)
"""Features in the order of every table."""
FEATURE_KEYS: Final = tuple(feature.key for feature in FEATURES)
LABELS: Final = {feature.key: feature.label for feature in FEATURES}


def words_of(keys: Sequence[str]) -> str:
    """Describe a choice of features in words.

    Examples
    --------
    >>> words_of(["width_px", "edge_contrast"])
    'Width + Edge contrast'
    """
    labels = " + ".join(LABELS[key] for key in keys)
    return "all eight" if len(keys) == len(FEATURE_KEYS) else labels
