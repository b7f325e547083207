"""Results of a gate for people and CI: lines for the terminal, JUnit XML, Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Final
from xml.etree import ElementTree

from nvcore.common.findings import Finding
from nvcore.common.wording import markdown_text, one_line
from nvcore.comparison.measures.table import MEASURES
from nvcore.report.gate.added import added_rules
from nvcore.report.gate.measures import COUNTED_CLAIMS, COUNTED_ENCOUNTERS, COUNTED_FINDINGS
from nvcore.report.gate.outcomes import RuleOutcome, value_text
from nvcore.report.gate.rules import Rule
from nvcore.report.terminal import render_findings

JUNIT_HEAD: Final = b"<?xml version='1.0' encoding='utf-8'?>\n<testsuites name=\"nvcore gate\""
MARKDOWN_HEAD: Final = b"## Gate: "


def _stem(name: str) -> str:
    """Return the beginning of a measure's name in rules: ``saliency`` of ``saliency_worse_y``."""
    return re.sub(r"(_worse)?_(x|y|difference)$", "", name).partition(".")[0]


_BLIND_TO_ALARMS: Final = {
    *map(_stem, (*COUNTED_ENCOUNTERS, "exclusivity", "boxes", "lead_time_s")),
    *(_stem(name) for of in added_rules() for name in of.counted),
    *(
        _stem(measure.rule or measure.key)
        for measure in MEASURES
        if not measure.is_worsened_by_alarms
    ),
}
"""Stems of measures that false alarms do not worsen."""
_WORSENED_BY_ALARMS: Final = {
    *map(_stem, (*COUNTED_CLAIMS, "newly_false")),
    *(_stem(measure.rule or measure.key) for measure in MEASURES if measure.is_worsened_by_alarms),
}
"""Stems of measures that false alarms worsen."""


def what_is_not_asked(rules: Iterable[Rule]) -> str:
    """Warn if no rule would stop a system that detects everything everywhere.

    Returns
    -------
    Warning with a rule to add; empty if no rule is about misses, or one is about false alarms.
    """
    stems = {_stem(rule.name) for rule in rules}
    if not stems & _BLIND_TO_ALARMS or stems & _WORSENED_BY_ALARMS:
        return ""
    return (
        "no rule is about false alarms: a system that fires everywhere would pass. Add "
        "one such as 'false_alert_episodes_difference >= 0' (Y has no more than X)"
    )


def terminal_lines(outcomes: Sequence[RuleOutcome]) -> list[str]:
    """Return a line for each rule, followed by its details, and the warning about missing rules."""
    lines = []
    for outcome in outcomes:
        mark = "passed" if outcome.is_passed else "FAILED"
        lines.append(f"{mark}  {outcome.rule.text}  ({outcome.message})")
        lines += [f"        {one_line(detail)}" for detail in _details(outcome)]
    gap = what_is_not_asked(outcome.rule for outcome in outcomes)
    return [*lines, f"note: {gap}"] if gap else lines


def _details(outcome: RuleOutcome) -> tuple[str, ...]:
    """Return the details of an outcome, without findings, which are shown with the audit."""
    return () if outcome.rule.name in COUNTED_FINDINGS else outcome.details


def junit_xml(
    outcomes: Sequence[RuleOutcome], title: str, findings: Sequence[Finding] = ()
) -> bytes:
    """Return the outcomes as JUnit XML, with a test case per rule and the audit as output.

    Parameters
    ----------
    title
        Name of the test suite.
    """
    n_failed = sum(not outcome.is_passed for outcome in outcomes)
    root, suite = _suite(title, tests=len(outcomes), failures=n_failed)
    for outcome in outcomes:
        case = ElementTree.SubElement(
            suite, "testcase", {"classname": "nvcore.gate", "name": outcome.rule.text}
        )
        if outcome.is_passed:
            lines = [outcome.message, *map(one_line, outcome.details)]
            ElementTree.SubElement(case, "system-out").text = "\n".join(lines)
            continue
        message = f"{outcome.message}; wanted {outcome.rule.text}"
        failure = ElementTree.SubElement(case, "failure", {"message": message})
        failure.text = "\n".join([message, *map(one_line, outcome.details)])
    ElementTree.SubElement(suite, "system-out").text = render_findings(findings)
    return _xml(root)


def junit_error(problem: str) -> bytes:
    """Return JUnit XML of a gate that could not be run: a single test case with an error.

    Parameters
    ----------
    problem
        Why not; may have several lines.
    """
    root, suite = _suite("nvcore gate", tests=1, errors=1)
    case = ElementTree.SubElement(
        suite, "testcase", {"classname": "nvcore.gate", "name": "the gate can be run"}
    )
    lines = [one_line(line) for line in problem.splitlines()]
    error = ElementTree.SubElement(case, "error", {"message": " ".join(lines)})
    error.text = "\n".join(lines)
    return _xml(root)


def _suite(
    title: str, *, tests: int, failures: int = 0, errors: int = 0
) -> tuple[ElementTree.Element, ElementTree.Element]:
    counts = {"tests": str(tests), "failures": str(failures), "errors": str(errors)}
    root = ElementTree.Element("testsuites", {"name": "nvcore gate", **counts})
    return root, ElementTree.SubElement(root, "testsuite", {"name": one_line(title), **counts})


def _xml(root: ElementTree.Element) -> bytes:
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def markdown(outcomes: Sequence[RuleOutcome], title: str, findings: Sequence[Finding] = ()) -> str:
    """Return the outcomes as Markdown: failed rules first, their details, and the audit."""
    rows = sorted(outcomes, key=lambda outcome: outcome.is_passed)
    n_failed = sum(not outcome.is_passed for outcome in outcomes)
    verdict = f"{n_failed} of {len(outcomes)} rules failed" if n_failed else "all rules passed"
    lines = [
        f"## Gate: {verdict}",
        "",
        markdown_text(title),
        "",
        "| rule | found | |",
        "|---|---|---|",
    ]
    lines += [
        f"| `{outcome.rule.text}` | {value_text(outcome.value)} | "
        f"{'passed' if outcome.is_passed else '**failed**'} |"
        for outcome in rows
    ]
    for outcome in rows:
        if details := _details(outcome):
            word = "passed" if outcome.is_passed else "failed"
            lines += ["", f"`{outcome.rule.text}` {word}:", ""]
            lines += [f"- {markdown_text(detail)}" for detail in details]
    if gap := what_is_not_asked(outcome.rule for outcome in outcomes):
        lines += ["", f"Note: {markdown_text(gap)}"]
    lines += ["", *_audit(findings)]
    return "\n".join(lines) + "\n"


def _audit(findings: Sequence[Finding]) -> list[str]:
    head = render_findings(findings).splitlines()[0]
    lines = [f"### {head.rstrip('.')}"]
    if findings:
        lines.append("")
    for finding in findings:
        subject, text = finding.subject, f"{finding.message} {finding.advice}"
        lines.append(f"- {finding.severity.value}, {markdown_text(subject)}: {markdown_text(text)}")
    return lines


def markdown_error(problem: str) -> str:
    """Return Markdown of a gate that could not be run.

    Parameters
    ----------
    problem
        Why not; may have several lines.
    """
    lines = [markdown_text(line) for line in problem.splitlines()]
    return "\n\n".join(["## Gate: could not be run", *lines]) + "\n"


def is_gate_result(content: bytes) -> bool:
    """Whether a file's content was written by a gate."""
    return content.startswith((JUNIT_HEAD, MARKDOWN_HEAD))
