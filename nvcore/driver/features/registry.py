"""Registry of the eight features of a pedestrian, with meaning and computation of each.

References
----------
"Can a Driver Assistance System Determine if a Driver is Perceiving a Pedestrian? Consideration of
the Driver's Visual Adaptation to Illumination Change": the eight features.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.features.view import View


@dataclass(frozen=True)
class Feature:
    """A number that says how well a pedestrian can be seen.

    Attributes
    ----------
    key
        Its column.
    label, unit
        What a person reads.
    meaning
        In a sentence, for help texts.
    of
        Its values for the pedestrians of a picture, float64, shape (n,); NaN undefined.
    needs_colour
        Whether it is undefined in a grey picture.
    is_of_scale
        Whether it is another number for the same view in a picture with more pixels.
    """

    key: str
    label: str
    unit: str
    meaning: str
    of: Callable[[View], NDArray[np.float64]]
    needs_colour: bool = False
    is_of_scale: bool = False


def _apart(of_regions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the absolute difference between pedestrian and surround."""
    apart: NDArray[np.float64] = np.abs(of_regions[:, 0] - of_regions[:, 1])
    return apart


def _luminance_sd(view: View) -> NDArray[np.float64]:
    sd: NDArray[np.float64] = np.sqrt(view.luminance_variance[:, 0])
    return sd


def _lab_distance(view: View) -> NDArray[np.float64]:
    distance: NDArray[np.float64] = np.linalg.norm(view.lab[:, 0] - view.lab[:, 1], axis=-1)
    return distance


def _colour_emd(view: View) -> NDArray[np.float64]:
    """Return the Earth Mover's Distance between colour histograms of pedestrian and surround.

    In one dimension it is the sum of absolute differences of cumulated histograms.
    """
    cumulated = np.cumsum(view.histogram, axis=-1)
    moved = np.abs(cumulated[:, 0] - cumulated[:, 1])[..., :-1]  # the last is 1 in both
    work: NDArray[np.float64] = view.settings.bin_distance * moved.sum(axis=(1, 2))
    return work


def _fixation_distance(view: View) -> NDArray[np.float64]:
    box = view.regions.box
    distance: NDArray[np.float64] = np.linalg.norm(
        box[:, :2] + box[:, 2:] / 2 - view.fixation, axis=-1
    )
    return distance


FEATURES: Final = (
    Feature(
        "width_px",
        "Width",
        "px",
        "Width of the pedestrian.",
        lambda view: view.regions.box[:, 2],
        is_of_scale=True,
    ),
    Feature(
        "height_px",
        "Height",
        "px",
        "Height of the pedestrian.",
        lambda view: view.regions.box[:, 3],
        is_of_scale=True,
    ),
    Feature(
        "luminance_sd",
        "Luminance SD",
        "grey levels",
        "Standard deviation of the 8-bit luminance of the pedestrian: their own contrast.",
        _luminance_sd,
    ),
    Feature(
        "luminance_contrast",
        "Luminance contrast",
        "grey levels",
        "Difference of the mean 8-bit luminance of the pedestrian and their surround.",
        lambda view: _apart(view.luminance),
    ),
    Feature(
        "lab_distance",
        "Lab distance",
        "ΔE",
        "Distance of the mean colours of the pedestrian and their surround in CIE L*a*b*.",
        _lab_distance,
        needs_colour=True,
    ),
    Feature(
        "edge_contrast",
        "Edge contrast",
        "grey levels",
        "Difference of the mean Sobel gradient of the pedestrian and their surround.",
        lambda view: _apart(view.edge_strength),
        is_of_scale=True,
    ),
    Feature(
        "colour_emd",
        "Colour EMD",
        "bins",
        "Earth Mover's Distance of the histograms of R, G and B (16 bins each) of the pedestrian "
        "and their surround, summed over the three.",
        _colour_emd,
        needs_colour=True,
    ),
    Feature(
        "fixation_distance_px",
        "Distance from fixation",
        "px",
        "From the middle of the pedestrian to where the driver looks.",
        _fixation_distance,
        is_of_scale=True,
    ),
)
"""In the order of every table."""
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
