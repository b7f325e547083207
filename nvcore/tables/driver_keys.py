"""What ``summary.json`` says of the driver, where detectability is known."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.driver.comparison.judging import count_unknown
from nvcore.driver.comparison.kinds import DRIVER_REGION_TEXT, DriverRegion
from nvcore.driver.comparison.steps import driver_in
from nvcore.measures.of_driver import is_driver_in_time, is_judged_in_time, is_seen_too_late
from nvcore.tables.column import Column, Kind
from nvcore.tables.summary_entry import Entry

_NOBODY_URGENT: Final = "it is known of no urgent encounter whether the driver sees it"


def _count_region(result: Result, *, region: DriverRegion) -> int:
    return driver_in(result).venn.counts[region]


def _count_within_sd(result: Result) -> int | None:
    driver = driver_in(result)
    return int(np.count_nonzero(driver.is_within_sd)) if driver.has_sd.any() else None


def _count_urgent(result: Result, is_member: np.ndarray) -> int | None:
    """How many, so that no rule passes because nobody is urgent."""
    return int(np.count_nonzero(is_member)) if is_judged_in_time(result).any() else None


def _entry(
    key: str,
    meaning: str,
    of: Callable[[Result], int | None],
    *,
    unit: str = "encounters",
    empty: str = "",
) -> Entry:
    column = Column(key, Kind.INTEGER, unit, meaning, empty=empty, is_optional=True)
    return Entry(column, of)


DRIVER_ENTRIES: Final[tuple[Entry, ...]] = (
    _entry(
        "driver.seen",
        "Encounters that the driver sees unaided.",
        lambda result: driver_in(result).venn.n_seen,
    ),
    _entry(
        "driver.unseen",
        "Encounters that the driver is known not to see.",
        lambda result: driver_in(result).venn.n_unseen,
    ),
    _entry(
        "driver.outside_training",
        "Of both, those decided by an estimate outside the range of the training: by the largest "
        "up to the first frame that counts, and where that is below `driver_threshold` by any.",
        lambda result: driver_in(result).n_outside,
    ),
    _entry(
        "driver.adapted",
        "Of both, those decided by an estimate for adapted eyes, since no change from bright to "
        "dark is known before.",
        lambda result: int(np.count_nonzero(driver_in(result).is_adapted)),
    ),
    _entry(
        "driver.within_sd",
        "Of both, those whose largest one is no further than its standard deviation from "
        "`driver_threshold`: whether the driver sees them is open.",
        _count_within_sd,
        empty="no encounter has a standard deviation",
    ),
    _entry(
        "driver.seldom",
        "Of those seen, the ones that the driver sees in fewer than half of the frames up to the "
        "first that counts in which it is known.",
        lambda result: int(np.count_nonzero(driver_in(result).is_seldom_seen)),
    ),
    _entry(
        "driver.urgent",
        "Urgent encounters of which it is known whether the driver sees them.",
        lambda result: int(np.count_nonzero(is_judged_in_time(result))),
    ),
    _entry(
        "driver.in_time",
        "Of these, the ones that the driver sees while the car can still stop.",
        lambda result: _count_urgent(result, is_driver_in_time(result)),
        empty=_NOBODY_URGENT,
    ),
    _entry(
        "driver.too_late",
        "Of these, the ones that the driver sees, but only when the car can no longer stop.",
        lambda result: _count_urgent(result, is_seen_too_late(result)),
        empty=_NOBODY_URGENT,
    ),
    _entry(
        "driver.boxes_without_detectability",
        "{One} boxes of unknown detectability; with `driver_weighting` they weigh in full.",
        lambda result: count_unknown(result.dataset),
        unit="boxes",
    ),
    *(
        _entry(
            f"driver_venn.{region.value}",
            DRIVER_REGION_TEXT[region],
            partial(_count_region, region=region),
        )
        for region in DriverRegion
        if region is not DriverRegion.DISTANT
    ),
)
"""Keys and values, all optional."""
