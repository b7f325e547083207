"""Rules that a comparison has to pass, for nightly runs: what they say, and whether they hold."""

from __future__ import annotations

import math
import operator
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Any, Final

import numpy as np

from nvcore.comparison import Result
from nvcore.detection.curve_summary import summarise_curve
from nvcore.detection.curves import detection_curve
from nvcore.errors import ParameterError
from nvcore.findings import Finding, Severity
from nvcore.measures import MEASURES
from nvcore.protocols import Protocol
from nvcore.schema import Category
from nvcore.tables.columns import Column, Kind
from nvcore.tables.summary import SUMMARY_KEYS, SYSTEM_KEYS, summary, system_summary
from nvcore.wording import one_line

COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<=": operator.le, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
    "<": operator.lt, ">": operator.gt,
}  # fmt: skip
_OF_CURVE: Final = {one.rule: one.of_curve for one in MEASURES if one.rule and one.of_curve}
"""Measures of the detection curve, by their names in rules."""
_MISTAKEN: Final = {
    "=": "==", "===": "==", "=<": "<=", "=>": ">=", "<>": "!=", "≤": "<=", "≥": ">=", "≠": "!=",
}  # fmt: skip
_RULE: Final = re.compile(
    r"\s*([A-Za-z][A-Za-z0-9_.]*)\s*([<>=!≤≥≠]+)\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(%?)"
    r"\s*(\bor\s+undefined)?\s*"
)
COUNTED_ENCOUNTERS: Final = {
    "new_misses": Category.X_ONLY,
    "mended_misses": Category.Y_ONLY,
    "missed_by_both": Category.NEITHER,
    "venn.x_only": Category.X_ONLY,
    "venn.y_only": Category.Y_ONLY,
    "venn.neither": Category.NEITHER,
}
"""Measures that count encounters, which are listed where the rule fails."""
COUNTED_FINDINGS: Final = {"audit_errors": Severity.ERROR, "audit_warnings": Severity.WARNING}
"""Measures that count findings of the audit, likewise."""
MAX_LISTED: Final = 10
_OTHERS: Final = (
    "new_misses", "mended_misses", "missed_by_both", "encounters", "mcnemar_p", *COUNTED_FINDINGS,
)  # fmt: skip


def _numeric(columns: Iterable[Column]) -> list[str]:
    return [one.name for one in columns if one.kind in (Kind.INTEGER, Kind.NUMBER)]


SUMMARY_NAMES: Final = (
    *_numeric(SUMMARY_KEYS),
    *(f"fusion.{kind}.{name}" for kind in ("x_or_y", "x_and_y") for name in _numeric(SYSTEM_KEYS)),
)
"""Measures in ``summary.json`` that are not of X or Y; worked out where a rule names one."""


def measure_names() -> list[str]:
    """Names of all measures that a rule may name."""
    of_systems = [*_numeric(SYSTEM_KEYS), *_OF_CURVE]
    ended = [f"{name}_{end}" for name in of_systems for end in ("x", "y", "difference")]
    return [*ended, *_OTHERS, *SUMMARY_NAMES]


def value_text(value: float) -> str:
    """The value of a measure with six digits."""
    return "undefined" if math.isnan(value) else f"{value:.6g}"


@dataclass(frozen=True)
class Rule:
    """A measure, a comparison and a limit, such as ``lamr_y <= 0.10``.

    Attributes
    ----------
    allows_undefined
        Whether the rule also holds where the measure is undefined (``or undefined``).
    """

    name: str
    comparison: str
    limit: float
    text: str
    allows_undefined: bool = False


@dataclass(frozen=True)
class Outcome:
    """What became of a rule.

    Attributes
    ----------
    value
        Of the measure; NaN undefined: the rule then fails, unless it says otherwise.
    details
        What a failed rule counts: encounters or findings, one line each, as they are named in the
        inputs.
    """

    rule: Rule
    value: float
    is_passed: bool
    details: tuple[str, ...] = ()

    @property
    def message(self) -> str:
        """What was found, in words."""
        found = f"{self.rule.name} is {value_text(self.value)}"
        if not math.isnan(self.value):
            return found
        if self.is_passed:
            return f"{found}, which the rule allows"
        return f"{found}; add 'or undefined' to the rule if that is fine"


