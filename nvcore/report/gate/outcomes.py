"""What becomes of rules: each holds, or does not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from nvcore.report.gate.rules import COMPARISONS, Rule, check_name


def value_text(value: float) -> str:
    """The value of a measure, with six digits."""
    return "undefined" if math.isnan(value) else f"{value + 0.0:.6g}"  # -0.0 is 0


@dataclass(frozen=True)
class RuleOutcome:
    """What became of a rule.

    Attributes
    ----------
    value
        Of the measure; NaN undefined: the rule fails unless it allows this.
    details
        What a failed rule counts: encounters or findings, one line each, named as in the inputs; or
        why the measure is undefined at unequal operating points. Before these,
        what subjects say of the measure.
    """

    rule: Rule
    value: float
    is_passed: bool
    details: tuple[str, ...] = ()

    @property
    def message(self) -> str:
        """The value of the measure, in words."""
        text = f"{self.rule.name} is {value_text(self.value)}"
        if not math.isnan(self.value):
            return text
        if self.is_passed:
            return f"{text}, which the rule allows"
        return f"{text}; add 'or undefined' to the rule if that is fine"


def judge(rules: Iterable[Rule], values: Mapping[str, float]) -> list[RuleOutcome]:
    """Whether each rule holds; an undefined measure breaks its rule, unless the rule allows it.

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
