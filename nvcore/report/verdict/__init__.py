"""What a comparison supports: a headline, and notes by topic, no stronger than its data."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Final

import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis, Claim, decided_on, find_claims
from nvcore.evidence.companions import Companions
from nvcore.evidence.operating_points import SETTLED
from nvcore.findings import Finding, Severity
from nvcore.measures.table import as_shown
from nvcore.notes import Note, phrase, say
from nvcore.notes.caveats import caveats
from nvcore.objects import Objects
from nvcore.report.verdict import points
from nvcore.report.verdict.headline import headline
from nvcore.subjects import contributed, in_place
from nvcore.wording import capitalised

NO_COMPARISON: Final[Mapping[str, Note]] = {
    "same-boxes": Note("verdict.same_boxes"),
    "truth-as-system": Note("verdict.truth_as_system"),
}
"""Headlines of findings by which there are no two systems to compare."""


@dataclass(frozen=True)
class Point:
    """What the verdict says on one topic.

    Attributes
    ----------
    topic
        In a word or two, such as ``Encounters``.
    notes
        At least one.
    after
        Topic of the point that it follows; empty: it has its own place.
    is_warning
        Whether it stands beside the headline, too.
    """

    topic: str
    notes: tuple[Note, ...]
    after: str = ""
    is_warning: bool = False

    @property
    def key(self) -> str:
        """By which other points find it."""
        return self.topic


@dataclass(frozen=True)
class PointOf:
    """A point that a subject adds.

    Attributes
    ----------
    topic
        In a word or two.
    find
        Its notes; none: there is nothing to say.
    after
        Topic of the point that it follows.
    is_warning
        Whether it stands beside the headline, too, where there is room.
    """

    topic: str
    find: Callable[[Result], tuple[Note, ...]]
    after: str
    is_warning: bool = False


@dataclass(frozen=True)
class Verdict:
    """What a comparison supports.

    Attributes
    ----------
    headline
        What is claimed, or that nothing is, and why.
    points
        What it rests on, the most important first.
    claims
        Every difference that is called more than chance.
    basis
        The comparison that the claims are about.
    doubt
        What all this depends on, by the audit; None: nothing.
    objects
        What sentences call the objects that the boxes are of.
    """

    headline: Note
    points: tuple[Point, ...]
    claims: tuple[Claim, ...]
    basis: Basis
    doubt: Note | None
    objects: Objects

    def say(self, *notes: Note | None) -> str:
        """Word notes as sentences."""
        return " ".join(say(note, self.objects) for note in notes if note is not None)

    @property
    def in_short(self) -> str:
        """The headline in one short sentence, without its reason."""
        return capitalised(phrase(self.headline, self.objects, "short"))

    @property
    def reason(self) -> str:
        """Why the headline says no more, or what its claims rest on."""
        return capitalised(phrase(self.headline, self.objects, "because"))

    @property
    def topics(self) -> tuple[tuple[str, str], ...]:
        """Each point in a word or two, and what is to be said on it; at last the audit."""
        doubt = [("Audit", self.say(self.doubt))] if self.doubt else []
        return (*((point.topic, self.say(*point.notes)) for point in self.points), *doubt)

    @property
    def sentences(self) -> tuple[str, ...]:
        """Headline, points and doubt, sentence by sentence."""
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
) -> Verdict:
    """Which differences between X and Y may be claimed, and what the measures say.

    Where X and Y are set to different operating points the headline says so, and claims are about
    both at equal false alarms, if a threshold gives these. The points tell who detects more
    encounters, what the failures weigh, what subjects add, who is better in the other measures,
    which of the differences are more than chance, where strict pairing disagrees, and how many
    recordings would show more. X and Y are called
    ``X`` and ``Y``; the worst failure is named by its recording and track.

    Parameters
    ----------
    findings
        Of the audit of the same inputs.
    evidence
        `nvcore.evidence.table.evidence_table` of the result; None: not tested.
    companions
        `nvcore.evidence.companions.find_companions` of the result; None: not yet known, and nothing
        is claimed.
    plan
        `nvcore.report.plan.verdict_plan` of the result: how many more recordings it would take.

    Notes
    -----
    Without a near encounter the point on encounters says that there is none; a measure that is
    undefined for a system is left out.

    Examples
    --------
    >>> verdict(result).sentences[0]  # doctest: +SKIP
    'X is better on encounters detected (31 against 24): more than chance over 12 recordings.'
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
    others = {*result.dataset.systems} - {result.x.name, result.y.name}
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
            Point("Question", points.question(result, decisive)),
            Point("Encounters", points.encounters(result, tested, support)),
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
            for of in chain(*contributed("points"))
        ),
    )
    return Verdict(
        headline(result, decisive, companions, support),
        tuple(point for point in every if point.notes),
        support.claims,
        support.basis,
        doubt,
        result.objects,
    )


def _doubt(serious: Sequence[Finding]) -> Note:
    """Return the findings that all depends on; those without a caveat are counted."""
    known = {**caveats().warned, **caveats().lesser}
    codes = [finding.code for finding in serious]
    return Note(
        "verdict.doubt",
        known=[code for code in dict.fromkeys(codes) if code in known],
        n_others=sum(code not in known for code in codes),
    )
