"""Where in a picture windows are looked at: a polygon, a band by size, red places."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.icf.channels import Bytes, integral_images
from nvcore.detectors.icf.settings import IcfSettings

_SLACK: Final = 0.02
"""By how much the band is wider than the training's boxes, as a share of the picture's height."""
_LEAST_BOXES: Final = 10
_REDDER: Final = 1.2
"""A pixel is red where red is so many times both green and blue."""
_LEAST_RED: Final = 40


@dataclass(frozen=True)
class Band:
    """Where the centres of objects lie by their height, in shares of the picture's height.

    Attributes
    ----------
    at_zero, slope
        Row of the centre: ``at_zero + slope * height``.
    above, below
        How far above and below that row a centre may be.
    """

    at_zero: float
    slope: float
    above: float
    below: float

    def holds(self, row: NDArray[np.float64], height: float) -> NDArray[np.bool_]:
        """Whether centres in these rows may be those of objects of this height."""
        apart = row - (self.at_zero + self.slope * height)
        return (-self.above <= apart) & (apart <= self.below)


EVERYWHERE: Final = Band(0.0, 0.0, np.inf, np.inf)


def learn_band(row: NDArray[np.float64], height: NDArray[np.float64]) -> Band:
    """The narrowest band along the least-squares line that holds all boxes, and a little more.

    Parameters
    ----------
    row, height
        Centre and height of the training's boxes as shares of their pictures' height, (n,).

    Returns
    -------
    Band
        The whole picture where there are fewer than 10 boxes, or all are of one height.
    """
    if len(row) < _LEAST_BOXES or np.ptp(height) == 0:
        return EVERYWHERE
    slope, at_zero = (float(value) for value in np.polyfit(height, row, 1))
    apart = row - (at_zero + slope * height)
    return Band(at_zero, slope, float(-apart.min()) + _SLACK, float(apart.max()) + _SLACK)


@dataclass(frozen=True, eq=False)
class OpenWindows:
    """Which windows of a picture are looked at.

    Attributes
    ----------
    settings, band
        Of the detector.
    width, height
        Of the picture, px.
    red
        Integral image of the red pixels (0 or 1), (h + 1, w + 1); None: not asked for.
    """

    settings: IcfSettings
    band: Band
    width: int
    height: int
    red: NDArray[np.int32] | None

    def are_open(
        self, x: NDArray[np.float64], y: NDArray[np.float64], w: float, h: float
    ) -> NDArray[np.bool_]:
        """Windows of one size that are looked at.

        Parameters
        ----------
        x, y
            Left of each column and top of each row of windows, px of the picture.
        w, h
            Size of the windows, px of the picture.

        Returns
        -------
        bool, (rows, columns).
        """
        across, down = (x + w / 2) / self.width, (y + h / 2) / self.height
        is_open = np.ones((len(y), len(x)), np.bool_)
        if self.settings.use_band:
            object_height = h * self.settings.object_height / self.settings.window_height
            is_open &= self.band.holds(down, object_height / self.height)[:, None]
        if self.settings.region:
            is_open &= in_polygon(across, down, self.settings.region)
        if self.red is not None:
            left, right = (np.clip(np.rint(x + d), 0, self.width).astype(int) for d in (0, w))
            top, bottom = (np.clip(np.rint(y + d), 0, self.height).astype(int) for d in (0, h))
            red = self.red
            n = red[bottom][:, right] - red[bottom][:, left]
            n = n - red[top][:, right] + red[top][:, left]
            is_open &= n >= self.settings.red_share * w * h
        return is_open


def places(picture: Bytes, settings: IcfSettings, band: Band) -> OpenWindows:
    """Which windows of a picture are looked at; a grey one has no red places and is all open."""
    height, width = picture.shape[:2]
    red = None
    if settings.proposals == "red" and picture.ndim == 3:
        red = integral_images(is_red(picture).astype(np.uint8)[None])[0]
    return OpenWindows(settings, band, width, height, red)


def is_red(picture: Bytes) -> NDArray[np.bool_]:
    """Pixels that are clearly more red than green and blue; bool, (h, w)."""
    red = picture[..., 0]
    other = np.maximum(picture[..., 1], picture[..., 2])
    is_redder: NDArray[np.bool_] = (red >= _LEAST_RED) & (red > _REDDER * other)
    return is_redder


def in_polygon(
    x: NDArray[np.float64], y: NDArray[np.float64], corners: tuple[float, ...]
) -> NDArray[np.bool_]:
    """Which points of a grid lie in a polygon (even-odd rule); bool, (len(y), len(x))."""
    is_inside = np.zeros((len(y), len(x)), np.bool_)
    px, py = np.array(corners[::2]), np.array(corners[1::2])
    for x0, y0, x1, y1 in zip(px, py, np.roll(px, -1), np.roll(py, -1), strict=True):
        is_crossed = (y0 > y) != (y1 > y)
        if is_crossed.any():  # not of an edge that lies flat
            at = x0 + (y[is_crossed] - y0) * (x1 - x0) / (y1 - y0)
            is_inside[is_crossed] ^= x[None, :] < at[:, None]
    return is_inside
