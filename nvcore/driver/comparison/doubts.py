"""Why nothing is claimed of whom the driver sees, or of what is weighted by it."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.driver.comparison.settings import DRIVER
from nvcore.driver.comparison.steps import driver_in
from nvcore.measures.entry import Measure
from nvcore.wording import count_text

MOST_OUTSIDE: Final = 0.5
"""From this share of encounters on that are decided outside the range of the training, nothing is
claimed (ours)."""


def is_stated(result: Result) -> bool:
    """Whether all that is known of the driver is the ground truth's, whatever record there is."""
    n_estimated, n_stated = count_origins(result)
    return bool(n_stated and not n_estimated)


def count_origins(result: Result) -> tuple[int, int]:
    """In how many recordings detectability is estimated, and in how many the ground truth's own."""
    estimate = result.dataset.of("driver")
    if estimate is None:
        return 0, 0
    names = frozenset(result.dataset.recordings["name"])
    return len(names & estimate.estimated_in), len(names & estimate.stated_in)


def is_weighted(result: Result) -> bool:
    """Whether misses weigh by what the driver does not see."""
    return result.params.driver_weighting != "off" and result.dataset.has_detectability


def are_all_open(result: Result) -> bool:
    """Whether no encounter is further than its standard deviation from the threshold."""
    driver = driver_in(result)
    n_known = driver.venn.n_known
    return n_known > 0 and int(np.count_nonzero(driver.is_within_sd)) == n_known


def doubt_of_estimator(result: Result) -> str:
    """Why no estimate is to be believed; empty: no reason is known, or none was made."""
    estimate = result.dataset.of("driver")
    if estimate is None or is_stated(result):
        return ""
    if estimate.of_no_use:
        return result.objects.say(
            "as a whole the estimator is no better than a constant on {many} that it had not seen"
        )
    if estimate.simulated == "all":
        return "the estimator learnt from simulated subjects alone, not from people"
    return ""


def doubt_of_seen(result: Result) -> str:
    """Why nothing is claimed of whom the driver sees, whatever the counts; empty: no reason."""
    if why := doubt_of_estimator(result):
        return why
    if why := _doubt_of_range(result):
        return why
    is_unseen = driver_in(result).is_unseen
    if are_all_open(result):
        n, which = driver_in(result).venn.n_known, "of which it is known"
    elif is_unseen.any() and bool(driver_in(result).is_within_sd[is_unseen].all()):
        n, which = int(np.count_nonzero(is_unseen)), "counted as not seen by the driver"
    else:
        return ""
    where = f"in all {count_text(n, 'encounter')}" if n > 1 else "in the only encounter"
    return (
        f"{where} {which}, the value that decides is within one standard deviation of "
        f"{result.params.driver_threshold:g}"
    )


def _doubt_of_range(result: Result) -> str:
    """That too many encounters are decided outside of what was trained; empty: they are not."""
    n, n_outside = driver_in(result).venn.n_known, driver_in(result).n_outside
    if not n_outside or n_outside < MOST_OUTSIDE * n:
        return ""
    return (
        f"in {n_outside:,} of {count_text(n, 'encounter')} of which it is known, the value that "
        "decides is outside the range of the training"
    )


def doubt_of(result: Result, measure: Measure) -> str:
    """Why no claim can rest on a measure, nor a value be the better one; empty: no reason."""
    if DRIVER in measure.stages:
        return doubt_of_seen(result)
    if measure.depends_on("driver_weighting") and is_weighted(result):
        return doubt_of_estimator(result)
    return ""
