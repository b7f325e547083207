"""Columns of a file of trials, and the limit for late pictures, for writers and readers of trials.

subject,run,position,order,image,pedestrian,adaptation_asked_s,adaptation_measured_s,...
"""

from __future__ import annotations

from typing import Any, Final

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
