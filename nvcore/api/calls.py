"""The calls of Python users: compare, audit, gate, groups."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nvcore import comparison
from nvcore.api.comparison import Comparison
from nvcore.api.inputs import load
from nvcore.arguments import called_with
from nvcore.arguments.groups import GroupArguments
from nvcore.auditing import audit as audit_dataset
from nvcore.auditing import picture_findings
from nvcore.dataset import Dataset
from nvcore.errors import ParameterError
from nvcore.evidence.operating_points import at_operating_point
from nvcore.findings import Finding, worst_first
from nvcore.group_statistics import GroupComparison, compare_groups
from nvcore.report.gate import run_gate
from nvcore.report.gate.measures import measure_names
from nvcore.report.gate.outcomes import RuleOutcome
from nvcore.report.gate.results import terminal_lines
from nvcore.report.gate.rules import read_rules


@called_with(load)
def compare(dataset: Dataset) -> Comparison:
    """Compare two systems against the ground truth.

    The thresholds, parameters, protocol and choice of X and Y are those of the session, unless
    they are given here.

    Raises
    ------
    InputError
        If an input cannot be used, or there are fewer than two systems.
    ParameterError
        If there is no such setting, or a value is outside its range.

    Examples
    --------
    >>> result = compare("sample_data/session.toml", alpha=0.8)  # doctest: +SKIP
    >>> print(result)  # doctest: +SKIP
    >>> result = compare(truth=truth, x=x, y=y, size=(1280, 720), fps=30)  # doctest: +SKIP
    """
    point = dataset.settings.operating_point or "as-set"
    return Comparison(at_operating_point(comparison.compare(dataset), point))


@called_with(load)
def audit(dataset: Dataset) -> tuple[Finding, ...]:
    """What is wrong or suspicious in the inputs and pictures, worst first; nothing is scored.

    One system is enough.

    Raises
    ------
    InputError
        If an input cannot be used.
    ParameterError
        If there is no such setting, or a value is outside its range.

    Examples
    --------
    >>> for finding in audit("sample_data/session.toml"):  # doctest: +SKIP
    ...     print(finding.severity, finding.subject, finding.message)
    """
    return worst_first([*audit_dataset(dataset), *picture_findings(dataset)])


@dataclass(frozen=True)
class GateOutcome:
    """Whether a comparison passes its rules; true if all of them hold.

    Attributes
    ----------
    outcomes
        What became of each rule, the audit's included.
    """

    outcomes: tuple[RuleOutcome, ...]

    @property
    def passed(self) -> tuple[RuleOutcome, ...]:
        """The rules that hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.is_passed)

    @property
    def failed(self) -> tuple[RuleOutcome, ...]:
        """The rules that do not."""
        return tuple(outcome for outcome in self.outcomes if not outcome.is_passed)

    @property
    def is_passed(self) -> bool:
        """Whether all rules hold."""
        return not self.failed

    def __bool__(self) -> bool:
        return self.is_passed

    def __str__(self) -> str:
        return "\n".join(terminal_lines(self.outcomes))


def gate(result: Comparison, rules: Iterable[str], *, strict: bool = False) -> GateOutcome:
    """Whether rules such as ``new_misses == 0`` hold, and the audit finds no errors.

    Parameters
    ----------
    rules
        A measure, a comparison and a number each, as of ``nvcore gate``: with the release in use as
        X and the candidate as Y, ``new_misses`` are the encounters that only the first detects.
    strict
        Whether warnings of the audit count as errors do.

    Raises
    ------
    ParameterError
        If a text is no rule, or there is no such measure.

    Examples
    --------
    >>> outcome = gate(result, ["new_misses == 0", "lamr_y <= 10%"])  # doctest: +SKIP
    >>> bool(outcome), outcome.failed[0].message  # doctest: +SKIP
    (False, 'new_misses is 8')
    """
    texts = [rules] if isinstance(rules, str) else list(rules)
    numbered = [(f"rule {number}", text) for number, text in enumerate(texts, 1)]
    parsed, problems = read_rules(numbered, measure_names())
    if problems:
        raise ParameterError("\n".join(problems))
    outcomes, _ = run_gate(parsed, result.result, result.input_findings, strict=strict)
    return GateOutcome(tuple(outcomes))


@called_with(GroupArguments)
def groups(arguments: GroupArguments) -> GroupComparison:
    """Compare groups of persons or drives: which conditions differ, by the test that fits.

    Parameters
    ----------
    table
        A CSV file or a table in memory: ``condition`` and ``value``, if known ``participant``; or
        ``condition,n,mean,sd``. A table of drives has
        ``participant,condition,duration_s,violations,kind``.
    rename
        Other names of conditions; those of one name are compared as one, and one without a name is
        left out: ``{"visual": "feedback", "audio": "feedback", "control": ""}``.

    Returns
    -------
    GroupComparison
        Its tables are ``groups``, ``tests``, ``pairs``, ``assumptions`` and ``sizes``;
        ``sentences`` says what they come to, ``print`` shows all of it.

    Raises
    ------
    InputError
        If the table cannot be used; with file and line.
    ParameterError
        If a choice is impossible, or does not go with the table.

    Examples
    --------
    >>> result = groups("reactions.csv")  # doctest: +SKIP
    >>> result.fits, result.tests.loc[result.tests["fits"], "p"].item()  # doctest: +SKIP
    """
    return compare_groups(arguments)
