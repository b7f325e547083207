"""Rules that a comparison has to pass, such as in nightly runs: measured, judged, explained."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nvcore.comparison import Result
from nvcore.findings import Finding
from nvcore.report.gate.details import explain
from nvcore.report.gate.measures import gate_measures
from nvcore.report.gate.outcomes import RuleOutcome, judge
from nvcore.report.gate.rules import Rule, parse_rule


def run_gate(
    rules: Sequence[Rule],
    result: Result,
    findings: Sequence[Finding],
    *,
    strict: bool,
    names: Iterable[str] = (),
) -> tuple[list[RuleOutcome], dict[str, float]]:
    """The outcomes of these rules and of those of the audit, and the measures they were judged by.

    Parameters
    ----------
    strict
        Whether warnings of the audit count as errors do.
    names
        Measures to compute beside those that the rules name.
    """
    every = [*rules, *audit_rules(rules, strict=strict)]
    needed = [*names, *(rule.name for rule in every)]
    measures = gate_measures(result, findings, result.dataset.settings.protocol, needed)
    return explain(judge(every, measures), result, findings), measures


def audit_rules(rules: Iterable[Rule], *, strict: bool) -> list[Rule]:
    """Rules that allow no errors of the audit and, if `strict`, no warnings.

    Left out where `rules` themselves limit the number.
    """
    measures = {rule.name for rule in rules}
    counts = ["audit_errors", *(["audit_warnings"] if strict else [])]
    return [parse_rule(f"{name} == 0") for name in counts if name not in measures]
