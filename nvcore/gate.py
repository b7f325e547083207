"""Rules that a comparison has to pass, for nightly runs: parsed, judged, told to people and CI."""

from __future__ import annotations

import math
import operator
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, Final
from xml.etree import ElementTree

from nvcore.analysis import Result
from nvcore.curve_summary import CurveSummary, summarise_curve
from nvcore.curves import detection_curve
from nvcore.errors import ParameterError, one_line
from nvcore.findings import Finding, Severity
from nvcore.protocols import Protocol
from nvcore.tables import sides, system_summary

COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<=": operator.le, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
    "<": operator.lt, ">": operator.gt,
}  # fmt: skip
CURVE_NAMES: Final = {
    "lamr": "log_average_miss_rate",
    "ap": "average_precision_coco",
    "ap_area": "average_precision",
    "pr_auc": "pr_auc",
    "recall": "recall",
    "precision": "precision",
    "f1": "f1",
    "fppi": "fppi",
}
"""Figures of the detection curve, and their names in `CurveSummary`."""
_RULE: Final = re.compile(
    r"\s*([A-Za-z][A-Za-z0-9_.]*)\s*(<=|>=|==|!=|<|>)\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(%?)\s*"
)


@dataclass(frozen=True)
class Rule:
    """A figure, a comparison and a limit, such as ``lamr_x <= 0.10``."""

    name: str
    comparison: str
    limit: float
    text: str


@dataclass(frozen=True)
class Outcome:
    """What became of a rule.

    Attributes
    ----------
    value
        Of the figure; NaN undefined: the rule then fails.
    """

    rule: Rule
    value: float
    is_passed: bool

    @property
    def message(self) -> str:
        """What was found, in words."""
        if math.isnan(self.value):
            return f"{self.rule.name} is undefined"
        return f"{self.rule.name} is {self.value:.6g}"


def parse_rule(text: str) -> Rule:
    """A rule from its text: a figure, one of ``<= >= == != < >``, a number (10% is 0.1).

    Raises
    ------
    ParameterError
        If the text is no such rule.
    """
    found = _RULE.fullmatch(text)
    try:
        if found is None:
            raise ValueError
        limit = float(found[3]) / (100 if found[4] else 1)
    except ValueError as error:
        raise ParameterError(
            f"rule {one_line(text)!r}: expected a figure, a comparison and a number, such as "
            "'lamr_x <= 0.10' or 'new_misses == 0'"
        ) from error
    return Rule(found[1], found[2], limit, " ".join(text.split()))


def parse_rules(lines: Iterable[str]) -> list[Rule]:
    """Rules from lines; empty ones and what follows a ``#`` are left out."""
    texts = (line.split("#", 1)[0].strip() for line in lines)
    return [parse_rule(text) for text in texts if text]


def gate_figures(
    result: Result, findings: Sequence[Finding], protocol: Protocol, wanted: Iterable[str]
) -> dict[str, float]:
    """The figures that rules may name; those of detection curves only where they are wanted.

    ``new_misses`` are the encounters that X detects and Y does not, ``mended_misses`` the other
    way round: with the release in use as X and the candidate as Y.

    Parameters
    ----------
    protocol
        Of the detection curves.
    wanted
        Names in rules.
    """
    figures: dict[str, float] = {}
    for letter, system in sides(result):
        for name, value in _numbers(system_summary(result, system)):
            figures[f"{name}_{letter}"] = value
    if any(one.rsplit("_", 1)[0] in CURVE_NAMES for one in wanted):
        for letter, system in sides(result):
            curve = detection_curve(result.dataset, system.name, result.params, protocol)
            summary: CurveSummary = summarise_curve(curve, system.threshold)
            for name, attribute in CURVE_NAMES.items():
                figures[f"{name}_{letter}"] = float(getattr(summary, attribute))
    for name in [one.removesuffix("_x") for one in figures if one.endswith("_x")]:
        figures[f"{name}_difference"] = figures[f"{name}_x"] - figures[f"{name}_y"]
    count = Counter(finding.severity for finding in findings)
    venn = result.venn
    # without an encounter nothing can be missed: undefined, so that no rule passes by that
    defined = 1.0 if venn.n_near else math.nan
    return figures | {
        "new_misses": venn.x_only * defined,
        "mended_misses": venn.y_only * defined,
        "missed_by_both": venn.neither * defined,
        "encounters": float(venn.n_near),
        "mcnemar_p": result.exclusivity.mcnemar_p * defined,
        "audit_errors": float(count[Severity.ERROR]),
        "audit_warnings": float(count[Severity.WARNING]),
    }


def _numbers(content: Mapping[str, Any], before: str = "") -> Iterable[tuple[str, float]]:
    """Numeric entries, nested ones as ``outer.inner``."""
    for name, value in content.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, f"{before}{name}.")
        elif isinstance(value, int | float) or value is None:
            yield f"{before}{name}", math.nan if value is None else float(value)


def judge(rules: Sequence[Rule], figures: Mapping[str, float]) -> list[Outcome]:
    """Whether each rule holds; an undefined figure breaks its rule.

    Raises
    ------
    ParameterError
        If a rule names an unknown figure.
    """
    outcomes = []
    for rule in rules:
        if rule.name not in figures:
            close = get_close_matches(rule.name, figures, n=3, cutoff=0.5)
            hint = f"; did you mean {', '.join(close)}?" if close else ""
            raise ParameterError(
                f"rule {rule.text!r}: there is no figure {rule.name!r}{hint} "
                "(nvcore gate --list shows all)"
            )
        value = figures[rule.name]
        holds = not math.isnan(value) and COMPARISONS[rule.comparison](value, rule.limit)
        outcomes.append(Outcome(rule, value, holds))
    return outcomes


def junit_xml(outcomes: Sequence[Outcome], title: str) -> bytes:
    """The outcomes as JUnit XML, a test case for each rule.

    Parameters
    ----------
    title
        Name of the test suite.
    """
    n_failed = sum(not one.is_passed for one in outcomes)
    counts = {"tests": str(len(outcomes)), "failures": str(n_failed), "errors": "0"}
    root = ElementTree.Element("testsuites", counts)
    suite = ElementTree.SubElement(root, "testsuite", {"name": one_line(title), **counts})
    for one in outcomes:
        case = ElementTree.SubElement(
            suite, "testcase", {"classname": "nvcore.gate", "name": one.rule.text}
        )
        if not one.is_passed:
            message = f"{one.message}; wanted {one.rule.text}"
            ElementTree.SubElement(case, "failure", {"message": message}).text = message
        else:
            ElementTree.SubElement(case, "system-out").text = one.message
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def markdown(outcomes: Sequence[Outcome], title: str) -> str:
    """The outcomes as a Markdown table, failing rules first."""
    rows = sorted(outcomes, key=lambda one: one.is_passed)
    n_failed = sum(not one.is_passed for one in outcomes)
    verdict = f"{n_failed} of {len(outcomes)} rules failed" if n_failed else "all rules passed"
    lines = [f"## {_escaped(title)}: {verdict}", "", "| rule | found | |", "|---|---|---|"]
    lines += [
        f"| `{one.rule.text}` | {'–' if math.isnan(one.value) else f'{one.value:.6g}'} | "
        f"{'passed' if one.is_passed else '**failed**'} |"
        for one in rows
    ]
    return "\n".join(lines) + "\n"


def _escaped(text: str) -> str:
    return re.sub(r"([\\`*_{}\[\]<>()#|~])", r"\\\1", one_line(text))
