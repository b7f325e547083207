"""Cached results for the open inputs: evidence for the differences of X and Y, and the audit."""

from __future__ import annotations

import pandas as pd
import streamlit as st

from nvcore.auditing import audit_in_parts
from nvcore.auditing.pictures import audit_pictures
from nvcore.common.findings import Finding, worst_first
from nvcore.comparison.compare import Result
from nvcore.dataset import Dataset
from nvcore.evidence.measures import Evidence, Judged
from nvcore.evidence.miss_rate import judge_miss_rate
from nvcore.evidence.operating_points import are_delivered
from nvcore.evidence.table import evidence_table
from nvcore.evidence.units import Units, find_units
from nvcore.settings.params import Params
from nvcore.settings.protocols import Protocol
from nvcore.settings.stages import MATCH
from ui.session import state
from ui.session.state import Cached


def comparison_key(result: Result, protocol: Protocol | None = None) -> tuple[object, ...]:
    """Return the cache key of the evidence for the open data."""
    names = result.names
    is_as_set = result.as_set is None
    protocol = protocol or state.protocol()
    question = result.dataset.primary, are_delivered(result)
    return (result.params, is_as_set, *names, protocol, *question)


def measure_evidence(result: Result) -> pd.DataFrame:
    """Return the table of evidence of X and Y."""
    return cached_evidence(state.cached, result, state.protocol())


def known_evidence(result: Result) -> pd.DataFrame | None:
    """Return the table of evidence if it is cached, or else None."""
    known: pd.DataFrame | None = state.known("evidence", comparison_key(result))
    return known


def cached_evidence(cached: Cached, result: Result, protocol: Protocol) -> pd.DataFrame:
    """Return the table of evidence from a cache: `state.cached`, or the one that visitors share."""

    def make() -> pd.DataFrame:
        units = find_units(result)
        miss_rate = cached_miss_rate(cached, result, units, protocol)
        return evidence_table(result, protocol, units=units, miss_rate=miss_rate)

    evidence: pd.DataFrame = cached("evidence", comparison_key(result, protocol), make)
    return evidence


def miss_rate_evidence(result: Result) -> Evidence:
    """Return the evidence for the log-average miss rate under the current protocol."""
    return cached_miss_rate(state.cached, result, find_units(result), state.protocol()).evidence


def cached_miss_rate(cached: Cached, result: Result, units: Units, protocol: Protocol) -> Judged:
    """Return the judged miss rate, cached by matching settings and blocks of time only."""
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


def input_findings() -> tuple[Finding, ...]:
    """Return the findings about the open inputs and their pictures, worst first."""
    dataset, space = state.opened().dataset, state.workspace()
    with st.spinner("Auditing the inputs"):
        findings = cached_findings(state.cached, dataset, state.params(), *state.systems())
    of_pictures = space.cached(
        "audit_pictures", space.pictures_version, lambda: audit_pictures(dataset, space.pictures)
    )
    return worst_first([*findings, *of_pictures])


def cached_findings(
    cached: Cached, dataset: Dataset, params: Params, x: str, y: str | None
) -> tuple[Finding, ...]:
    """Return the findings from a cache: `state.cached`, or the one that visitors share."""
    relevant = params.only_for_audit()
    findings: tuple[Finding, ...] = cached(
        "findings", (relevant, x, y), lambda: audit_in_parts(dataset, relevant, x, y, cached)
    )
    return findings
