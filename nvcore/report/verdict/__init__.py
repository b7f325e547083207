"""What a comparison supports: a headline, and sentences by topic, no stronger than its data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import chain
from typing import Final

import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis, Claim, find_claims
from nvcore.evidence.companions import Companions
from nvcore.findings import Caveats, Finding, Severity
from nvcore.report.shown import comparison_shown
from nvcore.report.verdict.headline import headline
from nvcore.report.verdict.words import (
    describe_chance,
    describe_encounters,
    describe_measures,
    describe_operating_points,
    describe_strict,
    describe_thresholds,
    describe_weights,
)
from nvcore.subjects import contributed, in_place

CAVEATS: Final = Caveats(
    warned={
        "track-reused": "track ids of the ground truth are used again after a gap, so that two "
        "{many} may be taken for one encounter",
        "short-encounters": "most encounters are one frame long, so that counts of them are counts "
        "of frames rather than {many}, and saliency and episodes mean little",
        "score-floors": "X and Y are compared at different operating points; with thresholds the "
        "other may come out better",
        "mixed-weighting": "X and Y are weighted by different rules",
        "same-boxes": "two of the inputs have the same boxes",
        "size-too-large": "the image size seems wrong",
        "implausible-fps": "the frame rate seems wrong",
        "box-layout": "boxes seem to be written in another way than they were read",
        "no-match": "a system matches not a single {one}",
        "agreed-by-both-alone": "both systems match hardly {anybody} and agree with one another",
        "lying-pedestrians": "nearly all {many} are wider than tall",
        "time-offset": "a system seems to be off in time",
        "pixel-offset": "a system's boxes seem to be displaced",
        "scale-mismatch": "a system's boxes seem to be of another resolution",
        "frames-beyond-boxes": "frames without any box are evaluated",
        "no-detections": "a system has no detections",
        "threshold-keeps-nothing": "a threshold leaves no detection",
    },
    lesser={
        "missing-provenance": "a system's record of its training is not there",
        "kitti-size": "the truth contradicts the picture size of some recordings",
        "outside-picture": "boxes lie outside the picture",
        "boxes-in-fractions": "boxes seem to be in fractions of the picture rather than in pixels",
        "duplicate-box": "boxes are repeated",
        "duplicate-track": "{many} of one frame share a track id",
        "box-disputed-by-both": "both systems agree on other boxes than the ground truth's",
        "loose-boxes": "many false alarms of a system lie on {many} {whom} it thereby misses",
        "missing-score": "some detections have no score and pass every threshold",
        "threshold-without-scores": "a threshold has no effect, as no detection has a score",
        "truth-every-nth-frame": "most evaluated frames have no ground truth",
        "detections-every-nth-frame": "a system has no detections in most evaluated frames",
        "detections-in-part-of-recording": "a system has detections in parts of recordings only",
        "recording-without-detections": "a system has no detections in whole recordings",
        "unknown-recording": "recordings without ground truth are left out",
        "frame-not-listed": "rows of frames that are not evaluated are left out",
    },
)
"""Of the core's own findings."""


@cache
def caveats() -> Caveats:
    """What findings mean for the verdict, those of subjects included."""
    every = (CAVEATS, *contributed("caveats"))
    return Caveats(
        warned=dict(chain(*(known.warned.items() for known in every))),
        lesser=dict(chain(*(known.lesser.items() for known in every))),
    )


SAME_BOXES: Final = "same-boxes"
WRONG_INPUTS: Final = (
    "Nothing is claimed: the audit found errors in the inputs, and the numbers are wrong until "
    "they are mended."
)
NO_TWO_SYSTEMS: Final = (
    "Two of the inputs have the same boxes: this is no comparison of two systems."
)


