"""A picture at all scales: its channels there, computed or approximated."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import DetectorError
from nvcore.detectors.icf.channels import (
    Bytes,
    channel_planes,
    is_of_gradient,
    plane_names,
    resized,
)
from nvcore.detectors.icf.settings import IcfSettings

MAX_BYTES: Final = 1 << 31
"""Of the channels and integral images of a level."""
_BYTES_OF_PIXEL: Final = 5
"""Of a channel: 1, and 4 of its integral image."""
_TINY: Final = 1e-6
_RATIOS: Final = (1 / np.sqrt(2), 0.5)


@dataclass(frozen=True, eq=False)
class PyramidLevel:
    """A picture at one scale.

    Attributes
    ----------
    scale
        Divisor of the picture's size.
    width, height
        Of the level, px.
    across, down
        Pixels of the picture to one of the level.
    """

    scale: float
    width: int
    height: int
    across: float
    down: float

    def grid(self, settings: IcfSettings) -> tuple[int, int]:
        """Rows and columns of windows that lie wholly in the level; 0, 0 if none does."""
        rows = (self.height - settings.window_height) // settings.stride + 1
        columns = (self.width - settings.window_width) // settings.stride + 1
        return (rows, columns) if rows > 0 and columns > 0 else (0, 0)

    def boxes(
        self, row: NDArray[np.int64], column: NDArray[np.int64], settings: IcfSettings
    ) -> NDArray[np.float64]:
        """Box of the object in each of some windows, px of the picture.

        Parameters
        ----------
        row, column
            Of the windows in the grid, (n,).

        Returns
        -------
        float64, (4, n): left, top, width, height.
        """
        s = settings
        left = (column * s.stride + (s.window_width - s.object_width) / 2) * self.across
        top = (row * s.stride + (s.window_height - s.object_height) / 2) * self.down
        width = np.full(len(row), s.object_width * self.across)
        return np.stack([left, top, width, np.full(len(row), s.object_height * self.down)])


def levels(width: int, height: int, settings: IcfSettings) -> list[tuple[PyramidLevel, ...]]:
    """Levels of a picture of a size that hold a window; those of a tuple share their channels.

    The first of a tuple is computed, the others are approximated from it.

    Raises
    ------
    DetectorError
        If the channels of a level would take more than 2 GiB.
    """
    every = 1 + settings.scales_between
    groups = []
    for first in range(0, len(settings.scales), every):
        group = tuple(
            _level(width, height, scale) for scale in settings.scales[first : first + every]
        )
        groups.append(tuple(level for level in group if level.grid(settings)[0]))
    n_channels = len(plane_names(settings, is_colour=True))  # of a grey picture fewer
    most = max((level.width * level.height for group in groups for level in group), default=0)
    if most * n_channels * _BYTES_OF_PIXEL > MAX_BYTES:
        raise DetectorError(
            f"a picture of {width}x{height} px, divided by the scale {settings.scales[0]:g}, has "
            f"{most / 1e6:.0f} million pixels, whose {n_channels} channels take "
            f"{most * n_channels * _BYTES_OF_PIXEL / 1e9:.1f} GB; at most {MAX_BYTES / 1e9:.1f} "
            "are possible: begin with a larger scale"
        )
    return [group for group in groups if group]


def _level(width: int, height: int, scale: float) -> PyramidLevel:
    w, h = (math.floor(side / scale + _TINY) for side in (width, height))
    return PyramidLevel(scale, w, h, width / max(w, 1), height / max(h, 1))


def planes_of(
    picture: Bytes,
    group: tuple[PyramidLevel, ...],
    settings: IcfSettings,
    powers: NDArray[np.float64],
) -> Iterator[tuple[PyramidLevel, Bytes]]:
    """Each level of a group with its channels, uint8, (n_channels, h, w).

    Parameters
    ----------
    powers
        Of each channel (`scaling_powers`), (n_channels,).
    """
    first = group[0]
    planes = channel_planes(resized(picture, first.width, first.height), settings)
    yield first, planes
    for level in group[1:]:
        yield level, rescaled(planes, level.width, level.height, powers)


def rescaled(planes: Bytes, width: int, height: int, powers: NDArray[np.float64]) -> Bytes:
    """Channels of the picture at another size, approximated from those at this one.

    ``resized(channel) * r ** -power``, r the ratio of the new size to this one.

    References
    ----------
    P. Dollár, R. Appel, S. Belongie, P. Perona: Fast feature pyramids for object detection,
    PAMI 2014.
    """
    ratio = np.sqrt(width * height / (planes.shape[1] * planes.shape[2]))
    new = np.empty((len(planes), height, width), np.uint8)
    for plane, out, power in zip(planes, new, powers, strict=True):
        cv2.resize(plane, (width, height), out, interpolation=cv2.INTER_LINEAR)
        if power:
            cv2.convertScaleAbs(out, out, alpha=ratio**-power)
    return new


def scaling_powers(
    pictures: Iterator[Bytes], settings: IcfSettings, is_colour: bool
) -> NDArray[np.float64]:
    """By which power of the scale the mean of each channel changes, float64, (n_channels,).

    0 for colours. For channels of the gradient the mean over pictures, at half their size and at
    71 % of it, of ``-log(mean there / mean here) / log(scale)``; 0 without pictures.
    """
    of_gradient = is_of_gradient(settings, is_colour)
    powers = []
    for picture in pictures:
        height, width = picture.shape[:2]
        mean = channel_planes(picture, settings).mean(axis=(1, 2))
        for ratio in _RATIOS:
            size = round(width * ratio), round(height * ratio)
            there = channel_planes(resized(picture, *size), settings).mean(axis=(1, 2))
            is_usable = (mean > 0) & (there > 0)
            change = np.where(is_usable, there, 1.0) / np.where(is_usable, mean, 1.0)
            powers.append(-np.log(change) / np.log(ratio))
    if not powers:
        return np.zeros(len(of_gradient))
    return np.where(of_gradient, np.mean(powers, axis=0), 0.0)
