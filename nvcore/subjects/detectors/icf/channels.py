"""Channels of a picture at all scales: 8-bit planes and their integral images."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import DetectorError, to_8_bits
from nvcore.subjects.detectors.icf.kernels import GREY_LEVELS, gradients
from nvcore.subjects.detectors.icf.settings import OF_COLOUR, ChannelSet, IcfSettings, Magnitude

Bytes = NDArray[np.uint8]

_TO_COLOUR: Final = {
    "hsv": cv2.COLOR_RGB2HSV_FULL,
    # uses linear values; COLOR_RGB2LUV assumes sRGB and undoes its gamma
    "luv": cv2.COLOR_LRGB2LUV,
}
MAX_BYTES: Final = 1 << 31
"""Maximum memory for the channels and integral images of a level."""
_BYTES_OF_PIXEL: Final = 5
"""Memory per channel pixel: 1 byte, and 4 for its integral image."""
_TINY: Final = 1e-6
_RATIOS: Final = (1 / np.sqrt(2), 0.5)


def check_picture(picture: Picture, is_colour: bool) -> Bytes:
    """Convert a picture to what a model needs: 8 bits, grey or RGB.

    Parameters
    ----------
    picture
        (h, w) or (h, w, 3), uint8 or uint16; 16 bits are stretched (`to_8_bits`).
    is_colour
        Whether the model needs RGB. Otherwise RGB becomes grey.

    Raises
    ------
    DetectorError
        If the array is not such a picture, or is grey although the model needs colour.
    """
    is_picture = picture.ndim == 2 or (picture.ndim == 3 and picture.shape[2] == 3)
    if not is_picture or picture.dtype not in (np.uint8, np.uint16) or not picture.size:
        raise DetectorError(
            "expected a grey or RGB picture of 8 or 16 bits, got an array of shape "
            f"{picture.shape} and type {picture.dtype}"
        )
    if is_colour and picture.ndim == 2:
        raise DetectorError(
            "the model was trained on colour and cannot work on a grey picture; train a model on "
            "grey pictures"
        )
    picture = np.ascontiguousarray(to_8_bits(picture))
    if picture.ndim == 3 and not is_colour:
        return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    return picture


def has_colour(picture: Picture) -> bool:
    """Whether any pixel of a picture is not grey."""
    if picture.ndim == 2:
        return False
    return bool((picture[..., 1:] != picture[..., :1]).any())


def plane_names(settings: IcfSettings, is_colour: bool) -> tuple[str, ...]:
    """Return the name of each channel, in the order of `channel_planes`."""
    names: list[str] = []
    for channel in channel_sets(settings, is_colour):
        if channel in OF_COLOUR:
            names += channel.upper()
        elif channel == "orientations":
            turn = 360 if settings.full_circle else 180
            step = turn / settings.orientation_bins
            names += [
                f"gradient {i * step:g}° to {(i + 1) * step:g}°"
                for i in range(settings.orientation_bins)
            ]
        else:
            names.append({"grey": "grey", "magnitude": "gradient"}[channel])
    return tuple(names)


def channel_sets(settings: IcfSettings, is_colour: bool) -> tuple[ChannelSet, ...]:
    """Return the available channel sets. Grey replaces all colour sets for grey pictures."""
    if is_colour:
        return settings.channels
    grey: ChannelSet = "grey"
    sets = (grey if channel in OF_COLOUR else channel for channel in settings.channels)
    return tuple(dict.fromkeys(sets))


def blurred(picture: Bytes, settings: IcfSettings) -> Bytes:
    """Apply the 3x3 Gaussian if the settings ask for it."""
    if not settings.blur:
        return picture
    return np.asarray(cv2.GaussianBlur(picture, (3, 3), 0, borderType=cv2.BORDER_REPLICATE))


def equalised(picture: Bytes, settings: IcfSettings) -> Bytes:
    """Equalise the brightness (Y of YCrCb) if the settings ask for it. Hues stay the same.

    The tile size is as close as possible to that in the settings, with at least one tile.
    """
    if not settings.clahe_clip:
        return picture
    height, width = picture.shape[:2]
    tiles = tuple(max(1, round(side / settings.clahe_tile_px)) for side in (width, height))
    clahe = cv2.createCLAHE(clipLimit=settings.clahe_clip, tileGridSize=tiles)
    if picture.ndim == 2:
        return np.asarray(clahe.apply(picture))
    luma = cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb)
    luma[..., 0] = clahe.apply(luma[..., 0])
    return np.asarray(cv2.cvtColor(luma, cv2.COLOR_YCrCb2RGB))


def channel_planes(picture: Bytes, settings: IcfSettings) -> Bytes:
    """Compute all channels of a picture that has passed `check_picture`.

    Returns
    -------
    uint8, (n_channels, h, w): 0..255 for the channel's 0..1. U is scaled from -134..220, V from
    -140..122, and the magnitude from 0 to that of the largest gradient.
    """
    picture = equalised(blurred(picture, settings), settings)
    shape, is_colour = picture.shape[:2], picture.ndim == 3
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) if is_colour else picture
    magnitude, orientations = np.empty((0, 0), np.uint8), np.empty((0, 0, 0), np.uint8)
    planes: list[Bytes] = []
    for channel in channel_sets(settings, is_colour):
        if channel in OF_COLOUR:
            colours = picture if channel == "rgb" else cv2.cvtColor(picture, _TO_COLOUR[channel])
            planes += cv2.split(colours)
        elif channel == "grey":
            planes.append(grey)
        elif channel == "magnitude":
            planes.append(magnitude := np.empty(shape, np.uint8))
        else:
            planes += [*(orientations := np.zeros((settings.orientation_bins, *shape), np.uint8))]
    if magnitude.size or orientations.size:
        table = _gradient_table(settings.magnitude, settings.orientation_bins, settings.full_circle)
        gradients(grey, table, magnitude, orientations)
    return np.stack(planes)


def integral_images(planes: Bytes, out: NDArray[np.int32] | None = None) -> NDArray[np.int32]:
    """Return the sums of all pixels above and left of each corner, with a border of zeros.

    Parameters
    ----------
    planes
        (n, h, w).
    out
        Buffer of at least n (h + 1) (w + 1) numbers for the result. None: allocate one.

    Returns
    -------
    int32, (n, h + 1, w + 1), modulo 2^32.
    """
    n, height, width = planes.shape
    shape = (n, height + 1, width + 1)
    sums = np.empty(shape, np.int32) if out is None else out[: n * shape[1] * shape[2]]
    sums = sums.reshape(shape)
    for plane, sum_of_plane in zip(planes, sums, strict=True):
        cv2.integral(plane, sum_of_plane, cv2.CV_32S)
    return sums


def resized(picture: Bytes, width: int, height: int) -> Bytes:
    """Resize a picture: halve it while it is at least twice as large, then interpolate."""
    return np.asarray(
        cv2.resize(halved(picture, width, height), (width, height), interpolation=cv2.INTER_LINEAR)
    )


def halved(picture: Bytes, width: float, height: float) -> Bytes:
    """Halve a picture, averaging 2x2 pixels, while it is at least twice the given size."""
    while picture.shape[1] >= 2 * width and picture.shape[0] >= 2 * height:
        size = (picture.shape[1] // 2, picture.shape[0] // 2)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
    return picture


@lru_cache(maxsize=32)
def _gradient_table(magnitude: Magnitude, bins: int, full_circle: bool) -> NDArray[np.uint16]:
    """Return magnitude plus 256 times the orientation bin of every possible gradient."""
    levels = np.arange(GREY_LEVELS) - GREY_LEVELS // 2
    gx, gy = levels[None, :], levels[:, None]
    size: NDArray[Any] = np.hypot(gx, gy) if magnitude == "euclidean" else abs(gx) + abs(gy)
    turn = 2 * np.pi if full_circle else np.pi
    share = np.mod(np.arctan2(gy, gx), turn) / turn
    index = np.minimum((share * bins).astype(np.uint16), bins - 1)
    table: NDArray[np.uint16] = (np.rint(255 * size / size.max()) + 256 * index).astype(np.uint16)
    table.flags.writeable = False
    return table.ravel()


@dataclass(frozen=True, eq=False)
class PyramidLevel:
    """Picture at one scale.

    Attributes
    ----------
    scale
        Divisor of the picture's size.
    width, height
        Size of the level, px.
    across, down
        Pixels of the picture per pixel of the level.
    """

    scale: float
    width: int
    height: int
    across: float
    down: float

    def grid(self, settings: IcfSettings) -> tuple[int, int]:
        """Return the number of rows and columns of whole windows in the level, or (0, 0)."""
        rows = (self.height - settings.window_height) // settings.stride + 1
        columns = (self.width - settings.window_width) // settings.stride + 1
        return (rows, columns) if rows > 0 and columns > 0 else (0, 0)

    def boxes(
        self, row: NDArray[np.int64], column: NDArray[np.int64], settings: IcfSettings
    ) -> NDArray[np.float64]:
        """Return the object's box in each of the given windows, px of the picture.

        Parameters
        ----------
        row, column
            Position of the windows in the grid, (n,).

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
    """Return the levels of a picture that hold a window, in groups that share their channels.

    Channels are computed for the first level of each tuple and approximated for the others.

    Raises
    ------
    DetectorError
        If the channels of a level would take more than 2 GiB.
    """
    every = 1 + settings.scales_between
    groups = []
    for first in range(0, len(settings.scales), every):
        group = []
        for scale in settings.scales[first : first + every]:
            w, h = (math.floor(side / scale + _TINY) for side in (width, height))
            group.append(PyramidLevel(scale, w, h, width / max(w, 1), height / max(h, 1)))
        groups.append(tuple(level for level in group if level.grid(settings)[0]))
    n_channels = len(plane_names(settings, is_colour=True))  # upper bound; grey pictures have fewer
    most = max((level.width * level.height for group in groups for level in group), default=0)
    if most * n_channels * _BYTES_OF_PIXEL > MAX_BYTES:
        raise DetectorError(
            f"a picture of {width}x{height} px, divided by the scale {settings.scales[0]:g}, has "
            f"{most / 1e6:.0f} million pixels, whose {n_channels} channels take "
            f"{most * n_channels * _BYTES_OF_PIXEL / 1e9:.1f} GB; at most {MAX_BYTES / 1e9:.1f} "
            "are possible: begin with a larger scale"
        )
    return [group for group in groups if group]


def planes_of(
    picture: Bytes,
    group: tuple[PyramidLevel, ...],
    settings: IcfSettings,
    powers: NDArray[np.float64],
) -> Iterator[tuple[PyramidLevel, Bytes]]:
    """Yield each level of a group with its channels, uint8, (n_channels, h, w).

    Parameters
    ----------
    powers
        Scaling power of each channel (`scaling_powers`), (n_channels,).
    """
    first, *others = group
    planes = channel_planes(resized(picture, first.width, first.height), settings)
    yield first, planes
    for level in others:
        yield level, rescaled(planes, level.width, level.height, powers)


def rescaled(planes: Bytes, width: int, height: int, powers: NDArray[np.float64]) -> Bytes:
    """Approximate the channels at another size from those at this one.

    ``resized(channel) * r ** -power``, where r is the ratio of the new size to this one.

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
    """Return the power of the scale by which each channel's mean changes, float64, (n_channels,).

    Colour channels have 0. Gradient channels have the mean of ``-log(mean there / mean here) /
    log(scale)`` over pictures at half their size and at 71 % of it, or 0 without pictures.
    """
    names = plane_names(settings, is_colour)
    of_gradient = np.array([name.startswith("gradient") for name in names])
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
