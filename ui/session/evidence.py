"""Whether the differences are more than chance, cached while nothing that it depends on changes."""

from __future__ import annotations

import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.measures import Evidence
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import Units, find_units
from nvcore.params.metadata import MATCH
from ui.session import state


def comparison_key(result: Result) -> tuple[object, ...]:
    """What the evidence of a comparison depends on, while the same data are open."""
    return (result.params, result.x.name, result.y.name, state.protocol())


def measure_evidence(result: Result) -> pd.DataFrame:
    """The measures of X and Y with their evidence."""
    protocol = state.protocol()

    def make() -> pd.DataFrame:
        units = find_units(result)
        return evidence_table(
            result, protocol, units=units, miss_rate=_cached_miss_rate(result, units)
        )

    return state.cached("evidence", comparison_key(result), make)


def miss_rate_evidence(result: Result) -> Evidence:
    """Difference of the log-average miss rate under the protocol in use."""
    return _cached_miss_rate(result, find_units(result))


def _cached_miss_rate(result: Result, units: Units) -> Evidence:
    """Depends on the settings of matching alone, and on the blocks of time."""
    protocol = state.protocol()
    key = (
        result.x.name,
        result.y.name,
        result.params.only_for(MATCH),
        protocol,
        units.unit_of_frame.tobytes(),
    )
    return state.cached(
        "miss_rate_evidence", key, lambda: judge_miss_rate(result, units, protocol), most=4
    )
