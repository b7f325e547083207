"""Features: sums of a channel over a rectangle in the window, or differences of two sums."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.metrics.kernels import over_ranges
from nvcore.subjects.detectors.base import DetectorError
from nvcore.subjects.detectors.icf.kernels import feature_values
from nvcore.subjects.detectors.icf.settings import IcfSettings

Features = NDArray[np.int32]
"""(n, 10): channel, left, top, right, bottom of a rectangle in the window, px, right and bottom
excluded. Then the same for the subtracted rectangle, -1 if there is none.
"""

N_COLUMNS: Final = 10
_MOST_OFFSETS: Final = 1 << 32


def draw_features(settings: IcfSettings, n_channels: int, seed: int) -> Features:
    """Draw a pool of features with random channel, position and size.

    The sides of a rectangle are two different columns and two different rows, drawn uniformly and
    redrawn if the area is too small. The subtracted rectangle of a difference has the same size but
    its own position and channel.
    """
    rng = np.random.default_rng(seed)
    size = settings.window_width, settings.window_height
    corners = np.empty((0, 4), np.int32)
    while len(corners) < settings.features:
        x = rng.integers(0, size[0] + 1, (settings.features, 2))
        y = rng.integers(0, size[1] + 1, (settings.features, 2))
        x.sort(axis=1)
        y.sort(axis=1)
        is_large = np.diff(x)[:, 0] * np.diff(y)[:, 0] >= settings.least_area
        drawn = np.stack([x[:, 0], y[:, 0], x[:, 1], y[:, 1]], axis=1)[is_large]
        corners = np.concatenate([corners, drawn])
    n = settings.features
    features = np.full((n, N_COLUMNS), -1, np.int32)
    features[:, 0] = rng.integers(0, n_channels, n)
    features[:, 1:5] = corners[:n]
    is_difference = np.arange(n) < round(settings.difference_share * n)
    first = features[is_difference]
    for low, high, side in ((1, 3, size[0]), (2, 4, size[1])):
        length = first[:, high] - first[:, low]
        first[:, low + 5] = rng.integers(0, side - length + 1)
        first[:, high + 5] = first[:, low + 5] + length
    first[:, 5] = rng.integers(0, n_channels, len(first))
    features[is_difference] = first
    return features


def corner_offsets(features: Features, width: int, height: int) -> NDArray[np.uint32]:
    """Return the offsets of each feature's corners in integral images of pictures of a size.

    Returns
    -------
    uint32, (n, 8): offsets from the window's first corner in the flat array of
    `nvcore.subjects.detectors.icf.channels.integral_images`, in the order top left, top right,
    bottom left, bottom right of both rectangles. Offsets of a missing second one are 0, so that its
    sum is 0.

    Raises
    ------
    DetectorError
        If the pictures are so large that an offset exceeds 32 bits.
    """
    across, plane = width + 1, (width + 1) * (height + 1)
    n_channels = 1 + int(features[:, [0, 5]].max(initial=-1))
    if n_channels * plane > _MOST_OFFSETS:
        raise DetectorError(
            f"a picture of {width}x{height} px is too large for {n_channels} channels: begin with "
            "a larger scale"
        )
    offsets = np.zeros((len(features), 8), np.uint32)
    for half in (0, 1):
        channel, left, top, right, bottom = features[:, 5 * half : 5 * half + 5].T.astype(np.int64)
        first = channel * plane
        four = [first + y * across + x for y in (top, bottom) for x in (left, right)]
        offsets[:, 4 * half : 4 * half + 4] = np.where(channel < 0, 0, np.array(four)).T
    return offsets


def has_differences(features: Features) -> bool:
    """Whether any feature is the difference of two rectangles."""
    return bool((features[:, 5] >= 0).any())


def values_at(
    sums: NDArray[np.int32], base: NDArray[np.int64], features: Features
) -> NDArray[np.int32]:
    """Return the values of all features at windows of one picture, or of many small ones.

    Parameters
    ----------
    sums
        Integral images, (n_channels, h + 1, w + 1) or (n_pictures, n_channels, h + 1, w + 1).
    base
        Offset of each window in the flat array, (n_windows,).

    Returns
    -------
    int32, (n_windows, n_features): sums in units of 1/255 of a channel's range.
    """
    values = np.empty((len(base), len(features)), np.int32)
    corners = corner_offsets(features, sums.shape[-1] - 1, sums.shape[-2] - 1)
    flat, has_second = sums.reshape(-1), has_differences(features)
    over_ranges(feature_values, len(base), flat, base, corners, has_second, values, least=1)
    return values