def parse_rule(text: str) -> Rule:
    """A rule: a measure, one of ``<= >= == != < >``, a number (10% is 0.1), maybe ``or undefined``.

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
            f"{one_line(text)!r}: expected a figure, a comparison and a number, such as "
            "'lamr_y <= 0.10' or 'new_misses == 0'"
        ) from error
    said = " ".join(text.split())
    if found[2] not in COMPARISONS:
        meant = _MISTAKEN.get(found[2])
        hint = (
            f"did you mean {said.replace(found[2], meant, 1)!r}?"
            if meant
            else f"there are {' '.join(COMPARISONS)}"
        )
        raise ParameterError(f"{said!r}: there is no comparison {found[2]!r}; {hint}")
    return Rule(found[1], found[2], limit, said, allows_undefined=found[5] is not None)


def read_rules(
    lines: Iterable[tuple[str, str]], names: Sequence[str]
) -> tuple[list[Rule], list[str]]:
    """Rules from lines, and what is wrong with the others, in words.

    Parameters
    ----------
    lines
        Where each one stands, such as ``rules.txt, line 3``, and its text. Empty ones, and what
        follows a ``#``, are left out.
    names
        Of the measures that there are.
    """
    rules, problems = [], []
    for where, line in lines:
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        try:
            rule = parse_rule(text)
            _check_name(rule, names)
        except ParameterError as error:
            problems.append(f"{where}: {error}")
        else:
            rules.append(rule)
    return rules, problems


def _check_name(rule: Rule, names: Iterable[str]) -> None:
    known = list(names)
    if rule.name in known:
        return
    close = get_close_matches(rule.name, known, n=3, cutoff=0.5)
    hint = f"; did you mean {', '.join(close)}?" if close else ""
    raise ParameterError(
        f"{rule.text!r}: there is no figure {rule.name!r}{hint} (nvcore gate --list shows all)"
    )


def audit_rules(rules: Iterable[Rule], *, strict: bool) -> list[Rule]:
    """The rules that the audit finds no errors, and if `strict` no warnings either.

    One is left out where `rules` say themselves how many there may be.
    """
    named = {rule.name for rule in rules}
    wanted = ["audit_errors", *(["audit_warnings"] if strict else [])]
    return [parse_rule(f"{name} == 0") for name in wanted if name not in named]


def gate_measures(
    result: Result, findings: Sequence[Finding], protocol: Protocol, wanted: Iterable[str]
) -> dict[str, float]:
    """The measures that rules may name; those that take time only where they are wanted.

    ``new_misses`` are the encounters that X detects and Y does not, ``mended_misses`` the other
    way round: with the release in use as X and the candidate as Y.

    Parameters
    ----------
    protocol
        Of the detection curves.
    wanted
        Names in rules. Measures of detection curves and those of `SUMMARY_NAMES` are worked out
        if one of them is among these.
    """
    asked = set(wanted)
    values: dict[str, float] = {}
    for letter, system in result.sides:
        for name, value in _numbers(system_summary(result, system)):
            values[f"{name}_{letter}"] = value
    if any(name.rsplit("_", 1)[0] in _OF_CURVE for name in asked):
        for letter, system in result.sides:
            curve = detection_curve(result.dataset, system.name, result.params, protocol)
            of_curve = summarise_curve(curve, system.threshold)
            for name, value_of in _OF_CURVE.items():
                values[f"{name}_{letter}"] = float(value_of(of_curve))
    for name in [key.removesuffix("_x") for key in values if key.endswith("_x")]:
        values[f"{name}_difference"] = values[f"{name}_x"] - values[f"{name}_y"]
    if not asked.isdisjoint(SUMMARY_NAMES):
        of_all = dict(_numbers(summary(result)))
        values |= {name: of_all[name] for name in SUMMARY_NAMES}
    count = Counter(finding.severity for finding in findings)
    venn = result.venn
    # without an encounter nothing can be missed: undefined, so that no rule passes by that
    defined = 1.0 if venn.n_near else math.nan
    return values | {
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


def judge(rules: Iterable[Rule], values: Mapping[str, float]) -> list[Outcome]:
    """Whether each rule holds; an undefined measure breaks its rule, unless the rule allows it.

    Raises
    ------
    ParameterError
        If a rule names an unknown measure.
    """
    outcomes = []
    for rule in rules:
        _check_name(rule, values)
        value = values[rule.name]
        holds = (
            rule.allows_undefined
            if math.isnan(value)
            else COMPARISONS[rule.comparison](value, rule.limit)
        )
        outcomes.append(Outcome(rule, value, holds))
    return outcomes


def explain(
    outcomes: Iterable[Outcome], result: Result, findings: Sequence[Finding]
) -> list[Outcome]:
    """The outcomes; failed ones with the encounters or findings that they count."""
    explained = []
    for one in outcomes:
        details: list[str] = []
        if not one.is_passed and one.rule.name in COUNTED_ENCOUNTERS:
            details = encounters_of(result, COUNTED_ENCOUNTERS[one.rule.name])
        elif not one.is_passed and one.rule.name in COUNTED_FINDINGS:
            severity = COUNTED_FINDINGS[one.rule.name]
            details = [
                f"{finding.subject}: {finding.message}"
                for finding in findings
                if finding.severity is severity
            ]
        explained.append(replace(one, details=tuple(details)))
    return explained


def encounters_of(result: Result, category: Category) -> list[str]:
    """The first encounters of a category, by recording, track and frames, at most `MAX_LISTED`."""
    rows = np.flatnonzero(result.category == category.value)
    encounters, frame = result.encounters, result.dataset.frames["frame"].to_numpy()
    recordings = result.dataset.recordings["name"].to_numpy()
    told = []
    for row in rows[:MAX_LISTED]:
        first, last = frame[encounters.first_row[row]], frame[encounters.last_row[row]]
        when = f"frame {first}" if first == last else f"frames {first} to {last}"
        told.append(
            f"{recordings[encounters.recording[row]]}, track {encounters.track[row]}, {when}"
        )
    n_more = len(rows) - len(told)
    return [*told, f"and {n_more} more"] if n_more else told
