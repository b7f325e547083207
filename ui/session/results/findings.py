"""Cached findings of the audit, in parts that depend on different settings."""

from __future__ import annotations

from functools import partial

import streamlit as st

from nvcore.auditing import (
    audit_inputs,
    audit_pair,
    audit_system,
    audit_view,
    ranked,
    threshold_of,
)
from nvcore.auditing.pictures import audit_pictures
from nvcore.dataset import Dataset
from nvcore.findings import Finding, worst_first
from nvcore.params import Params
from nvcore.stages import MATCH, PROXIMITY, THRESHOLD
from ui.session import state
from ui.session.results.comparison import Cached


def input_findings() -> tuple[Finding, ...]:
    """Findings about the open inputs and their pictures, worst first."""
    dataset, space = state.opened().dataset, state.workspace()
    with st.spinner("Auditing the inputs"):
        findings = findings_kept_by(state.cached, dataset, state.params(), *state.systems())
    of_pictures = space.cached(
        "audit_pictures",
        space.pictures_version,
        lambda: audit_pictures(dataset, space.pictures),
    )
    return worst_first([*findings, *of_pictures])


def findings_kept_by(
    cached: Cached, dataset: Dataset, params: Params, x: str, y: str | None
) -> tuple[Finding, ...]:
    """The findings from a cache: `state.cached`, or the one that visitors share.

    As `nvcore.auditing.audit`, in parts: another threshold audits no file again.
    """
    relevant, *_ = key = _key(params, x, y)

    def make() -> tuple[Finding, ...]:
        findings = [*cached("audit_inputs", (), lambda: audit_inputs(dataset))]
        for name in dataset.systems:
            threshold = threshold_of(name, (x, y), relevant)
            findings += cached(
                "audit_system",
                (name, threshold),
                partial(audit_system, dataset, name, threshold),
                most=2 * len(dataset.systems),
            )
        of_pair = relevant.only_for(THRESHOLD, MATCH, PROXIMITY)
        findings += cached(
            "audit_pair", (of_pair, x, y), lambda: audit_pair(dataset, of_pair, x=x, y=y)
        )
        findings += audit_view(dataset, relevant)
        return ranked(dataset, findings)

    findings: tuple[Finding, ...] = cached("findings", key, make)
    return findings


def _key(params: Params, x: str, y: str | None) -> tuple[Params, str, str | None]:
    return params.only_for_audit(), x, y
