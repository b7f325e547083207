"""Fixation point of the driver, from a gaze file or assumed fixed.

    frame,x,y
    212,960.5,540

Pixels refer to the picture of visible light, or to the recording if there is none. A frame without
a row (a blink, a gap of the tracker) has no fixation, and values that depend on it are undefined.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.common.errors import FormatError, ParameterError
from nvcore.inputs.readers.parse.table import read_table
from nvcore.inputs.readers.parse.text import MAX_INTEGER
from nvcore.subjects.driver.inputs.study_tables import LARGEST

GAZE_COLUMNS: Final = ("frame", "x", "y")


@dataclass(frozen=True)
class Gaze:
    """Gaze points of the driver, one per frame.

    Attributes
    ----------
    frame
        Frame numbers, int64, ascending, shape (n,).
    point
        x and y, px, float64, shape (n, 2).
    """

    frame: NDArray[np.int64]
    point: NDArray[np.float64]

    def at(self, frames: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return gaze points in these frames, px, float64, (n, 2), NaN for frames without one."""
        frames = np.asarray(frames, np.int64)
        points = np.full((len(frames), 2), np.nan)
        if not len(self.frame):
            return points
        place = np.minimum(np.searchsorted(self.frame, frames), len(self.frame) - 1)
        has_row = self.frame[place] == frames
        points[has_row] = self.point[place[has_row]]
        return points


def read_gaze(path: Path) -> Gaze:
    """Read gaze points from a CSV file with the columns frame, x and y.

    Points may lie outside the picture. No pedestrian is near the fixation in that case.

    Raises
    ------
    InputError
        If the file cannot be opened, all points are in 0 to 1 like shares of the picture, a field
        is not a valid number, or a frame occurs twice. Errors in a row state the line.
    """
    table = read_table(path, what="fixations", required=GAZE_COLUMNS)
    frame = table.whole_numbers("frame", low=-int(MAX_INTEGER))
    columns = [table.numbers(name, low=-LARGEST, high=LARGEST) for name in ("x", "y")]
    point = np.stack(columns, axis=1)
    if len(point) and ((point >= 0) & (point <= 1)).all():
        raise FormatError(
            "x, y: all points lie in 0 to 1, as shares of the picture do; expected pixels (x times "
            "its width, y times its height)",
            file=table.name,
        )
    order = np.argsort(frame, kind="stable")
    again = np.flatnonzero(np.diff(frame[order]) == 0)
    if len(again):
        row = int(order[again[0] + 1])
        raise table.fault(row, f"the frame {frame[row]} has a row already; expected one a frame")
    return Gaze(frame[order], point[order])


@dataclass(frozen=True)
class FixedPoint:
    """Assumed constant fixation point of the driver.

    Attributes
    ----------
    x, y
        Share of the picture's width and height. (0.5, 0.5) is the middle.
    """

    x: float = 0.5
    y: float = 0.5

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            value = getattr(self, name)
            if not (math.isfinite(value) and 0 <= value <= 1):
                raise ParameterError(
                    f"fixation: expected {name} as a share of the picture, 0 to 1, found {value:g}"
                )

    def in_picture(self, width: int, height: int) -> tuple[float, float]:
        """Return the point in pixels of a picture of this size."""
        return self.x * width, self.y * height
