"""Driver page: all encounters, in parts that add up."""

from __future__ import annotations

from nvcore.comparison import Result
from nvcore.schema import DriverRegion
from nvcore.wording import count_text


def describe_counts(result: Result) -> str:
    """Where each encounter is counted, those too that no sentence is about."""
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
