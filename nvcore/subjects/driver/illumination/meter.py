"""Brightness over time, from a light meter or else from the pictures as a substitute.

    time_s,lux
    0.00,1020
    0.05,998

Time is that of the recording: frame 0 is at 0 s, frame f at f / fps. Readings before 0 tell what
the eyes were adapted to at the beginning.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.dataset.schema import SAME_S
from nvcore.inputs.readers.parse.table import read_series

LEAST_HELD_S: Final = 1.0
"""Minimum duration for which a reading is valid."""
MOST_LATE: Final = 2.0
"""Maximum number of median steps between readings without a gap. One may be lost. (Our choice.)"""
PICTURE_LEAST: Final = 0.002
"""Minimum mean luminance (share of the maximum). Darker pictures are raised to it."""
_STEP: Final = 4
"""Step between the pixels over which the mean luminance is computed, across and down."""


_SHARE: Final = np.arange(256) / 255
LINEAR: Final = np.where(_SHARE <= 0.04045, _SHARE / 12.92, ((_SHARE + 0.055) / 1.055) ** 2.4)
"""Linear intensity (share of the maximum) by 8-bit sRGB value (IEC 61966-2-1), shape (256,)."""


class LightSource(StrEnum):
    """Source of the brightness."""

    METER = "meter"
    PICTURE = "picture"


@dataclass(frozen=True)
class Light:
    """Brightness over time.

    A reading is valid until the next one. Readings that are more than a second and more than two
    median steps apart leave a *gap*. Readings between two gaps are a *stretch*. The last reading of
    a stretch is valid for a second, or for the median step if that is longer. After that the light
    is unknown.

    Attributes
    ----------
    time_s
        Seconds from frame 0 of the recording, float64, ascending, shape (n,).
    level
        Brightness in the unit of the source, float64, shape (n,), 0 or more.
    source
        Source of the readings.
    """

    time_s: NDArray[np.float64]
    level: NDArray[np.float64]
    source: LightSource = LightSource.METER

    @cached_property
    def step_s(self) -> float:
        """Median step between readings, seconds. 0 for a single reading."""
        return float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0

    @property
    def held_s(self) -> float:
        """Time for which a reading without a successor is valid, seconds."""
        return max(self.step_s, LEAST_HELD_S)

    @property
    def end_s(self) -> float:
        """End of the validity of the last reading, -inf without readings."""
        return float(self.time_s[-1]) + self.held_s if len(self.time_s) else -math.inf

    @cached_property
    def is_first(self) -> NDArray[np.bool_]:
        """Mask of the first reading of each stretch, bool, shape (n,)."""
        longest_s = max(MOST_LATE * self.step_s, LEAST_HELD_S) + SAME_S
        return np.diff(self.time_s, prepend=-np.inf) > longest_s

    @property
    def gaps_s(self) -> NDArray[np.float64]:
        """Times of the readings before and after each gap, float64, shape (n gaps, 2)."""
        after = np.flatnonzero(self.is_first[1:]) + 1
        return np.stack([self.time_s[after - 1], self.time_s[after]], axis=1)

    def at(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the last reading at or before each time, float64, shape (n,).

        NaN before the first reading, in gaps, and after `end_s`.
        """
        return np.where(np.isnan(self.since_s(time_s)), np.nan, self._last(self.level, time_s))

    def since_s(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the start of the stretch that contains each time, seconds, float64, shape (n,).

        NaN where there is no stretch.
        """
        is_last = np.append(self.is_first[1:], True)[: len(self.time_s)]
        held_until_s = np.where(is_last, self.time_s + self.held_s, np.inf)
        first = np.maximum.accumulate(np.arange(len(self.time_s)) * self.is_first)
        begin_s = self.time_s[first]
        is_held = np.asarray(time_s) <= self._last(held_until_s, time_s)
        return np.where(is_held, self._last(begin_s, time_s), np.nan)

    def _last(
        self, values: NDArray[np.float64], time_s: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the value of the last reading at or before each time, NaN before the first."""
        place = np.searchsorted(self.time_s, time_s, side="right") - 1
        # index -1 stands for times before the first reading
        last: NDArray[np.float64] = np.append(values, np.nan)[place]
        return last


def read_light(path: Path) -> Light:
    """Read a light meter's readings from a CSV file with the columns time_s and lux.

    Raises
    ------
    InputError
        If the file cannot be used (`nvcore.inputs.readers.parse.table.read_series`).
    """
    time_s, lux = read_series(path, "lux", what="light readings")
    return Light(time_s, lux)


def picture_level(luminance: NDArray[np.uint8]) -> float:
    """Return the mean luminance of a picture as a share of the maximum, 0 to 1.

    It is computed from every fourth pixel across and down, after linearising the 8-bit sRGB values.

    Parameters
    ----------
    luminance
        8-bit luminance, (h, w).
    """
    counts = np.bincount(luminance[::_STEP, ::_STEP].ravel(), minlength=256)
    return float(counts @ LINEAR / counts.sum())
