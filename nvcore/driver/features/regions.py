"""Pixels of a pedestrian and of their surround."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.shapes import rows_of


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
