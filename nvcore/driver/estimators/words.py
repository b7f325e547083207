"""Choices of features in words."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from nvcore.driver.features import FEATURE_KEYS, FEATURES

LABELS: Final = {feature.key: feature.label for feature in FEATURES}
"""What each feature is called."""


def words_of(keys: Sequence[str]) -> str:
    """A choice of features in words.

    Examples
    --------
    >>> words_of(["width_px", "edge_contrast"])
    'Width + Edge contrast'
    """
    return (
        "all eight" if len(keys) == len(FEATURE_KEYS) else " + ".join(LABELS[key] for key in keys)
    )
