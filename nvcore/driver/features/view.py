"""Pixel averages of each pedestrian in one picture, from which features are computed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.driver.features import colour, kernels
from nvcore.driver.features.settings import COLOUR_BINS, FeatureSettings
from nvcore.driver.illumination.meter import LINEAR
from nvcore.driver.shapes import rows_of
from nvcore.errors import ParameterError
from nvcore.pictures import Picture

_SHIFT: Final = 8 - (COLOUR_BINS - 1).bit_length()
GREY_LEVELS: Final = 8
"""Channels that differ by no more are grey: those of grey JPEG pictures differ by 2."""
_SPARSE: Final = 16
"""Every so many rows are looked at first to tell a grey picture from a coloured one."""


@dataclass(frozen=True)
class Regions:
    """Pixel rectangles of the pedestrians and their surrounds in one picture.

    Attributes
    ----------
    box
        (n, 4): x, y, w, h of the part of each box that lies in the picture, px; NaN: none does.
    inner
        (n, 4) int64: first column, first row, and one past the last of each: the pedestrian. A
        pixel counts if its middle lies in the box.
    outer
        The same of the rectangle around it; the surround is this one without `inner`.
    """

    box: NDArray[np.float64]
    inner: NDArray[np.int64]
    outer: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.box)


def regions_of(boxes: NDArray[np.float64], width: int, height: int, surround: float) -> Regions:
    """Return the rectangles of pedestrians and their surrounds, clipped to the picture.

    Parameters
    ----------
    boxes
        (n, 4): x, y, w, h, px; they may reach out of the picture.
    width, height
        Of the picture.
    surround
        Sides of the rectangle around a box, as a multiple of the box's.

    Raises
    ------
    ParameterError
        If the boxes are of another shape.
    """
    x, y, w, h = rows_of(boxes, 4, "boxes").T
    left, top = np.clip(x, 0, width), np.clip(y, 0, height)
    right, bottom = np.clip(x + w, 0, width), np.clip(y + h, 0, height)
    box = np.stack([left, top, right - left, bottom - top], axis=1)
    box[~(box[:, 2:] > 0).all(axis=1)] = np.nan
    beside, above = (surround - 1) / 2 * w, (surround - 1) / 2 * h
    return Regions(
        box,
        _pixels(x, y, x + w, y + h, width, height),
        _pixels(x - beside, y - above, x + w + beside, y + h + above, width, height),
    )


def _pixels(
    left: NDArray[np.float64],
    top: NDArray[np.float64],
    right: NDArray[np.float64],
    bottom: NDArray[np.float64],
    width: int,
    height: int,
) -> NDArray[np.int64]:
    """Return each box as a rectangle of the pixels whose centres it contains, int64, (n, 4)."""
    ends = np.stack([left, top, right, bottom], axis=1)
    # a middle on the left or upper edge is inside, one on the right or lower edge is not
    whole = np.ceil(np.nan_to_num(np.clip(ends, -1.0, 1e9)) - 0.5)
    whole = np.clip(whole, 0, [width, height, width, height]).astype(np.int64)
    whole[:, 2:] = np.maximum(whole[:, 2:], whole[:, :2])
    return whole


@dataclass(frozen=True, eq=False)
class View:
    """Pedestrians in one picture, with the pixel averages behind their features.

    Arrays have a row for each pedestrian. Of two columns, the first is the pedestrian, the second
    their surround; NaN where there is no pixel.

    Attributes
    ----------
    picture
        Grey (h, w) or RGB (h, w, 3), uint8.
    regions
        Pixels of the pedestrians and of their surrounds.
    fixation
        (n, 2): where the driver looked, px; NaN unknown.
    settings
        Of the features.
    """

    picture: Picture
    regions: Regions
    fixation: NDArray[np.float64]
    settings: FeatureSettings

    @cached_property
    def has_colour(self) -> bool:
        """Whether the picture has colour."""
        return has_colour(self.picture)

    @cached_property
    def _light(self) -> tuple[NDArray[np.float64], ...]:
        n = len(self.regions)
        sums = tuple(np.zeros((n, 2)) for _ in range(4))
        padded = cv2.copyMakeBorder(luminance_of(self.picture), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
        kernels.light_sums(padded, self.regions.inner, self.regions.outer, *sums)
        count, *others = sums
        return tuple(_mean(total, count) for total in others)

    @property
    def luminance(self) -> NDArray[np.float64]:
        """Mean 8-bit luminance of pedestrian and surround, (n, 2)."""
        return self._light[0]

    @property
    def luminance_variance(self) -> NDArray[np.float64]:
        """Variance of the 8-bit luminance over the pixels of pedestrian and surround, (n, 2)."""
        variance: NDArray[np.float64] = np.maximum(self._light[1] - self.luminance**2, 0)
        return variance

    @property
    def edge_strength(self) -> NDArray[np.float64]:
        """Mean length of the 3 x 3 Sobel gradient in pedestrian and surround, (n, 2).

        The gradient is not normalised.
        """
        return self._light[2]

    @cached_property
    def _colour(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        n = len(self.regions)
        curved = np.zeros((n, 2, 3))
        histogram = np.zeros((n, 2, 3, COLOUR_BINS), np.int64)
        if not self.has_colour:
            return np.full((n, 2, 3), np.nan), np.full(histogram.shape, np.nan)
        kernels.colour_sums(
            self.picture,
            self.regions.inner,
            self.regions.outer,
            _SHIFT,
            LINEAR,
            colour.TO_PLACE,
            colour.LINES,
            curved,
            histogram,
        )
        n_pixels = histogram[:, :, 0].sum(axis=-1, dtype=np.float64)
        lab = colour.lab_of(_mean(curved, n_pixels[:, :, None]))
        return lab, _mean(histogram.astype(np.float64), n_pixels[:, :, None, None])

    @property
    def lab(self) -> NDArray[np.float64]:
        """Mean CIE L*a*b* colour of pedestrian and surround, (n, 2, 3), NaN without colour."""
        return self._colour[0]

    @property
    def histogram(self) -> NDArray[np.float64]:
        """Share of pixels in each bin of R, G and B, (n, 2, 3, bins), NaN without colour."""
        return self._colour[1]


def view_of(
    picture: Picture,
    boxes: NDArray[np.float64],
    fixation: NDArray[np.float64] | tuple[float, float] | None,
    settings: FeatureSettings,
) -> View:
    """Build the view of a picture, checking the shapes of boxes and fixation.

    Raises
    ------
    ParameterError
        If boxes or fixation are of another shape.
    """
    height, width = picture.shape[:2]
    regions = regions_of(boxes, width, height, settings.surround)
    at = (np.nan, np.nan) if fixation is None else fixation
    one_or_each = rows_of(np.atleast_2d(np.asarray(at, np.float64)), 2, "fixation")
    if len(one_or_each) not in (1, len(regions)):
        raise ParameterError(
            f"fixation: expected one point, or one for each of {len(regions)} boxes, found "
            f"{len(one_or_each)}"
        )
    points = np.broadcast_to(one_or_each, (len(regions), 2))
    return View(np.ascontiguousarray(picture), regions, points, settings)


def luminance_of(picture: Picture) -> NDArray[np.uint8]:
    """Return the 8-bit luminance 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601), rounded."""
    if picture.ndim == 2:
        return np.asarray(picture, np.uint8)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), np.uint8)


def has_colour(picture: Picture) -> bool:
    """Whether two channels of a picture differ by more than `GREY_LEVELS` in any pixel."""
    if picture.ndim == 2:
        return False
    return any(
        int(cv2.absdiff(*(cv2.extractChannel(part, i) for i in pair)).max()) > GREY_LEVELS
        for part in (np.ascontiguousarray(picture[::_SPARSE]), picture)
        for pair in ((0, 2), (0, 1), (1, 2))
    )


def _mean(total: NDArray[np.float64], count: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(invalid="ignore"):
        mean: NDArray[np.float64] = total / count
    return mean
