"""The features of a pedestrian's picture by name: their order in arrays and files."""

from __future__ import annotations

from typing import Final

FEATURE_WORDS: Final = {
    "width_px": "width",
    "height_px": "height",
    "luminance_sd": "luminance SD",
    "luminance_contrast": "luminance contrast",
    "lab_distance": "Lab distance",
    "edge_contrast": "edge contrast",
    "colour_emd": "colour EMD",
    "fixation_distance_px": "fixation distance",
}
"""What each is called in tables and figures."""
FEATURE_KEYS: Final = tuple(FEATURE_WORDS)


def words_of(keys: tuple[str, ...]) -> str:
    """A choice of features in words.

    Examples
    --------
    >>> words_of(("width_px", "edge_contrast"))
    'width + edge contrast'
    """
    is_all = len(keys) > 2 and set(keys) == set(FEATURE_KEYS)
    return "all eight" if is_all else " + ".join(FEATURE_WORDS[key] for key in keys)
