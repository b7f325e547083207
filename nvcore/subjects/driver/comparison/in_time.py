"""Classify urgent encounters by who confirms them in time: the driver, X or Y.

Masks are bool, shape (n_encounters,).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from nvcore.comparison.compare import Result
from nvcore.comparison.scoring import SystemResult
from nvcore.subjects.driver.comparison.steps import driver_in
from nvcore.subjects.time_left.steps import is_in_time, time_left_in


def is_judged_in_time(result: Result) -> np.ndarray:
    """Return which urgent encounters have known detectability."""
    is_judged: np.ndarray = time_left_in(result).is_urgent & driver_in(result).is_known
    return is_judged


def is_driver_in_time(result: Result) -> np.ndarray:
    """Return which urgent encounters the driver sees unaided while the car can still stop.

    The driver confirms in the first frame in which detectability reaches `driver_threshold`, even
    if that is after the first relevant one (docs/decisions/055-driver-in-time.md). The mask is also
    False if detectability is unknown (`is_judged_in_time`).
    """
    row = driver_in(result).table["confirmed_row"].to_numpy()
    is_before = (row >= 0) & (row < time_left_in(result).urgency["urgent_row"].to_numpy())
    in_time: np.ndarray = is_before & is_judged_in_time(result)
    return in_time


def is_seen_too_late(result: Result) -> np.ndarray:
    """Return which urgent encounters the driver sees only when the car can no longer stop."""
    is_seen = time_left_in(result).is_urgent & driver_in(result).is_seen
    too_late: np.ndarray = is_seen & ~is_driver_in_time(result)
    return too_late


def is_in_time_alone(result: Result, system: SystemResult) -> np.ndarray:
    """Return which urgent encounters only this system confirms in time, and not the driver.

    False if the detectability is unknown.
    """
    (other,) = (side for _, side in result.sides if side is not system)
    by_others = is_driver_in_time(result) | is_in_time(other)
    is_alone: np.ndarray = is_judged_in_time(result) & is_in_time(system) & ~by_others
    return is_alone


class InTimeVenn(NamedTuple):
    """Counts of urgent encounters with known detectability, by who confirms them in time.

    Attributes
    ----------
    driver
        Confirmed by the driver unaided, regardless of the systems.
    both, x, y, nobody
        Not confirmed by the driver, but by both systems, by one alone, or by neither.
    """

    driver: int
    both: int
    x: int
    y: int
    nobody: int

    @property
    def n(self) -> int:
        """Number of urgent encounters with known detectability."""
        return sum(self)


def count_in_time(result: Result) -> InTimeVenn:
    """Count urgent encounters with known detectability by who confirms them in time."""
    is_left = is_judged_in_time(result) & ~is_driver_in_time(result)
    by_x, by_y = (is_in_time(system) for _, system in result.sides)
    alone_x, alone_y = (is_in_time_alone(result, system) for _, system in result.sides)
    both, nobody = is_left & by_x & by_y, is_left & ~by_x & ~by_y
    parts = is_driver_in_time(result), both, alone_x, alone_y, nobody
    return InTimeVenn(*(int(np.count_nonzero(part)) for part in parts))
