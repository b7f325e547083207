"""Compute features of pedestrians from the pixels of their boxes and of the rings around them.

Pictures are interpreted as sRGB (IEC 61966-2-1) with white point D65, the default of videos and
JPEG.

References
----------
CIE 15:2004, Colorimetry (L*a*b*).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import ParameterError
from nvcore.pictures import Picture
from nvcore.subjects.driver.features import kernels
from nvcore.subjects.driver.features.registry import COLOUR_BINS, FeatureSettings
from nvcore.subjects.driver.illumination.meter import LINEAR
from nvcore.subjects.driver.illumination.shapes import check_picture, rows_of

_SHIFT: Final = 8 - (COLOUR_BINS - 1).bit_length()
GREY_LEVELS: Final = 8
"""Maximum difference of channels in a grey picture. Those of grey JPEG pictures differ by 2."""
_SPARSE: Final = 16
"""Row step of a first check whether a picture is grey or coloured."""
_TO_XYZ: Final = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)  # fmt: skip
_CURVE_STEPS: Final = 1 << 11
_KNEE: Final = (6 / 29) ** 3


def _lines() -> NDArray[np.float64]:
    """Approximate the CIE L*a*b* curve by lines between equal steps of 0..1."""
    steps = np.arange(_CURVE_STEPS + 2)
    share = steps / _CURVE_STEPS
    straight = share / (3 * (6 / 29) ** 2) + 4 / 29
    value = np.where(share > _KNEE, np.cbrt(share), straight)
    slope = np.diff(value)
    return np.stack([value[:-1] - steps[:-1] * slope, slope], axis=1)


_TO_PLACE: Final = _TO_XYZ / _TO_XYZ.sum(axis=1, keepdims=True) * _CURVE_STEPS
"""Linear RGB to X, Y, Z as positions in `_LINES`, with white at the end, (3, 3)."""
_LINES: Final = _lines()
"""Value at 0 and slope of the curve's line at each step. L*, a*, b* are accurate to 0.01.

