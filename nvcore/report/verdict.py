"""What a comparison supports, in sentences that claim no more than its measures show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import Basis, Claim, Support, find_claims, least_corrected_p
from nvcore.evidence.companions import Companions, are_unequal, count_alarms, has_scores
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.findings import Finding, Severity
from nvcore.report.verdict_words import (
    describe_chance,
    describe_encounters,
    describe_side_by_side,
    describe_strict,
    describe_weights,
)
from nvcore.wording import listed

CAVEATS: Final = {
    "track-reused": "track ids of the ground truth are used again after a gap, so that two persons "
    "may be taken for one encounter",
    "short-encounters": "most encounters are one frame long, so that counts of them are counts of "
    "frames rather than persons, and saliency and episodes mean little",
    "score-floors": "X and Y are compared at different operating points; with thresholds the "
    "other may come out better",
    "mixed-weighting": "X and Y are weighted by different rules",
    "same-boxes": "two of the inputs have the same boxes",
    "size-too-large": "the image size seems wrong",
    "implausible-fps": "the frame rate seems wrong",
    "time-offset": "a system seems to be off in time",
    "pixel-offset": "a system's boxes seem to be displaced",
    "scale-mismatch": "a system's boxes seem to be of another resolution",
    "frames-beyond-boxes": "frames without any box are evaluated",
    "no-detections": "a system has no detections",
    "threshold-keeps-nothing": "a threshold leaves no detection",
}
"""What a finding of the audit means for the verdict, by its code."""

SAME_BOXES: Final = "same-boxes"


@dataclass(frozen=True)
class Verdict:
    """What a comparison supports.

    Attributes
    ----------
    sentences
        In words, the most important first.
    claims
        Every difference that the sentences call more than chance.
    basis
        The comparison that the claims are about.
    caveat
        What all this depends on, by the audit; the last of the sentences; empty: nothing.
    """

    sentences: tuple[str, ...]
    claims: tuple[Claim, ...]
    basis: Basis
    caveat: str = ""


def verdict(
    result: Result,
    findings: Sequence[Finding] = (),
    *,
    evidence: pd.DataFrame | None = None,
    companions: Companions | None = None,
    plan: str = "",
) -> Verdict:
    """Which system detects more pedestrians, and what the other measures say.

    Where X and Y are set to different operating points, the first sentence says so, and all others
    are about both at equal false alarms. Then come: who detects more encounters, what the failures
    weigh, the other measures side by side and which of their differences are more than chance,
    where strict pairing disagrees, and the warnings and errors of the audit that all this depends
    on. X and Y are called ``X`` and ``Y``; the worst failure is named by its recording and track.

    Parameters
    ----------
    findings
        Of the audit of the same inputs.
    evidence
        `nvcore.evidence.table.evidence_table` of the result; None: the text says that the
        differences are not tested.
    companions
        `nvcore.evidence.companions.find_companions` of the result; None: not yet known, and nothing
        is claimed.
    plan
        `nvcore.report.plan.verdict_plan` of the result: how many more recordings it would take.

    Notes
    -----
    Without a near encounter the sentence about encounters says that there is none; a measure that
    is undefined for a system is left out.

    Examples
    --------
    >>> print(" ".join(verdict(result).sentences))  # doctest: +SKIP
    X detects every encounter that Y detects, and 9 more of 40 (by 12 recordings, p = 0.0039).
    """
    is_same = any(finding.code == SAME_BOXES for finding in findings)
    support = Support(Basis.NONE) if is_same else find_claims(result, evidence, companions)
    sentences = [_operating_points(result, companions)] if not is_same else []
    if is_same:
        sentences.append(
            "Two of the inputs have the same boxes: this is no comparison of two systems."
        )
    shown, of_shown, before = result, evidence, ""
    if support.basis is Basis.EQUAL_ALARMS and companions is not None:
        assert companions.equal is not None
        shown, of_shown = companions.equal, companions.evidence[0]
        before = f"At equal false alarms ({_threshold_text(companions)}) "
    elif are_unequal(result):
        of_shown = None
        before = "As set, "
    if not is_same:
        sentences.append(_after(before, describe_encounters(shown, of_shown, support)))
    sentences.append(describe_weights(shown))
    side_by_side = describe_side_by_side(shown, of_shown)
    if side_by_side:
        chance = describe_chance(of_shown, support, short=result.is_short)
        again = before.split("(")[0] if "(" in before else before
        sentences.append(f"{_after(again, side_by_side)}; {chance}.")
    if companions is not None and not is_same:
        sentences.append(describe_strict(shown, companions.strict))
    sentences += [_least_p(of_shown), "" if is_same else plan]
    sentences.append(_without_threshold(result))
    serious = [finding for finding in findings if finding.severity is not Severity.NOTE]
    caveat = _caveat(serious) if serious else ""
    told = tuple(sentence for sentence in (*sentences, caveat) if sentence)
    return Verdict(told, support.claims, support.basis, caveat)


def _after(before: str, sentence: str) -> str:
    """A sentence after words that begin it; X and Y keep their capitals."""
    if not before:
        return sentence
    is_name = sentence[:2] in ("X ", "Y ")
    return before + (sentence if is_name else sentence[0].lower() + sentence[1:])


def _operating_points(result: Result, companions: Companions | None) -> str:
    """That X and Y are set to different operating points, if they are."""
    n_frames = len(result.dataset.frames)
    if not are_unequal(result):
        return ""
    rates = [f"{count_alarms(system) / n_frames:.3g}" for _, system in result.sides]
    text = (
        "X and Y are set to different operating points "
        f"({rates[0]} and {rates[1]} false alarms per frame)"
    )
    if companions is None:
        return f"{text}: nothing is claimed before they are compared at equal false alarms."
    if companions.equal is not None:
        return f"{text}: nothing is claimed from the comparison as set."
    if not any(has_scores(result, letter) for letter in "xy"):
        return f"{text}, and without scores they cannot be set alike: nothing is claimed."
    return f"{text}, and no threshold sets them alike: nothing is claimed."


def _threshold_text(companions: Companions) -> str:
    assert companions.equal is not None
    equal, moved = companions.equal, companions.moved
    per_frame = count_alarms(equal.x) / len(equal.dataset.frames)
    threshold = equal.system(moved).threshold
    at = "with all detections" if threshold is None else f"with scores of {threshold:g} or more"
    return f"{moved.upper()} {at}, {per_frame:.3g} per frame"


def _least_p(evidence: pd.DataFrame | None) -> str:
    """That no difference could come out as more than chance with so few recordings, if so."""
    if evidence is None:
        return ""
    least_p = least_corrected_p(evidence)
    if not least_p > SIGNIFICANT:
        return ""
    tested = evidence[np.isfinite(evidence["p_holm"])]
    return (
        f"With {int(tested['n'].max())} recordings and {len(tested)} measures no difference can be "
        f"shown to be more than chance, however large: the least p is {least_p:.2g} after "
        "correction."
    )


def _caveat(serious: Sequence[Finding]) -> str:
    causes = list(
        dict.fromkeys(CAVEATS[finding.code] for finding in serious if finding.code in CAVEATS)
    )
    others = [finding.code for finding in serious if finding.code not in CAVEATS]
    if others:
        causes.append(
            f"{len(others)} {'other ' if causes else ''}finding{'s' if len(others) > 1 else ''} "
            "that it lists"
        )
    return f"This depends on what the audit found: {'; '.join(causes)}."


def _without_threshold(result: Result) -> str:
    """Which systems have scores but no threshold."""
    letters = [
        letter.upper()
        for letter, system in result.sides
        if system.threshold is None and has_scores(result, letter)
    ]
    if not letters:
        return ""
    return f"Every detection of {listed(letters)} counts, however low its score."
