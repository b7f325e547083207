"""The colours of X, Y and the truth: the same in every figure, picture and video.

Colour-blind people can tell them apart; dash and thickness distinguish them a second time.
"""

from __future__ import annotations

from typing import Final, Literal

Theme = Literal["light", "dark"]

X_COLOUR: Final[dict[Theme, str]] = {"light": "#0067B1", "dark": "#4DA3FF"}
"""System X, drawn solid."""

Y_COLOUR: Final[dict[Theme, str]] = {"light": "#C45A00", "dark": "#FFA033"}
"""System Y, drawn dashed."""

TRUTH_COLOUR: Final[dict[Theme, str]] = {"light": "#3D4650", "dark": "#E6EAF0"}
"""Ground truth, drawn thin."""


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green, blue, 0..255.

    Examples
    --------
    >>> rgb("#0067B1")
    (0, 103, 177)
    """
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
