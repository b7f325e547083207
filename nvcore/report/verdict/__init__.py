"""Verdict on a comparison: a headline and notes by topic, claiming only what the data show."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Final

import pandas as pd

from nvcore.common.findings import Finding, Severity
from nvcore.common.subject import in_place, subjects
from nvcore.common.wording import capitalised
from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import as_shown
from nvcore.evidence.claims import Basis, Claim, decided_on, find_claims
from nvcore.evidence.companions import Companions
from nvcore.evidence.looks import ONLY_LOOK, Look
from nvcore.evidence.operating_points import SETTLED
from nvcore.notes import Note, phrase, say
from nvcore.notes.caveats import caveats
from nvcore.report.verdict import points
from nvcore.report.verdict.headline import headline
from nvcore.settings.objects import Objects

NO_COMPARISON: Final[Mapping[str, Note]] = {
    "same-boxes": Note("verdict.same_boxes"),
    "truth-as-system": Note("verdict.truth_as_system"),
}
"""Headlines for findings that leave no two systems to compare."""
HOW_SURE: Final = "How sure"
"""Topic of how likely a system misses fewer encounters."""


@dataclass(frozen=True)
class Point:
    """Notes of the verdict on one topic.

    Attributes
    ----------
    topic
        Title in a word or two, such as ``Encounters``.
    notes
        At least one note.
    after
        Topic of the point that it follows; empty if the point has its own place.
    is_warning
        True if the point is also shown beside the headline.
    """

    topic: str
    notes: tuple[Note, ...]
    after: str = ""
    is_warning: bool = False

    @property
    def key(self) -> str:
        """Key by which other points refer to this one: its topic."""
        return self.topic


@dataclass(frozen=True)
class PointOf:
    """A topic that a subject adds to the verdict.

    Attributes
    ----------
    topic
        Title in a word or two.
    find
        Function that returns the notes of a result; the point is left out if there are none.
    after
        Topic of the point that it follows.
    is_warning
        True if the point is also shown beside the headline if there is room.
    """

    topic: str
    find: Callable[[Result], tuple[Note, ...]]
    after: str
    is_warning: bool = False


@dataclass(frozen=True)
class Verdict:
    """Verdict on a comparison: headline, notes by topic, and claims.

    Attributes
    ----------
    headline
        The claim with its reason, or why nothing is claimed.
    points
        Basis of the headline, the most important point first.
    claims
        All differences that are called more than chance.
    basis
        The comparison that the claims are about.
    doubt
        Findings of the audit on which the verdict depends, or None.
    objects
        Names of the annotated objects in sentences.
    evidence
        Tests of the comparison as set (`nvcore.evidence.table.evidence_table`), or None.
    """

    headline: Note
    points: tuple[Point, ...]
    claims: tuple[Claim, ...]
    basis: Basis
    doubt: Note | None
    objects: Objects
    evidence: pd.DataFrame | None = field(default=None, compare=False, repr=False)

    def say(self, *notes: Note | None) -> str:
        """Render notes as sentences."""
        return " ".join(say(note, self.objects) for note in notes if note is not None)

    @property
    def in_short(self) -> str:
        """Headline as one short sentence, without its reason."""
        return capitalised(phrase(self.headline, self.objects, "short"))

    @property
    def reason(self) -> str:
        """Reason for the headline: what its claims are based on, or why it claims no more."""
        return capitalised(phrase(self.headline, self.objects, "because"))

    @property
    def topics(self) -> tuple[tuple[str, str], ...]:
        """Titles and texts of the points, followed by those of the audit."""
        doubt = [("Audit", self.say(self.doubt))] if self.doubt else []
        return (*((point.topic, self.say(*point.notes)) for point in self.points), *doubt)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Sentences of the headline, the points and the audit."""
        of_points = chain.from_iterable(point.notes for point in self.points)
        every = (self.headline, *of_points, self.doubt)
        return tuple(self.say(fact) for fact in every if fact is not None)


