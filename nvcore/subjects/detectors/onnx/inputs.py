"""Conversion of a picture to a network's input array, and of boxes back to the picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.pictures import Picture
from nvcore.subjects.detectors.base import to_8_bits
from nvcore.subjects.detectors.onnx.layouts import Size
from nvcore.subjects.detectors.onnx.settings import OnnxSettings

MEAN: Final = (0.485, 0.456, 0.406)
SPREAD: Final = (0.229, 0.224, 0.225)
"""Standard deviation of ImageNet's colours, red first, as shares of white."""


@dataclass(frozen=True)
class PictureForm:
    """Form of a network's input array.

    Attributes
    ----------
    size
        Width and height, px.
    n_channels
        1 for grey, 3 for colour.
    is_last, has_batch
        Whether the channels are the last axis, and whether there is a batch axis.
    dtype
        Type of the array.
    """

    size: Size
    n_channels: int
    is_last: bool
    has_batch: bool
    dtype: np.dtype[Any]


@dataclass(frozen=True)
class Fitting:
    """Position of a picture in the input: pixel x of the picture is at ``left + x * across``."""

    across: float
    down: float
    left: int
    top: int

    def to_picture(self, corners: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert left, top, right, bottom from input pixels to picture pixels, (n, 4)."""
        moved: NDArray[np.float64] = corners - np.tile([self.left, self.top], 2)
        sides: NDArray[np.float64] = moved / np.tile([self.across, self.down], 2)
        return sides


def network_input(
    picture: Picture, form: PictureForm, settings: OnnxSettings
) -> tuple[NDArray[Any], Fitting]:
    """Return the input array for a picture, and the picture's position in it."""
    picture = to_8_bits(picture, always=settings.stretch_8_bit)
    n_own = 1 if picture.ndim == 2 else 3
    if n_own != form.n_channels:
        code = cv2.COLOR_GRAY2RGB if n_own == 1 else cv2.COLOR_RGB2GRAY
        picture = cv2.cvtColor(picture, code)
    elif n_own == 3 and settings.colour == "bgr":
        picture = picture[..., ::-1]
    resized, fitting = _resized(picture, form.size, settings)
    values = resized.reshape(*resized.shape[:2], form.n_channels)
    array = _scaled(values, form, settings)
    if not form.is_last:
        array = np.moveaxis(array, 2, 0)
    if form.has_batch:
        array = array[np.newaxis]
    return np.ascontiguousarray(array, dtype=form.dtype), fitting


def _resized(picture: Picture, size: Size, settings: OnnxSettings) -> tuple[Picture, Fitting]:
    (width, height), (own_height, own_width) = size, picture.shape[:2]
    new = width, height
    if settings.fit != "stretch":
        factor = min(width / own_width, height / own_height)
        new = max(1, round(own_width * factor)), max(1, round(own_height * factor))
    resized = np.ascontiguousarray(picture)
    if new != (own_width, own_height):
        resized = cv2.resize(resized, new, interpolation=cv2.INTER_LINEAR)
    is_centred = settings.fit == "letterbox"
    left, top = ((width - new[0]) // 2, (height - new[1]) // 2) if is_centred else (0, 0)
    if new != (width, height):
        canvas = np.full((height, width, *resized.shape[2:]), settings.fill, dtype=np.uint8)
        canvas[top : top + new[1], left : left + new[0]] = resized
        resized = canvas
    return resized, Fitting(new[0] / own_width, new[1] / own_height, left, top)


def _scaled(values: NDArray[np.uint8], form: PictureForm, settings: OnnxSettings) -> NDArray[Any]:
    if settings.values == "0..255" or form.dtype.kind == "u":
        return values
    shares = values.astype(np.float32) / np.float32(255)
    if settings.values == "0..1":
        return shares
    mean, spread = (np.array(numbers[: form.n_channels], np.float32) for numbers in (MEAN, SPREAD))
    if settings.colour == "bgr":
        mean, spread = mean[::-1], spread[::-1]
    return (shares - mean) / spread
