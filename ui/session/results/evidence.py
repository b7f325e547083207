"""The cached evidence for the differences between X and Y."""

from __future__ import annotations

import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.measures import Evidence, Judged
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import Units, find_units
from nvcore.protocols import Protocol
from nvcore.stages import MATCH
from ui.session import state
from ui.session.results.comparison import Cached


def comparison_key(result: Result, protocol: Protocol | None = None) -> tuple[object, ...]:
    """Cache key of the evidence, for the open data."""
    names = result.x.name, result.y.name
    is_as_set = result.as_set is None
    protocol = protocol or state.protocol()
    return (result.params, is_as_set, *names, protocol, result.dataset.primary)


def measure_evidence(result: Result) -> pd.DataFrame:
    """The table of evidence of X and Y."""
    return evidence_kept_by(state.cached, result, state.protocol())


def known_evidence(result: Result) -> pd.DataFrame | None:
    """The table of evidence if it is cached; else None."""
    known: pd.DataFrame | None = state.known("evidence", comparison_key(result))
    return known


def evidence_kept_by(cached: Cached, result: Result, protocol: Protocol) -> pd.DataFrame:
    """The table of evidence from a cache: `state.cached`, or the one that visitors share."""

    def make() -> pd.DataFrame:
        units = find_units(result)
        miss_rate = miss_rate_kept_by(cached, result, units, protocol)
        return evidence_table(result, protocol, units=units, miss_rate=miss_rate)

    evidence: pd.DataFrame = cached("evidence", comparison_key(result, protocol), make)
    return evidence


def miss_rate_evidence(result: Result) -> Evidence:
    """Evidence for the log-average miss rate under the current protocol."""
    return miss_rate_kept_by(state.cached, result, find_units(result), state.protocol()).evidence


def miss_rate_kept_by(cached: Cached, result: Result, units: Units, protocol: Protocol) -> Judged:
    """Keyed by the settings of matching and the blocks of time, which alone move it."""
    key = (
        result.x.name,
        result.y.name,
        result.params.only_for(MATCH),
        protocol,
        units.unit_of_frame.tobytes(),
    )
    judged: Judged = cached(
        "miss_rate_evidence", key, lambda: judge_miss_rate(result, units, protocol), most=4
    )
    return judged