def verdict(
    result: Result,
    findings: Sequence[Finding] = (),
    *,
    evidence: pd.DataFrame | None = None,
    companions: Companions | None = None,
    plan: tuple[Note, ...] = (),
    look: Look = ONLY_LOOK,
) -> Verdict:
    """Decide which differences between X and Y may be claimed, and describe the measures.

    If X and Y are set to different operating points, the headline says so, and claims are about
    both at equal false alarms, provided that a threshold gives these. The points tell how likely a
    system misses fewer encounters, which one detects more, how severe the failures are, which
    system is better in the other measures, which differences are more than chance, where strict
    pairing disagrees, and how many more recordings it would take. Subjects add points of their own.
    Systems are called ``X`` and ``Y``; the worst failure is named by its recording and track.

    Parameters
    ----------
    findings
        Findings of the audit of the same inputs.
    evidence
        `nvcore.evidence.table.evidence_table` of the result, or None if it is not tested.
    companions
        `nvcore.evidence.companions.find_companions` of the result. Nothing is claimed while they
        are unknown (None).
    plan
        `nvcore.report.plan.verdict_plan` of the result: how many more recordings it would take.
    look
        The look for which `nvcore.evidence.looks.correct_for_looks` corrected p.

    Notes
    -----
    Without a near encounter, the point on encounters says that there is none. A measure that is
    undefined for a system is left out.

    Examples
    --------
    >>> verdict(result).sentences[0]  # doctest: +SKIP
    'X is better on encounters detected (31 vs 24), by more than chance across 12 recordings.'
    """
    about, decisive = decided_on(result, evidence, companions)
    is_at_equal_alarms = about is not result or result.as_set is not None
    told = {*NO_COMPARISON, SETTLED} if is_at_equal_alarms else {*NO_COMPARISON}
    serious = [
        finding
        for finding in findings
        if finding.severity is not Severity.NOTE
        and not finding.is_of_pictures
        and finding.code not in told  # the headline says it
    ]
    doubt = _doubt(serious) if serious else None
    others = {*result.dataset.systems} - {*result.names}
    codes = {finding.code for finding in findings if finding.subject not in others}
    of_codes = [note for code, note in NO_COMPARISON.items() if code in codes]
    if any(finding.severity is Severity.ERROR for finding in serious):
        of_codes.append(Note("verdict.wrong_inputs"))
    if of_codes:
        return Verdict(of_codes[0], (), (), Basis.NONE, doubt, result.objects)
    support = find_claims(result, evidence, companions)
    decisive = None if decisive is None else as_shown(about, decisive)
    tested = decisive if about is result else None
    every = in_place(
        (
            Point("Operating points", points.operating_points(result, companions)),
            Point("Question", points.question(result, decisive, look)),
            Point(HOW_SURE, points.probability(result, companions)),
            Point(
                "Encounters",
                (*points.encounters(result, tested, support), *points.unlisted(about, findings)),
            ),
            Point("Severity", points.weights(result)),
            Point("Other measures", points.measures(result, evidence)),
            Point("Chance", points.chance(result, decisive, support)),
            Point(
                "Strict pairing",
                () if companions is None else points.strict_pairing(about, companions.strict),
            ),
            Point("More recordings", plan),
            Point(
                "Thresholds",
                () if support.basis is Basis.EQUAL_ALARMS else points.thresholds(result),
            ),
        ),
        (
            Point(of.topic, of.find(result), of.after, of.is_warning)
            for subject in subjects()
            for of in subject.report().points
        ),
    )
    return Verdict(
        headline(result, decisive, companions, support),
        tuple(point for point in every if point.notes),
        support.claims,
        support.basis,
        doubt,
        result.objects,
        evidence,
    )


def _doubt(serious: Sequence[Finding]) -> Note:
    """Return a note with the caveats of these findings. Findings without a caveat are counted."""
    known = {**caveats().warned, **caveats().lesser}
    codes = [finding.code for finding in serious]
    return Note(
        "verdict.doubt",
        known=[code for code in dict.fromkeys(codes) if code in known],
        n_others=sum(code not in known for code in codes),
    )
