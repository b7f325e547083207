"""Outcomes of rules: each one is met or broken."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from nvcore.report.gate.rules import COMPARISONS, Rule, check_name


def value_text(value: float) -> str:
    """Format the value of a measure with six digits."""
    return "undefined" if math.isnan(value) else f"{value + 0.0:.6g}"  # -0.0 is 0


@dataclass(frozen=True)
class RuleOutcome:
    """Outcome of a rule.

    Attributes
    ----------
    value
        Value of the measure. If it is undefined (NaN), the rule fails unless it allows this.
    details
        Remarks of subjects on the measure, followed by the encounters or findings that a failed
        rule counts, one line each, named as in the inputs, or by the reason why the measure is
        undefined at unequal operating points.
    """

    rule: Rule
    value: float
    is_passed: bool
    details: tuple[str, ...] = ()

    @property
    def message(self) -> str:
        """Value of the measure, in words."""
        text = f"{self.rule.name} is {value_text(self.value)}"
        if not math.isnan(self.value):
            return text
        if self.is_passed:
            return f"{text}, which the rule allows"
        return f"{text}; add 'or undefined' to the rule if that is fine"


def judge(rules: Iterable[Rule], values: Mapping[str, float]) -> list[RuleOutcome]:
    """Judge whether each rule is met. An undefined measure breaks a rule unless it is allowed.

    Raises
    ------
    ParameterError
        If a rule names an unknown measure.
    """
    outcomes = []
    for rule in rules:
        check_name(rule, values)
        value = values[rule.name]
        holds = (
            rule.allows_undefined
            if math.isnan(value)
            else COMPARISONS[rule.comparison](value, rule.limit)
        )
        outcomes.append(RuleOutcome(rule, value, holds))
    return outcomes
