"""Non-inferiority of the candidate within a margin, over recordings only."""

from __future__ import annotations

import math
from dataclasses import dataclass

from nvcore.arguments.plan import Side
from nvcore.evidence.measures import Evidence
from nvcore.evidence.units import WHOLE
from nvcore.measures.entry import Better


@dataclass(frozen=True)
class NonInferiority:
    """Result of testing that a system is at most a margin worse than the other.

    Attributes
    ----------
    candidate
        System that is preferred for other reasons, such as its price: ``x`` or ``y``.
    margin
        Largest acceptable loss, in the unit of the measure (shares: 0 to 1).
    worse
        Loss in these recordings. Negative: the candidate is better.
    worse_at_most
        Unfavourable end of the 95 % interval: largest loss with other recordings, at 97.5 %. NaN
        without an interval.
    is_shown
        True if `worse_at_most` is less than the margin. None if it cannot be determined.
    reason
        Reason if it cannot be determined, else empty.
    """

    candidate: Side
    margin: float
    worse: float
    worse_at_most: float
    is_shown: bool | None
    reason: str


def favour(candidate: Side, better: Better) -> int:
    """Return 1 if a positive difference X - Y favours the candidate, else -1."""
    return 1 if (candidate == "x") == (better == "higher") else -1


def worse_at_most(evidence: Evidence, candidate: Side) -> float:
    """Return the candidate's largest loss within the 95 % interval of the difference.

    Positive is worse. NaN without an interval, or if the evidence is about blocks of time.
    """
    if evidence.unit not in WHOLE:
        return math.nan
    sign = favour(candidate, evidence.better)
    return -sign * (evidence.low if sign > 0 else evidence.high)


def judge_noninferiority(
    evidence: Evidence, candidate: Side, margin: float, *, is_undecided: bool = False
) -> NonInferiority:
    """Compare the margin with the confidence interval of a difference.

    It is shown if the whole 95 % interval of the difference is on the better side of the margin: a
    one-sided test at 2.5 %. Blocks of time show nothing, as they do not represent other recordings.

    Parameters
    ----------
    is_undecided
        Value of `nvcore.evidence.operating_points.is_undecided` for the comparison and measure.
        Unequal operating points show nothing.

    Examples
    --------
    >>> row = Evidence(figure="mean_similarity", label="", better="higher", n=20, note="",
    ...     unit="recordings", difference=0.01, low=-0.01, high=0.02)
    >>> judge_noninferiority(row, "y", 0.03).is_shown  # Y is at most 0.02 worse
    True
    >>> judge_noninferiority(row, "y", 0.015).is_shown
    False
    """
    end = math.nan if is_undecided else worse_at_most(evidence, candidate)
    reason = ""
    if is_undecided:
        reason = "X and Y are set to different operating points"
    elif evidence.unit not in WHOLE:
        reason = "stretches of time say nothing of other recordings"
    elif evidence.doubt:
        reason = evidence.doubt
    elif math.isnan(end):
        reason = evidence.note or "the difference has no interval"
    return NonInferiority(
        candidate=candidate,
        margin=margin,
        worse=-favour(candidate, evidence.better) * evidence.difference,
        worse_at_most=end,
        is_shown=None if reason else end < margin,
        reason=reason,
    )
