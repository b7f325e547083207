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
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.srgb import LINEAR
from nvcore.inputs.readers.parse.table import read_table

LIGHT_COLUMNS: Final = ("time_s", "lux")
LEAST_HELD_S: Final = 1.0
"""So long the last reading holds at least."""
PICTURE_LEAST: Final = 0.002
"""Mean luminance (share of the greatest) below which a picture counts as that dark."""
_STEP: Final = 4
"""Every so many pixels across and down the mean luminance of a picture is taken."""


class LightSource(StrEnum):
    """What told how bright it was."""

    METER = "meter"
    PICTURE = "picture"


LIGHT_UNIT: Final = {
    LightSource.METER: "lx",
    LightSource.PICTURE: "mean luminance, 0 to 1",
}


@dataclass(frozen=True)
class Light:
    """How bright it was.

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

    @property
    def end_s(self) -> float:
        """Until when the last reading holds: as others do, at least a second; -inf without any."""
        if not len(self.time_s):
            return -math.inf
        steps = np.diff(self.time_s)
        return float(self.time_s[-1] + max(np.median(steps) if len(steps) else 0.0, LEAST_HELD_S))

    def at(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """The last reading at or before each time, float64, shape (n,).

        NaN before the first, and after `end_s`.
        """
        place = np.searchsorted(self.time_s, time_s, side="right") - 1
        readings = np.concatenate([self.level, [np.nan]])  # place -1: before the first
        return np.where(np.asarray(time_s) <= self.end_s, readings[place], np.nan)


def read_light(path: Path) -> Light:
    """Readings of a light meter, from a CSV file with the columns time_s and lux.

    Raises
    ------
    InputError
        If it cannot be opened, or, with the line, a field is no number, less than 0 lx, or a time
        is not after the one before.
    """
    table = read_table(path, what="light readings", required=LIGHT_COLUMNS)
    time_s = table.numbers("time_s")
    lux = table.numbers("lux", low=0)
    backwards = np.flatnonzero(np.diff(time_s) <= 0)
    if len(backwards):
        row = int(backwards[0]) + 1
        raise table.fault(
            row,
            f"time_s: expected a time after {time_s[row - 1]:g} of the row before, "
            f"found {time_s[row]:g}",
        )
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
