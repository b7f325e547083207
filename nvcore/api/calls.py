"""Functions for Python users: compare, audit, gate, groups."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nvcore.api.comparison import Comparison
from nvcore.api.inputs import load
from nvcore.auditing import audit as audit_dataset
from nvcore.auditing import picture_findings
from nvcore.common.arguments import called_with
from nvcore.common.arguments.groups import GroupArguments
from nvcore.common.findings import Finding, worst_first
from nvcore.comparison import compare as comparison
from nvcore.dataset import Dataset
from nvcore.evidence.groups import GroupComparison, compare_groups
from nvcore.evidence.operating_points import at_operating_point
from nvcore.report.gate import parse_rules, run_gate
from nvcore.report.gate.outcomes import RuleOutcome
from nvcore.report.gate.results import terminal_lines


@called_with(load)
def compare(dataset: Dataset) -> Comparison:
    """Compare two systems against the ground truth.

    Thresholds, parameters, protocol and choice of X and Y default to those of the session.

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
    """Return errors and suspicious facts in the inputs and pictures, worst first.

    Nothing is scored, and one system is enough.

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
    """Outcome of checking a comparison against rules. It is true if all rules hold.

    Attributes
    ----------
    outcomes
        Outcome of each rule, including those of the audit.
    """

    outcomes: tuple[RuleOutcome, ...]

    @property
    def passed(self) -> tuple[RuleOutcome, ...]:
        """Rules that hold."""
        return tuple(outcome for outcome in self.outcomes if outcome.is_passed)

    @property
    def failed(self) -> tuple[RuleOutcome, ...]:
        """Rules that do not hold."""
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
    """Check rules such as ``newly_missed == 0``, and that the audit finds no errors.

    Parameters
    ----------
    rules
        A measure, a comparison operator and a number each, as in ``nvcore gate``. With the release
        in use as X and the candidate as Y, ``newly_missed`` counts the encounters that only the
        release detects.
    strict
        True to count warnings of the audit as errors.

    Raises
    ------
    ParameterError
        If a rule cannot be parsed, or names an unknown measure.

    Examples
    --------
    >>> outcome = gate(result, ["newly_missed == 0", "lamr_y <= 10%"])  # doctest: +SKIP
    >>> bool(outcome), outcome.failed[0].message  # doctest: +SKIP
    (False, 'newly_missed is 8')
    """
    findings = result.input_findings
    outcomes, _ = run_gate(parse_rules(rules), result.result, findings, strict=strict)
    return GateOutcome(tuple(outcomes))


@called_with(GroupArguments)
def groups(arguments: GroupArguments) -> GroupComparison:
    """Test which conditions differ between groups of persons or drives, by the test that fits.

    Parameters
    ----------
    table
        CSV file or DataFrame with the columns ``condition``, ``value`` and optionally
        ``participant``, or with ``condition,n,mean,sd``. A table of drives has
        ``participant,condition,duration_s,violations,kind``.
    rename
        New names of conditions. Conditions of the same name are merged, and an empty name leaves a
        condition out: ``{"visual": "feedback", "audio": "feedback", "control": ""}``.

    Returns
    -------
    GroupComparison
        Its tables are ``groups``, ``tests``, ``pairs``, ``assumptions`` and ``sizes``.
        ``sentences`` has the conclusions, and ``print`` shows everything.

    Raises
    ------
    InputError
        If the table cannot be used, with file and line.
    ParameterError
        If a choice is invalid, or does not fit the table.

    Examples
    --------
    >>> result = groups("reactions.csv")  # doctest: +SKIP
    >>> result.fits, result.tests.loc[result.tests["fits"], "p"].item()  # doctest: +SKIP
    """
    return compare_groups(arguments)
