"""Why nothing is claimed of whom the driver sees, or of what is weighted by it."""

from __future__ import annotations

from typing import Final

import numpy as np

from nvcore.comparison import Result
from nvcore.driver.comparison.facts import Why
from nvcore.driver.comparison.settings import DRIVER
from nvcore.driver.comparison.steps import driver_in
from nvcore.measures.entry import Measure
from nvcore.sentences import phrase

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


def doubt_of_estimator(result: Result) -> Why | None:
    """Why no estimate is to be believed; None: no reason is known, or none was made."""
    estimate = result.dataset.of("driver")
    if estimate is None or is_stated(result):
        return None
    if estimate.of_no_use:
        return Why("useless")
    return Why("simulated") if estimate.simulated == "all" else None


def doubt_of_seen(result: Result) -> Why | None:
    """Why nothing is claimed of whom the driver sees, whatever the counts; None: no reason."""
    if why := doubt_of_estimator(result):
        return why
    driver, threshold = driver_in(result), result.params.driver_threshold
    n_known, is_unseen = driver.venn.n_known, driver.is_unseen
    if driver.n_outside and driver.n_outside >= MOST_OUTSIDE * n_known:
        return Why("range", driver.n_outside, n_known)
    if are_all_open(result):
        return Why("open", n_known, threshold=threshold)
    if is_unseen.any() and bool(driver.is_within_sd[is_unseen].all()):
        return Why("unseen", int(np.count_nonzero(is_unseen)), threshold=threshold)
    return None


def doubt_of(result: Result, measure: Measure) -> str:
    """Why no claim can rest on a measure, nor a value be the better one; empty: no reason."""
    why = None
    if DRIVER in measure.stages:
        why = doubt_of_seen(result)
    elif measure.depends_on("driver_weighting") and is_weighted(result):
        why = doubt_of_estimator(result)
    return phrase(why, result.objects) if why else ""
