"""Tables of a study: pedestrians in its pictures, and columns of its trials.

image,pedestrian,x,y,w,h
park.jpg,1,612,388,31,74

subject,run,position,order,image,pedestrian,adaptation_asked_s,adaptation_measured_s,...
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import pandas as pd

from nvcore.common.wording import shortened
from nvcore.inputs.readers.parse.table import TextTable, read_table

PEDESTRIAN: Final = ("image", "pedestrian")
"""Columns that identify a pedestrian in all tables."""
BOX: Final = ("x", "y", "w", "h")
LONGEST_NAME: Final = 1000
"""Maximum length of the name of a picture or a pedestrian."""
LARGEST: Final = 1e6
"""Maximum of pixels and features. Larger values are mistakes, and too much for a regression."""


def read_picture_boxes(path: Path) -> TextTable:
    """Read a table in which each pedestrian of a picture occurs once, for `picture_boxes`.

    Raises
    ------
    InputError
        If the file cannot be opened or is not such a table, a name is too long, or a pedestrian
        occurs twice. Errors in a row state the line.
    """
    table = read_table(path, what="boxes", required=(*PEDESTRIAN, *BOX))
    check_pedestrians(table)
    return table


def check_pedestrians(table: TextTable) -> None:
    """Reject tables with duplicate pedestrians or invalid names.

    Raises
    ------
    FormatError
        With the line of the error.
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
    """Return the boxes of the pedestrians in a table.

    Returns
    -------
    image, pedestrian (text), and x, y, w, h (pixels of the picture, float64), one row per row.

    Raises
    ------
    FormatError
        If a field is empty, not a number or too large, or a box has no size, with the line.
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
"""Maximum deviation of a picture's time or duration from the plan, s. Others are marked."""
LONGEST_S: Final = 3600.0
"""Maximum of the times of a trial."""
NO_ANSWER: Final = "no answer"
"""Text after "marked:" in `device` for a trial without an answer in time. It has `not_seen`."""
LEAST_PEDESTRIANS: Final = 8
"""Minimum number of pedestrians at each period. With fewer, models cannot be selected."""
_ROUNDING_S: Final = 1e-9


def is_off_time(by_s: Any) -> Any:
    """Check whether a picture came, or went, more than `LATE_S` too early or too late.

    Parameters
    ----------
    by_s
        Measured minus planned seconds: a number, or an array or column. NaN, for nothing measured,
        is not off time.

    Examples
    --------
    >>> is_off_time(-0.06), is_off_time(1.05 - 1.0)
    (True, False)
    """
    return abs(by_s) > LATE_S + _ROUNDING_S


def is_same_time(apart_s: Any) -> Any:
    """Check whether two planned times are so close that a picture may be on time for both.

    Parameters
    ----------
    apart_s
        Seconds between the two, 0 or more: a number, or an array.

    Examples
    --------
    >>> is_same_time(0.04), is_same_time(1.05 - 1.0)
    (True, False)
    """
    return apart_s < LATE_S - _ROUNDING_S
