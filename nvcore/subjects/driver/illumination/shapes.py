"""Validation of arrays and settings from callers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nvcore.common.errors import ParameterError


def check_picture(picture: object) -> None:
    """Validate an 8-bit picture: grey (h, w) or RGB (h, w, 3), with at least one pixel.

    Raises
    ------
    ParameterError
        Names what was found instead.
    """
    if not isinstance(picture, np.ndarray):
        raise ParameterError(
            f"picture: expected an array of pixels, found {type(picture).__name__}"
        )
    is_shaped = picture.ndim == 2 or (picture.ndim == 3 and picture.shape[2] == 3)
    if picture.dtype != np.uint8 or not is_shaped or not picture.size:
        raise ParameterError(
            "picture: expected uint8 of the shape (h, w) or (h, w, 3), with a pixel, found "
            f"{picture.dtype} of the shape {picture.shape}"
        )


def rows_of(values: ArrayLike, n_columns: int, name: str) -> NDArray[np.float64]:
    """Convert to rows of numbers, float64, shape (n, n_columns). NaN stands for unknown.

    Parameters
    ----------
    name
        Name for error messages.

    Raises
    ------
    ParameterError
        If the values have another shape, are not numbers, or are infinite.
    """
    try:
        rows = np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise ParameterError(f"{name}: expected numbers ({error})") from error
    if rows.ndim != 2 or rows.shape[1] != n_columns:
        raise ParameterError(
            f"{name}: expected the shape (n, {n_columns}), found {rows.shape}; give one row each"
        )
    if np.isinf(rows).any():
        raise ParameterError(f"{name}: expected numbers, or NaN for not known, found infinity")
    return rows


def check_ranges(settings: object, ranges: Mapping[str, tuple[float, float]]) -> None:
    """Reject settings that are NaN or outside their ranges.

    Raises
    ------
    ParameterError
        States the name of the field, its range and its value.
    """
    for name, (low, high) in ranges.items():
        value = getattr(settings, name)
        if not low <= value <= high:
            raise ParameterError(f"{name}: expected {low:g} to {high:g}, found {value:g}")
