"""Both systems at equal false alarms and strictly paired, for the verdict."""

from __future__ import annotations

from typing import Final

import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.evidence.companions import Companions, find_companions
from nvcore.evidence.units import find_units
from ui.jobs.computed import Computation
from ui.jobs.page_run import PageRun
from ui.session import state
from ui.session.results import cached_miss_rate, comparison_key

RUN: Final = PageRun[Companions]("companions", "comparison at equal false alarms", "Comparing")
QUICK_BOXES: Final = 50_000
"""Number of boxes up to which they are computed at once, in a fraction of a second."""


def is_quick(result: Result) -> bool:
    """Return whether the companions are computed at once."""
    return len(result.dataset.boxes) <= QUICK_BOXES


def wait_for_companions(result: Result, evidence: pd.DataFrame) -> Companions | None:
    """Return the companions of the comparison, or None while they are computed."""
    protocol = state.protocol()  # has to be read outside the background thread
    miss_rate = cached_miss_rate(state.cached, result, find_units(result), protocol)
    computation = Computation(
        RUN,
        comparison_key(result),
        lambda _: find_companions(result, evidence, protocol, miss_rate=miss_rate),
    )
    output, is_missing = computation.draw(is_quick=is_quick(result))
    job = RUN.job
    if is_missing and (job is None or job.key != computation.key):  # not one that was cancelled
        computation.start()
        computation.draw(is_quick=False)
    return output
