"""Rules that a comparison has to pass, such as in nightly runs: values, outcomes, explanations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nvcore.common.errors import ParameterError
from nvcore.common.findings import Finding
from nvcore.comparison.compare import Result
from nvcore.report.gate.details import explain
from nvcore.report.gate.measures import gate_measures, measure_names
from nvcore.report.gate.outcomes import RuleOutcome, judge
from nvcore.report.gate.rules import Rule, parse_rule, read_rules


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


def parse_rules(texts: str | Iterable[str]) -> list[Rule]:
    """Return one or several rules from their texts.

    Raises
    ------
    ParameterError
        If one cannot be parsed, or names an unknown measure. It describes all errors.
    """
    texts = [texts] if isinstance(texts, str) else list(texts)
    numbered = [(f"rule {number}", text) for number, text in enumerate(texts, 1)]
    rules, problems = read_rules(numbered, measure_names())
    if problems:
        raise ParameterError("\n".join(problems))
    return rules


def audit_rules(rules: Iterable[Rule], *, strict: bool) -> list[Rule]:
    """Return rules that allow no errors of the audit and, if `strict`, no warnings.

    A rule is left out if `rules` already limit that number.
    """
    measures = {rule.name for rule in rules}
    counts = ["audit_errors", *(["audit_warnings"] if strict else [])]
    return [parse_rule(f"{name} == 0") for name in counts if name not in measures]
