"""Rules of the gate, such as ``lamr_y <= 0.10``, parsed from text and validated."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Final

from nvcore.common.errors import ParameterError
from nvcore.common.wording import one_line

COMPARISONS: Final[dict[str, Callable[[float, float], bool]]] = {
    "<=": operator.le,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
}
_CORRECTIONS: Final = {
    "=": "==",
    "===": "==",
    "=<": "<=",
    "=>": ">=",
    "<>": "!=",
    "≤": "<=",
    "≥": ">=",
    "≠": "!=",
}
"""Likely meanings of comparisons that do not exist."""
_RULE: Final = re.compile(
    r"\s*([A-Za-z][A-Za-z0-9_.]*)\s*([<>=!≤≥≠]+)\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(%?)"
    r"\s*(\bor\s+undefined)?\s*"
)
OF_CLASSES: Final = ("newly_missed", "fixed", "missed_by_both", "encounters")
"""Measures that a rule may request for one class of encounters: ``newly_missed.child``."""


@dataclass(frozen=True)
class Rule:
    """Measure, comparison and limit, such as ``lamr_y <= 0.10``.

    Attributes
    ----------
    allows_undefined
        True if the rule is also met when the measure is undefined (``or undefined``).
    """

    name: str
    comparison: str
    limit: float
    text: str
    allows_undefined: bool = False


def parse_rule(text: str) -> Rule:
    """Parse a rule: a measure, one of ``<= >= == != < >``, a number, and maybe ``or undefined``.

    A percentage such as 10% is 0.1.

    Raises
    ------
    ParameterError
        If the text is not a rule.
    """
    match = _RULE.fullmatch(text)
    try:
        if match is None:
            raise ValueError
        limit = float(match[3]) / (100 if match[4] else 1)
    except ValueError as error:
        raise ParameterError(
            f"{one_line(text)!r}: expected a measure, a comparison and a number, such as "
            "'lamr_y <= 0.10' or 'newly_missed == 0'"
        ) from error
    rule_text = " ".join(text.split())
    if match[2] not in COMPARISONS:
        correction = _CORRECTIONS.get(match[2])
        hint = (
            f"did you mean {rule_text.replace(match[2], correction, 1)!r}?"
            if correction
            else f"there are {' '.join(COMPARISONS)}"
        )
        raise ParameterError(f"{rule_text!r}: there is no comparison {match[2]!r}; {hint}")
    return Rule(match[1], match[2], limit, rule_text, allows_undefined=match[5] is not None)


def read_rules(
    lines: Iterable[tuple[str, str]], names: Sequence[str]
) -> tuple[list[Rule], list[str]]:
    """Parse rules from lines, and describe the errors of invalid lines.

    Parameters
    ----------
    lines
        Location of each line, such as ``rules.txt, line 3``, and its text. Empty lines and comments
        after ``#`` are skipped.
    names
        Names of the existing measures.
    """
    rules, problems = [], []
    for where, line in lines:
        text = line.split("#", 1)[0].strip()
        if not text:
            continue
        try:
            rule = parse_rule(text)
            check_name(rule, names)
        except ParameterError as error:
            problems.append(f"{where}: {error}")
        else:
            rules.append(rule)
    return rules, problems


def class_in(name: str) -> str:
    """Return the class of encounters that a measure's name requests, or "" for none.

    Examples
    --------
    >>> class_in("newly_missed.child"), class_in("venn.x_only")
    ('child', '')
    """
    of_all, _, wanted = name.partition(".")
    return wanted if of_all in OF_CLASSES else ""


def check_name(rule: Rule, names: Iterable[str]) -> None:
    """Refuse a rule about none of these measures.

    Raises
    ------
    ParameterError
        If the measure is not among them, with the closest names.
    """
    existing = list(names)
    if rule.name in existing or class_in(rule.name):
        return
    close = get_close_matches(rule.name, existing, n=3, cutoff=0.5)
    hint = f"; did you mean {', '.join(close)}?" if close else ""
    raise ParameterError(f"{rule.text!r}: there is no measure {rule.name!r}{hint}")