@dataclass(frozen=True)
class Point:
    """What the verdict says on one topic.

    Attributes
    ----------
    topic
        In a word or two, such as ``Encounters``.
    sentences
        At least one.
    after
        Topic of the point that it follows; empty: it has its own place.
    """

    topic: str
    sentences: tuple[str, ...]
    after: str = ""

    @property
    def key(self) -> str:
        """By which other points find it."""
        return self.topic

    @property
    def text(self) -> str:
        """The sentences, one after the other."""
        return " ".join(self.sentences)


@dataclass(frozen=True)
class PointOf:
    """A point that a subject adds.

    Attributes
    ----------
    topic
        In a word or two.
    describe
        Its sentences; none: there is nothing to say.
    after
        Topic of the point that it follows.
    """

    topic: str
    describe: Callable[[Result], tuple[str, ...]]
    after: str


@dataclass(frozen=True)
class Verdict:
    """What a comparison supports.

    Attributes
    ----------
    headline
        What is claimed, or that nothing is, and why; a sentence.
    points
        What it rests on, the most important first.
    claims
        Every difference that is called more than chance.
    basis
        The comparison that the claims are about.
    caveat
        What all this depends on, by the audit; empty: nothing.
    """

    headline: str
    points: tuple[Point, ...]
    claims: tuple[Claim, ...]
    basis: Basis
    caveat: str = ""

    @property
    def sentences(self) -> tuple[str, ...]:
        """Headline, points and caveat, sentence by sentence."""
        of_points = (sentence for point in self.points for sentence in point.sentences)
        return tuple(filter(None, (self.headline, *of_points, self.caveat)))


def verdict(
    result: Result,
    findings: Sequence[Finding] = (),
    *,
    evidence: pd.DataFrame | None = None,
    companions: Companions | None = None,
    plan: str = "",
) -> Verdict:
    """Which differences between X and Y may be claimed, and what the measures say.

    Where X and Y are set to different operating points the headline says so, and the points are
    about both at equal false alarms, if a threshold gives these. They tell who detects more
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
    >>> verdict(result).headline  # doctest: +SKIP
    'X is better in encounters detected: more than chance, by 12 recordings.'
    """
    serious = [
        finding
        for finding in findings
        if finding.severity is not Severity.NOTE and not finding.is_of_pictures
    ]
    caveat = _caveat(result, serious) if serious else ""
    if any(finding.code == SAME_BOXES for finding in findings):
        return Verdict(NO_TWO_SYSTEMS, (), (), Basis.NONE, caveat)
    if any(finding.severity is Severity.ERROR for finding in serious):
        return Verdict(WRONG_INPUTS, (), (), Basis.NONE, caveat)
    support = find_claims(result, evidence, companions)
    shown, of_shown = comparison_shown(result, evidence, companions)
    points = in_place(
        (
            Point("Operating points", describe_operating_points(result, companions)),
            Point("Encounters", describe_encounters(shown, of_shown, support)),
            Point("Severity", describe_weights(shown)),
            Point("Other measures", describe_measures(shown, of_shown)),
            Point("Chance", describe_chance(result, of_shown, support)),
            Point(
                "Strict pairing",
                () if companions is None else describe_strict(shown, companions.strict),
            ),
            Point("More recordings", (plan,) if plan else ()),
            Point("Thresholds", describe_thresholds(result) if shown is result else ()),
        ),
        (
            Point(of.topic, of.describe(shown), after=of.after)
            for of in chain(*contributed("points"))
        ),
    )
    return Verdict(
        headline(result, of_shown, companions, support),
        tuple(point for point in points if point.sentences),
        support.claims,
        support.basis,
        caveat,
    )


def _caveat(result: Result, serious: Sequence[Finding]) -> str:
    known = {**caveats().warned, **caveats().lesser}
    causes = list(
        dict.fromkeys(known[finding.code] for finding in serious if finding.code in known)
    )
    others = [finding.code for finding in serious if finding.code not in known]
    if others:
        causes.append(
            f"{len(others)} {'other ' if causes else ''}finding{'s' if len(others) > 1 else ''} "
            "that it lists"
        )
    return f"This depends on what the audit found: {result.objects.say('; '.join(causes))}."
