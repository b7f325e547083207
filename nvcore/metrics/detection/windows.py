"""Number of windows that a sliding-window detector examines in an image."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from nvcore.common.errors import ParameterError
from nvcore.dataset import Dataset

WindowCount = Literal["whole", "area"]

_TINY: Final = 1e-6  # px: tolerates a picture that is too small by a rounding error


@dataclass(frozen=True)
class WindowGrid:
    """Window that slides over an image, which is shrunk by one scale after another.

    Attributes
    ----------
    width, height
        Size of the window, px of the shrunk image.
    stride
        Step between two windows, px of the shrunk image.
    scales
        Divisors of the image's size.
    count
        ``"whole"``: exact count of the windows that lie entirely in the shrunk image,
        ``(floor((W/s - w) / stride) + 1) * (floor((H/s - h) / stride) + 1)``. ``"area"``: the
        formula of some reports, ``(W/s - w) * (H/s - h) / stride^2``.

    Raises
    ------
    ParameterError
        If a value is not positive, or there is no scale.
    """

    width: float
    height: float
    stride: float = 1.0
    scales: tuple[float, ...] = (1.0,)
    count: WindowCount = "whole"

    def __post_init__(self) -> None:
        values = (self.width, self.height, self.stride, *self.scales)
        if not self.scales or not all(0 < value < math.inf for value in values):
            raise ParameterError(
                "windows: expected positive width, height, stride and scales, got "
                f"{self.width:g}, {self.height:g}, {self.stride:g} and {self.scales!r}"
            )
        if self.count not in ("whole", "area"):
            raise ParameterError(f"count: expected whole or area, got {self.count!r}")

    def per_image(self, width: np.ndarray | float, height: np.ndarray | float) -> np.ndarray:
        """Count the windows in images of a size in px, float64, in the common shape of both."""
        scales = np.array(self.scales)
        across = np.asarray(width, dtype=float)[..., None] / scales - self.width
        down = np.asarray(height, dtype=float)[..., None] / scales - self.height
        fits = (across >= -_TINY) & (down >= -_TINY)
        if self.count == "area":
            n = across * down / self.stride**2
        else:
            n = _places(across, self.stride) * _places(down, self.stride)
        total: np.ndarray = np.where(fits, n, 0.0).sum(axis=-1)
        return total


def scale_steps(first: float, last: float, step: float) -> tuple[float, ...]:
    """Return the scales from the first to the last, both included.

    Raises
    ------
    ParameterError
        If the scales do not increase from a positive first one.

    Examples
    --------
    >>> scale_steps(1.0, 1.7, 0.1)
    (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7)
    """
    if not (0 < first <= last < math.inf and 0 < step < math.inf):
        raise ParameterError(
            "the first scale must be above 0, the last at least as large, and the step above 0; "
            f"got first {first:g}, last {last:g}, step {step:g}"
        )
    n = math.floor((last - first) / step + _TINY) + 1
    return tuple(round(first + i * step, 12) for i in range(n))


def windows_per_image(dataset: Dataset, is_counted: np.ndarray, grid: WindowGrid) -> float:
    """Return the mean number of windows over images, or NaN without images.

    Parameters
    ----------
    is_counted
        Frames that count (`nvcore.metrics.detection.filtered_truth.FilteredTruth`); bool,
        (n_frames,).
    """
    frames = dataset.frame_columns
    n_images = np.bincount(frames.recording[is_counted], minlength=len(dataset.recordings))
    if not n_images.sum():
        return math.nan
    return float(np.average(grid.per_image(frames.width, frames.height), weights=n_images))


def _places(room: np.ndarray, stride: float) -> np.ndarray:
    """Count the positions of a window along a side that is `room` px longer than the window."""
    places: np.ndarray = np.floor((room + _TINY) / stride) + 1
    return places
