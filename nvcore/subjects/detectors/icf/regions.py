"""Regions of a picture in which windows are evaluated: a polygon, a band by size, red places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.subjects.detectors.icf.channels import Bytes, PyramidLevel, integral_images
from nvcore.subjects.detectors.icf.settings import IcfSettings

_SLACK: Final = 0.02
"""Margin added to the band of the training boxes, as a share of the picture's height."""
_LEAST_BOXES: Final = 10
_REDDER: Final = 1.2
"""Minimum ratio of red to green and of red to blue in a red pixel."""
_LEAST_RED: Final = 40


@dataclass(frozen=True)
class Band:
    """Band that holds the centres of objects of a given height, in shares of the picture's height.

    Attributes
    ----------
    at_zero, slope
        Row of the centre: ``at_zero + slope * height``.
    above, below
        Maximum distance of a centre above and below that row.
    """

    at_zero: float
    slope: float
    above: float
    below: float

    def holds(self, row: NDArray[np.float64], height: float) -> NDArray[np.bool_]:
        """Return which of these rows may hold the centre of an object of this height."""
        apart = row - (self.at_zero + self.slope * height)
        return (-self.above <= apart) & (apart <= self.below)


EVERYWHERE: Final = Band(0.0, 0.0, np.inf, np.inf)


def learn_band(row: NDArray[np.float64], height: NDArray[np.float64]) -> Band:
    """Fit the narrowest band along the least-squares line that holds all boxes, plus a margin.

    Parameters
    ----------
    row, height
        Centre and height of the training's boxes as shares of their pictures' height, (n,).

    Returns
    -------
    Band
        The whole picture if there are fewer than 10 boxes, or all have the same height.
    """
    if len(row) < _LEAST_BOXES or np.ptp(height) == 0:
        return EVERYWHERE
    slope, at_zero = (float(value) for value in np.polyfit(height, row, 1))
    apart = row - (at_zero + slope * height)
    return Band(at_zero, slope, float(-apart.min()) + _SLACK, float(apart.max()) + _SLACK)


def open_windows(
    level: PyramidLevel,
    size: tuple[int, int],
    settings: IcfSettings,
    band: Band,
    red: NDArray[np.int32] | None,
) -> NDArray[np.bool_]:
    """Return a mask of the windows of a level to evaluate, bool, (rows, columns).

    Parameters
    ----------
    size
        Width and height of the picture, px.
    red
        Integral image from `red_sums`.
    """
    s, (width, height), (rows, columns) = settings, size, level.grid(settings)
    x = np.arange(0.0, columns) * s.stride * level.across
    y = np.arange(0.0, rows) * s.stride * level.down
    w, h = s.window_width * level.across, s.window_height * level.down
    across, down = (x + w / 2) / width, (y + h / 2) / height
    is_open = np.ones((rows, columns), np.bool_)
    if s.use_band:
        is_open &= band.holds(down, h * s.object_height / s.window_height / height)[:, None]
    if s.region:
        is_open &= in_polygon(across, down, s.region)
    if red is not None:
        left, right = (np.clip(np.rint(x + d), 0, width).astype(int) for d in (0, w))
        top, bottom = (np.clip(np.rint(y + d), 0, height).astype(int) for d in (0, h))
        n = red[bottom][:, right] - red[bottom][:, left]
        n = n - red[top][:, right] + red[top][:, left]
        is_open &= n >= s.red_share * w * h
    return is_open


def red_sums(picture: Bytes, settings: IcfSettings) -> NDArray[np.int32] | None:
    """Return the integral image of red pixels, (h + 1, w + 1). None if proposals are off."""
    if settings.proposals == "none" or picture.ndim == 2:
        return None
    sums: NDArray[np.int32] = integral_images(is_red(picture).astype(np.uint8)[None])[0]
    return sums


def is_red(picture: Bytes) -> NDArray[np.bool_]:
    """Return a mask of the pixels that are clearly more red than green and blue, bool, (h, w)."""
    red = picture[..., 0]
    other = np.maximum(picture[..., 1], picture[..., 2])
    is_redder: NDArray[np.bool_] = (red >= _LEAST_RED) & (red > _REDDER * other)
    return is_redder


def in_polygon(
    x: NDArray[np.float64], y: NDArray[np.float64], corners: tuple[float, ...]
) -> NDArray[np.bool_]:
    """Return which grid points lie in a polygon (even-odd rule), bool, (len(y), len(x))."""
    is_inside = np.zeros((len(y), len(x)), np.bool_)
    px, py = np.array(corners[::2]), np.array(corners[1::2])
    for x0, y0, x1, y1 in zip(px, py, np.roll(px, -1), np.roll(py, -1), strict=True):
        is_crossed = (y0 > y) != (y1 > y)
        if is_crossed.any():  # false for horizontal edges
            at = x0 + (y[is_crossed] - y0) * (x1 - x0) / (y1 - y0)
            is_inside[is_crossed] ^= x[None, :] < at[:, None]
    return is_inside
