"""Details of a rule's outcome: the encounters and findings that the rule counts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from nvcore.common.findings import Finding
from nvcore.common.wording import LEAST_HOURLY_S, duration_text
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import hides_rate
from nvcore.dataset.schema import Category
from nvcore.evidence.operating_points import alarms_as_set, is_undecided
from nvcore.notes import Note, phrase, say
from nvcore.report.gate.added import added_rules
from nvcore.report.gate.measures import (
    COUNTED_ALARMS,
    COUNTED_ENCOUNTERS,
    COUNTED_FINDINGS,
    MEASURE_OF,
    WORSE,
    members,
)
from nvcore.report.gate.outcomes import RuleOutcome
from nvcore.report.gate.rules import class_in
from nvcore.tables.encounters.changes import located_changes

MAX_LISTED: Final = 10


def explain(
    outcomes: Iterable[RuleOutcome], result: Result, findings: Sequence[Finding]
) -> list[RuleOutcome]:
    """Add details to the outcomes of rules (`RuleOutcome.details`)."""
    return [replace(outcome, details=_details(outcome, result, findings)) for outcome in outcomes]


def _details(outcome: RuleOutcome, result: Result, findings: Sequence[Finding]) -> tuple[str, ...]:
    name = outcome.rule.name
    if name in WORSE and is_undecided(result, WORSE[name][0]):
        note = Note("verdict.unequal_rule", alarms=alarms_as_set(result))
        return (phrase(note, result.objects),)
    if name in MEASURE_OF and hides_rate(MEASURE_OF[name], result.duration_s):
        asked, there = duration_text(LEAST_HOURLY_S), duration_text(result.duration_s)
        return (f"No rate per hour is given of less than {asked}: the recordings last {there}",)
    known = tuple(
        say(note, result.objects) for of in added_rules() for note in of.notes(result, name)
    )
    if outcome.is_passed:
        return known
    counted = name.partition(".")[0] if class_in(name) else name
    if counted in COUNTED_ENCOUNTERS:
        category = COUNTED_ENCOUNTERS[counted]
        return tuple(encounters_of(result, category, members(result, name)))
    if name in COUNTED_ALARMS:
        changes = located_changes(result)
        cases = changes[changes["kind"] == COUNTED_ALARMS[name].value]
        names = ("recording", "first_frame", "last_frame")
        spans = cases[[*names]].head(MAX_LISTED).itertuples(index=False, name=None)
        return (*known, *_with_others([f"{of}, {_when(*span)}" for of, *span in spans], len(cases)))
    for of in added_rules():
        if name in of.counted:
            is_counted, is_open = of.counted[name](result), of.is_open(result)
            return (*known, *_listed(result, is_counted, is_open=is_open))
    of_audit = (
        f"{finding.subject}: {finding.message}"
        for finding in findings
        if finding.severity is COUNTED_FINDINGS.get(name)
    )
    return (*known, *of_audit)


def encounters_of(
    result: Result, category: Category, is_member: np.ndarray | None = None
) -> list[str]:
    """Describe the first `MAX_LISTED` encounters of a category by recording, track and frames.

    Parameters
    ----------
    is_member
        Encounters that may be listed, bool. None: all.
    """
    is_listed = result.category == category.value
    return _listed(result, is_listed if is_member is None else is_listed & is_member)


def _listed(
    result: Result, is_listed: np.ndarray, *, is_open: np.ndarray | None = None
) -> list[str]:
    """Describe the first `MAX_LISTED` of the selected encounters, marking open ones."""
    rows = np.flatnonzero(is_listed)
    encounters, frame = result.encounters, result.dataset.frames["frame"].to_numpy()
    recordings = result.dataset.recordings["name"].to_numpy()
    lines = []
    for row in rows[:MAX_LISTED]:
        first, last = frame[encounters.first_row[row]], frame[encounters.last_row[row]]
        lines.append(
            f"{recordings[encounters.recording[row]]}, track {encounters.track[row]}, "
            + _when(first, last)
            + (", open" if is_open is not None and is_open[row] else "")
        )
    return _with_others(lines, len(rows))


def _when(first: int, last: int) -> str:
    return f"frame {first}" if first == last else f"frames {first} to {last}"


def _with_others(lines: list[str], n: int) -> list[str]:
    """Append how many of `n` cases are not listed."""
    return [*lines, f"and {n - len(lines)} more"] if n > len(lines) else lines
