"""Driver page: all encounters, and all urgent ones, in parts that add up."""

from __future__ import annotations

import numpy as np

from nvcore.comparison import Result
from nvcore.measures.of_driver import is_driver_in_time, is_in_time_alone, is_judged_in_time
from nvcore.measures.values import is_in_time
from nvcore.schema import DriverRegion
from nvcore.wording import count_text


def describe_counts(result: Result) -> str:
    """Where each encounter is counted, those too that no sentence is about."""
    return " ".join(filter(None, (_all(result), _urgent(result))))


def _all(result: Result) -> str:
    venn = result.driver.venn
    n_unknown, n_distant = (
        venn.counts[region] for region in (DriverRegion.UNKNOWN, DriverRegion.DISTANT)
    )
    n = venn.n_known + n_unknown + n_distant
    parts = [f"{venn.n_seen:,} seen by the driver, {venn.n_unseen:,} not seen"]
    if n_unknown:
        parts.append(f"{n_unknown:,} unknown")
    if n_distant:
        parts.append(f"{n_distant:,} distant (never near enough to count)")
    return f"{count_text(n, 'encounter')} in all: {', '.join(parts)}."


def _urgent(result: Result) -> str:
    """Who is in time for the urgent ones; empty: it is known of none."""
    is_judged, by_driver = is_judged_in_time(result), is_driver_in_time(result)
    n = int(np.count_nonzero(is_judged))
    if not n:
        return ""
    by_x, by_y = (is_in_time(system) for _, system in result.sides)
    alone_x, alone_y = (is_in_time_alone(result, system) for _, system in result.sides)
    both = is_judged & ~by_driver & by_x & by_y
    nobody = is_judged & ~by_driver & ~by_x & ~by_y
    in_driver, in_both, in_x, in_y, in_none = (
        f"{int(np.count_nonzero(part)):,}" for part in (by_driver, both, alone_x, alone_y, nobody)
    )
    return (
        f"{count_text(n, 'urgent one')} of which it is known: in time is the driver by himself in "
        f"{in_driver}; of the others, both systems are in {in_both}, X alone in {in_x}, Y alone "
        f"in {in_y}, nobody in {in_none}."
    )
