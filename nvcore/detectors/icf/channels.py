"""Channels of a picture: planes of 8 bits, and their integral images."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.detectors.base import DetectorError, to_8_bits
from nvcore.detectors.icf.kernels import GREY_LEVELS, gradients
from nvcore.detectors.icf.settings import OF_COLOUR, ChannelSet, IcfSettings, Magnitude
from nvcore.pictures import Picture

Bytes = NDArray[np.uint8]

_TO_COLOUR: Final = {
    "hsv": cv2.COLOR_RGB2HSV_FULL,
    # of the picture's values as they are; COLOR_RGB2LUV takes them for sRGB and undoes its gamma
    "luv": cv2.COLOR_LRGB2LUV,
}
_EMPTY: Final = {1: np.empty(0, np.uint8), 2: np.empty((0, 0), np.uint8)}


def check_picture(picture: Picture, is_colour: bool) -> Bytes:
    """The picture as a model needs it: 8 bits, grey or RGB.

    Parameters
    ----------
    picture
        (h, w) or (h, w, 3), uint8 or uint16; 16 bits are stretched (`to_8_bits`).
    is_colour
        Whether RGB is needed; else RGB becomes grey.

    Raises
    ------
    DetectorError
        If it is no such picture, or grey where colour is needed.
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
    red, green, blue = (picture[..., i] for i in range(3))
    return bool((red != green).any() or (green != blue).any())


def plane_names(settings: IcfSettings, is_colour: bool) -> tuple[str, ...]:
    """Name of each channel, in the order of `channel_planes`."""
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
    """The sets of channels that there are; grey in place of all colours."""
    if is_colour:
        return settings.channels
    grey: ChannelSet = "grey"
    sets = (grey if channel in OF_COLOUR else channel for channel in settings.channels)
    return tuple(dict.fromkeys(sets))


def is_of_gradient(settings: IcfSettings, is_colour: bool) -> NDArray[np.bool_]:
    """Which channels come from the gradient; bool, (n_channels,)."""
    return np.array([name.startswith("gradient") for name in plane_names(settings, is_colour)])


def blurred(picture: Bytes, settings: IcfSettings) -> Bytes:
    """The picture after the 3x3 Gaussian, if there is to be one."""
    if not settings.blur:
        return picture
    return np.asarray(cv2.GaussianBlur(picture, (3, 3), 0, borderType=cv2.BORDER_REPLICATE))


def equalised(picture: Bytes, settings: IcfSettings) -> Bytes:
    """The picture with its brightness (Y of YCrCb) equalised, if it is to be; hues stay.

    As many tiles as are nearest to the side that the settings give them, at least one.
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
    """All channels of a picture that `check_picture` has passed.

    Returns
    -------
    uint8, (n_channels, h, w): 0..255 for the channel's 0..1. U and V are scaled from -134..220 and
    -140..122, the magnitude from 0 to that of the largest gradient.
    """
    picture = equalised(blurred(picture, settings), settings)
    is_colour = picture.ndim == 3
    names = plane_names(settings, is_colour)
    planes = np.empty((len(names), *picture.shape[:2]), np.uint8)
    magnitude, orientations = _EMPTY[2], np.empty((0, 0, 0), np.uint8)
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) if is_colour else picture
    first = 0
    for channel in channel_sets(settings, is_colour):
        if channel in OF_COLOUR:
            colours = picture if channel == "rgb" else cv2.cvtColor(picture, _TO_COLOUR[channel])
            cv2.split(colours, [planes[first + i] for i in range(3)])
            first += 3
        elif channel == "grey":
            planes[first] = grey
            first += 1
        elif channel == "magnitude":
            magnitude = planes[first]
            first += 1
        else:
            orientations = planes[first : first + settings.orientation_bins]
            orientations[:] = 0
            first += settings.orientation_bins
    if magnitude.size or orientations.size:
        table = _gradient_table(settings.magnitude, settings.orientation_bins, settings.full_circle)
        gradients(grey, table, magnitude, orientations)
    return planes


def integral_images(planes: Bytes, out: NDArray[np.int32] | None = None) -> NDArray[np.int32]:
    """Sums of all pixels above and left of each corner, with a border of zeros.

    Parameters
    ----------
    planes
        (n, h, w).
    out
        At least n (h + 1) (w + 1) numbers to be written to; None: new ones.

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
    """The picture at another size: halved while it is twice as large, then interpolated."""
    return np.asarray(
        cv2.resize(halved(picture, width, height), (width, height), interpolation=cv2.INTER_LINEAR)
    )


def halved(picture: Bytes, width: float, height: float) -> Bytes:
    """The picture halved, by means of 2x2 pixels, while it is twice as large as that or more."""
    while picture.shape[1] >= 2 * width and picture.shape[0] >= 2 * height:
        size = (picture.shape[1] // 2, picture.shape[0] // 2)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA))
    return picture


@lru_cache(maxsize=32)
def _gradient_table(magnitude: Magnitude, bins: int, full_circle: bool) -> NDArray[np.uint16]:
    """Magnitude plus 256 times the bin of the orientation, of every possible gradient."""
    levels = np.arange(GREY_LEVELS) - GREY_LEVELS // 2
    gx, gy = levels[None, :], levels[:, None]
    size: NDArray[Any] = np.hypot(gx, gy) if magnitude == "euclidean" else abs(gx) + abs(gy)
    turn = 2 * np.pi if full_circle else np.pi
    share = np.mod(np.arctan2(gy, gx), turn) / turn
    index = np.minimum((share * bins).astype(np.uint16), bins - 1)
    table: NDArray[np.uint16] = (np.rint(255 * size / size.max()) + 256 * index).astype(np.uint16)
    table.flags.writeable = False
    return table.ravel()
