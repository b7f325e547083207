"""Tables of a study: the pedestrians in its pictures, and columns of its trials.

image,pedestrian,x,y,w,h
park.jpg,1,612,388,31,74

subject,run,position,order,image,pedestrian,adaptation_asked_s,adaptation_measured_s,...
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import pandas as pd

from nvcore.inputs.readers.parse.table import TextTable, read_table
from nvcore.wording import shortened

PEDESTRIAN: Final = ("image", "pedestrian")
"""What tells pedestrians apart, in all tables."""
BOX: Final = ("x", "y", "w", "h")
LONGEST_NAME: Final = 1000
"""Characters of the name of a picture or of a pedestrian."""
LARGEST: Final = 1e6
"""Of pixels and features: what is larger is a mistake, and too much for a regression."""


def read_picture_boxes(path: Path) -> TextTable:
    """The table of a file, each pedestrian of a picture once; `picture_boxes` gives the boxes.

    Raises
    ------
    InputError
        If the file cannot be opened or is no such table, a name is too long, or a pedestrian stands
        there twice; with the line.
    """
    table = read_table(path, what="boxes", required=(*PEDESTRIAN, *BOX))
    check_pedestrians(table)
    return table


def check_pedestrians(table: TextTable) -> None:
    """Refuse a pedestrian of a picture that stands there twice, or a name that is none.

    Raises
    ------
    FormatError
        With the line.
    """
    for name in PEDESTRIAN:
        for row, text in enumerate(table.fields[name]):
            if len(text) > LONGEST_NAME:
                raise table.fault(
                    row,
                    f"{name}: expected {LONGEST_NAME:,} characters at the most, found "
                    f"{len(text):,}: {shortened(text, 40)!r}",
                )
    table.unique(PEDESTRIAN, "the picture {image} has the pedestrian {pedestrian} a second time")


def picture_boxes(table: TextTable) -> pd.DataFrame:
    """The pedestrians of a table.

    Returns
    -------
    image, pedestrian (text), and x, y, w, h (pixels of the picture, float64), row by row.

    Raises
    ------
    FormatError
        If a field is empty, no number or too large, or a box has no size; with the line.
    """
    columns: dict[str, object] = {name: table.texts(name) for name in PEDESTRIAN}
    for name in BOX:
        is_size = name in ("w", "h")
        values = table.numbers(name, low=0 if is_size else -LARGEST, high=LARGEST)
        if is_size and (values == 0).any():
            row = int((values == 0).argmax())
            raise table.fault(row, f"{name}: expected more than 0, found {table.fields[name][row]}")
        columns[name] = values
    return pd.DataFrame(columns)


TRIAL_COLUMNS: Final = (
    *("subject", "run", "position", "order", "image", "pedestrian"),
    *("adaptation_asked_s", "adaptation_measured_s", "touch_x", "touch_y"),
    *("response_s", "not_seen", "device"),
)
"""Columns of a file of trials (docs/driver-reference.md), in the order of writing."""
LATE_S: Final = 0.05
"""A trial is marked if its picture came earlier or later than asked by more than this, or was to be
seen for so much more or less."""
LONGEST_S: Final = 3600.0
"""Longest of the times of a trial."""
NO_ANSWER: Final = "no answer"
"""What `device` says after "marked:" of a trial without an answer in time; it has `not_seen`."""
LEAST_PEDESTRIANS: Final = 8
"""Minimum number of pedestrians at each period: with fewer, models cannot be selected."""
_ROUNDING_S: Final = 1e-9


def is_off_time(by_s: Any) -> Any:
    """Check whether a picture came, or went, more than `LATE_S` too early or too late.

    Parameters
    ----------
    by_s
        Seconds from what was asked to what was measured: a number, or an array or column of them;
        NaN, where nothing was measured, is not off time.

    Examples
    --------
    >>> is_off_time(-0.06), is_off_time(1.05 - 1.0)
    (True, False)
    """
    return abs(by_s) > LATE_S + _ROUNDING_S


def is_same_time(apart_s: Any) -> Any:
    """Check whether two planned times are so near that a picture may be on time for both.

    Parameters
    ----------
    apart_s
        Seconds from one to the next, 0 or more: a number, or an array of them.

    Examples
    --------
    >>> is_same_time(0.04), is_same_time(1.05 - 1.0)
    (True, False)
    """
    return apart_s < LATE_S - _ROUNDING_S
