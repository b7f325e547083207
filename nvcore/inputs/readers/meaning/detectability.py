"""Detectability: whether the driver would see a pedestrian by himself, a share from 0 to 1."""

from __future__ import annotations

import numpy as np

from nvcore.inputs.readers.base import Lines


def checked_detectability(values: np.ndarray, lines: Lines) -> np.ndarray:
    """The values, each from 0 to 1 or unknown (NaN); float64, shape (n,).

    Raises
    ------
    FormatError
        With the line of the first that is outside.
    """
    return checked_numbers(values, lines, "detectability", high=1.0)


def checked_numbers(
    values: np.ndarray, lines: Lines, name: str, *, high: float = np.inf
) -> np.ndarray:
    """The values of a column, each from 0 to `high` or NaN; infinity is none.

    Raises
    ------
    FormatError
        With the line of the first that is outside.
    """
    is_good = np.isnan(values) | ((values >= 0) & (values <= high) & ~np.isinf(values))
    if not is_good.all():
        row = int(np.argmin(is_good))
        expected = f"from 0 to {high:g}" if np.isfinite(high) else "of 0 or more"
        raise lines.fault(row, f"expected a {name} {expected}, found {values[row]:g}")
    return values
