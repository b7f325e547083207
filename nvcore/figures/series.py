"""Long series made short enough to draw."""

from __future__ import annotations

from typing import Final

import numpy as np
from tsdownsample import MinMaxLTTBDownsampler

MAX_POINTS: Final = 4000
"""Points of one line: more than a screen has columns, few enough for the browser."""


def decimate(values: np.ndarray, *, n_points: int = MAX_POINTS) -> np.ndarray:
    """Rows that keep the shape of a series when drawn; sorted int64, at most `n_points` of them.

    The smallest and the largest value are always among them, as are the first and the last row.
    """
    n = len(values)
    if n <= n_points:
        return np.arange(n)
    kept = MinMaxLTTBDownsampler().downsample(  # type: ignore[no-untyped-call]
        np.ascontiguousarray(values, dtype=np.float64), n_out=n_points - 2
    )
    extremes = [int(np.argmin(values)), int(np.argmax(values))]
    rows: np.ndarray = np.union1d(kept.astype(np.int64), extremes)
    return rows


def evenly(n: int, *, n_points: int) -> np.ndarray:
    """At most `n_points` rows spread evenly over 0..n-1, both ends included; int64."""
    if n <= n_points:
        return np.arange(n)
    return np.linspace(0, n - 1, n_points).round().astype(np.int64)
