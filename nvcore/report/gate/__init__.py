"""Rules that a comparison has to pass, such as in nightly runs: values, outcomes, explanations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nvcore.common.findings import Finding
from nvcore.comparison.compare import Result
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
    """Return the outcomes of rules, including the audit's, and the measures they were judged by.

    Parameters
    ----------
    strict
        True if warnings of the audit count as errors.
    names
        Measures to compute in addition to those that the rules name.
    """
    every = [*rules, *audit_rules(rules, strict=strict)]
    needed = [*names, *(rule.name for rule in every)]
    measures = gate_measures(result, findings, result.dataset.settings.protocol, needed)
    return explain(judge(every, measures), result, findings), measures


def audit_rules(rules: Iterable[Rule], *, strict: bool) -> list[Rule]:
    """Return rules that allow no errors of the audit and, if `strict`, no warnings.

    A rule is left out if `rules` already limit that number.
    """
    measures = {rule.name for rule in rules}
    counts = ["audit_errors", *(["audit_warnings"] if strict else [])]
    return [parse_rule(f"{name} == 0") for name in counts if name not in measures]