More steps would not fit into the processor's L1 cache (32 kB).
"""


class Regions(NamedTuple):
    """Pixel rectangles of the pedestrians and their surrounds in one picture.

    Attributes
    ----------
    box
        (n, 4): x, y, w, h of the visible part of each box, px. NaN: outside the picture.
    inner
        (n, 4) int64: first column, first row, and one past the last of each, for the pedestrian. A
        pixel counts if its centre lies in the box.
    outer
        Same for the rectangle around it. The surround is this one without `inner`.
    """

    box: NDArray[np.float64]
    inner: NDArray[np.int64]
    outer: NDArray[np.int64]


def features_of(
    picture: Picture,
    boxes: NDArray[np.float64],
    fixation: NDArray[np.float64] | tuple[float, float] | None = None,
    settings: FeatureSettings | None = None,
) -> NDArray[np.float64]:
    """Compute the features of the pedestrians in one picture.

    Parameters
    ----------
    picture
        Grey (h, w) or RGB (h, w, 3), uint8. It counts as grey if its channels never differ by more
        than 8 levels.
    boxes
        (n, 4): x, y, w, h of each pedestrian, px of the picture.
    fixation
        Point at which the driver looks, x and y, px of the picture, or one point for each
        pedestrian (n, 2). None: unknown.
    settings
        Values that the paper leaves open. None: our defaults.

    Returns
    -------
    float64, shape (n, n_features), columns as in `FEATURE_KEYS`. Undefined values are NaN: colours
    in a grey picture, everything but the sizes for a box without a pixel, contrasts if the picture
    ends with the box, and everything for a box outside the picture.

    Raises
    ------
    ParameterError
        If the picture has no pixel, or an argument has another shape or type.

    Examples
    --------
    >>> picture = np.zeros((100, 100), np.uint8)
    >>> picture[20:60, 40:60] = 50
    >>> dict(zip(FEATURE_KEYS, features_of(picture, np.array([[40, 20, 20, 40.0]]))[0].tolist()))
    ... # doctest: +ELLIPSIS, +NORMALIZE_WHITESPACE
    {'width_px': 20.0, 'height_px': 40.0, 'luminance_sd': 0.0, 'luminance_contrast': 50.0, ...}
    """
    check_picture(picture)
    settings, picture = settings or FeatureSettings(), np.ascontiguousarray(picture)
    height, width = picture.shape[:2]
    regions = regions_of(boxes, width, height, settings.surround)
    at = (np.nan, np.nan) if fixation is None else fixation
    points = rows_of(np.atleast_2d(np.asarray(at, np.float64)), 2, "fixation")
    if len(points) not in (1, len(regions.box)):
        raise ParameterError(
            f"fixation: expected one point, or one for each of {len(regions.box)} boxes, found "
            f"{len(points)}"
        )
    luminance, squares, edges = _light(picture, regions)
    lab, histogram = _colour(picture, regions)
    cumulated, size = np.cumsum(histogram, axis=-1), regions.box[:, 2:]
    # in one dimension, the Earth Mover's Distance is between cumulated histograms
    moved = _apart(cumulated)[..., :-1]  # the last is 1 in both
    columns = (
        *size.T,
        np.sqrt(np.maximum(squares - luminance**2, 0)[:, 0]),
        _apart(luminance),
        np.linalg.norm(_apart(lab), axis=-1),
        _apart(edges),
        settings.bin_distance * moved.sum(axis=(1, 2)),
        np.linalg.norm(regions.box[:, :2] + size / 2 - points, axis=-1),
    )
    return np.stack(columns, axis=1)


def regions_of(boxes: NDArray[np.float64], width: int, height: int, surround: float) -> Regions:
    """Return the rectangles of pedestrians and their surrounds, clipped to the picture.

    Parameters
    ----------
    boxes
        (n, 4): x, y, w, h, px. They may extend beyond the picture.
    width, height
        Size of the picture, px.
    surround
        Sides of the rectangle around a box, as a multiple of the box's.

    Raises
    ------
    ParameterError
        If the boxes have another shape.
    """
    x, y, w, h = rows_of(boxes, 4, "boxes").T
    left, top = np.clip(x, 0, width), np.clip(y, 0, height)
    right, bottom = np.clip(x + w, 0, width), np.clip(y + h, 0, height)
    box = np.stack([left, top, right - left, bottom - top], axis=1)
    box[~(box[:, 2:] > 0).all(axis=1)] = np.nan
    beside, above = (surround - 1) / 2 * w, (surround - 1) / 2 * h
    return Regions(
        box,
        _pixels([x, y, x + w, y + h], width, height),
        _pixels([x - beside, y - above, x + w + beside, y + h + above], width, height),
    )


def _pixels(sides: list[NDArray[np.float64]], width: int, height: int) -> NDArray[np.int64]:
    """Return each box as a rectangle of the pixels whose centres it contains, int64, (n, 4)."""
    # a centre on the left or upper edge is inside, one on the right or lower edge outside
    whole = np.ceil(np.nan_to_num(np.clip(np.stack(sides, axis=1), -1.0, 1e9)) - 0.5)
    whole = np.clip(whole, 0, [width, height, width, height]).astype(np.int64)
    whole[:, 2:] = np.maximum(whole[:, 2:], whole[:, :2])
    return whole


def _light(picture: Picture, regions: Regions) -> list[NDArray[np.float64]]:
    """Return means of the luminance, its square and its Sobel gradient, each (n, 2).

    The first column is the pedestrian, the second the surround, NaN without a pixel.
    """
    sums = [np.zeros((len(regions.box), 2)) for _ in range(4)]
    padded = cv2.copyMakeBorder(luminance_of(picture), 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    kernels.light_sums(padded, regions.inner, regions.outer, *sums)
    return [_mean(total, sums[0]) for total in sums[1:]]


def _colour(picture: Picture, regions: Regions) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return mean CIE L*a*b* (n, 2, 3) and shares of R, G and B by bin (n, 2, 3, bins).

    Columns as in `_light`. NaN without colour.
    """
    n = len(regions.box)
    curved, histogram = np.zeros((n, 2, 3)), np.zeros((n, 2, 3, COLOUR_BINS), np.int64)
    if not has_colour(picture):
        return np.full(curved.shape, np.nan), np.full(histogram.shape, np.nan)
    tables = _SHIFT, LINEAR, _TO_PLACE, _LINES
    kernels.colour_sums(picture, regions.inner, regions.outer, *tables, curved, histogram)
    n_pixels = histogram[:, :, 0].sum(axis=-1, dtype=np.float64)
    x, y, z = np.moveaxis(_mean(curved, n_pixels[:, :, None]), -1, 0)
    lab = np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)
    return lab, _mean(histogram.astype(np.float64), n_pixels[:, :, None, None])


def _apart(of_regions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the absolute difference between pedestrian and surround."""
    apart: NDArray[np.float64] = np.abs(of_regions[:, 0] - of_regions[:, 1])
    return apart


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
