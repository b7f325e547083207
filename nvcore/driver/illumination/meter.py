"""How bright it was: from a light meter, else from the pictures, which only stand in for one.

    time_s,lux
    0.00,1020
    0.05,998

Time is that of the recording: frame 0 is at 0 s, frame f at f / fps. Readings before 0 tell what
the eye was adapted to at the beginning.
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

from nvcore.inputs.readers.parse.table import read_series
from nvcore.schema import SAME_S

LEAST_HELD_S: Final = 1.0
"""So long a reading holds at least."""
MOST_LATE: Final = 2.0
"""A reading that comes later than so many median steps leaves a gap: one may be lost; ours."""
PICTURE_LEAST: Final = 0.002
"""Mean luminance (share of the greatest) below which a picture counts as that dark."""
_STEP: Final = 4
"""Every so many pixels across and down the mean luminance of a picture is taken."""


_SHARE: Final = np.arange(256) / 255
LINEAR: Final = np.where(_SHARE <= 0.04045, _SHARE / 12.92, ((_SHARE + 0.055) / 1.055) ** 2.4)
"""Share of the greatest intensity by 8-bit value of sRGB (IEC 61966-2-1), shape (256,)."""


class LightSource(StrEnum):
    """What told how bright it was."""

    METER = "meter"
    PICTURE = "picture"


@dataclass(frozen=True)
class Light:
    """How bright it was.

    A reading holds until the next, but for a second at the most, or as long as readings are apart
    (the median) where that is more. Readings that are further apart leave a *gap*, in which the
    light is not known; where they are more than a second apart as a rule, each may come late by as
    much again. Between gaps there is a *stretch* of readings.

    Attributes
    ----------
    time_s
        Seconds from frame 0 of the recording, float64, ascending, shape (n,).
    level
        Brightness in the unit of the source, float64, shape (n,), 0 or more.
    source
        What it comes from.
    """

    time_s: NDArray[np.float64]
    level: NDArray[np.float64]
    source: LightSource = LightSource.METER

    @cached_property
    def step_s(self) -> float:
        """How far apart readings are, seconds: the median; 0 for a single one."""
        return float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0

    @property
    def held_s(self) -> float:
        """How long a reading holds that none follows, seconds."""
        return max(self.step_s, LEAST_HELD_S)

    @property
    def end_s(self) -> float:
        """Until when the last reading holds; -inf without any."""
        return float(self.time_s[-1]) + self.held_s if len(self.time_s) else -math.inf

    @cached_property
    def is_first(self) -> NDArray[np.bool_]:
        """Readings with which a stretch begins, bool, shape (n,); the first does."""
        longest_s = max(MOST_LATE * self.step_s, LEAST_HELD_S) + SAME_S
        return np.diff(self.time_s, prepend=-np.inf) > longest_s

    @property
    def gaps_s(self) -> NDArray[np.float64]:
        """Times of the readings before and after each gap, float64, shape (n gaps, 2)."""
        after = np.flatnonzero(self.is_first[1:]) + 1
        return np.stack([self.time_s[after - 1], self.time_s[after]], axis=1)

    def at(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The last reading at or before each time, float64, shape (n,).

        NaN before the first, in gaps, and after `end_s`.
        """
        return np.where(np.isnan(self.since_s(time_s)), np.nan, self._last(self.level, time_s))

    def since_s(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Since when there have been readings without a gap, seconds, float64, shape (n,).

        The first reading of the stretch in which each time lies; NaN where there is none.
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
        """The value of the last reading at or before each time; NaN before the first."""
        place = np.searchsorted(self.time_s, time_s, side="right") - 1
        last: NDArray[np.float64] = np.append(values, np.nan)[place]  # place -1: before the first
        return last


def read_light(path: Path) -> Light:
    """Readings of a light meter, from a CSV file with the columns time_s and lux.

    Raises
    ------
    InputError
        If it cannot be used (`nvcore.inputs.readers.parse.table.read_series`).
    """
    time_s, lux = read_series(path, "lux", what="light readings")
    return Light(time_s, lux)


def picture_level(luminance: NDArray[np.uint8]) -> float:
    """Mean luminance of a picture as a share of the greatest, 0 to 1.

    Of every fourth pixel across and down; the 8-bit values are taken as sRGB and made linear.

    Parameters
    ----------
    luminance
        8-bit luminance, (h, w).
    """
    counts = np.bincount(luminance[::_STEP, ::_STEP].ravel(), minlength=256)
    return float(counts @ LINEAR / counts.sum())
