"""Whether the differences are more than chance, cached while nothing that it depends on changes."""

from __future__ import annotations

import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.measures import Evidence
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import Units, find_units
from nvcore.protocols import Protocol
from nvcore.stages import MATCH
from ui.session import state
from ui.session.results.comparison import Cached


def comparison_key(result: Result, protocol: Protocol | None = None) -> tuple[object, ...]:
    """What the evidence of a comparison depends on, while the same data are open."""
    return (result.params, result.x.name, result.y.name, protocol or state.protocol())


def measure_evidence(result: Result) -> pd.DataFrame:
    """The measures of X and Y with their evidence."""
    return evidence_kept_by(state.cached, result, state.protocol())


def known_evidence(result: Result) -> pd.DataFrame | None:
    """The same, if it is known already."""
    known: pd.DataFrame | None = state.known("evidence", comparison_key(result))
    return known


def evidence_kept_by(cached: Cached, result: Result, protocol: Protocol) -> pd.DataFrame:
    """The same, kept as `cached` keeps values: `state.cached`, or of what all visitors share."""

    def make() -> pd.DataFrame:
        units = find_units(result)
        miss_rate = _miss_rate_kept_by(cached, result, units, protocol)
        return evidence_table(result, protocol, units=units, miss_rate=miss_rate)

    evidence: pd.DataFrame = cached("evidence", comparison_key(result, protocol), make)
    return evidence


def miss_rate_evidence(result: Result) -> Evidence:
    """Difference of the log-average miss rate under the protocol in use."""
    return _miss_rate_kept_by(state.cached, result, find_units(result), state.protocol())


def _miss_rate_kept_by(
    cached: Cached, result: Result, units: Units, protocol: Protocol
) -> Evidence:
    """Depends on the settings of matching alone, and on the blocks of time."""
    key = (
        result.x.name,
        result.y.name,
        result.params.only_for(MATCH),
        protocol,
        units.unit_of_frame.tobytes(),
    )
    evidence: Evidence = cached(
        "miss_rate_evidence", key, lambda: judge_miss_rate(result, units, protocol), most=4
    )
    return evidence
