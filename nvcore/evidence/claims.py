"""Differences that may be claimed: beyond chance, and not explained by a choice of settings."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Final

import numpy as np
import pandas as pd
import scipy

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import EVIDENCE_KEYS, inference_of, measure_of
from nvcore.evidence.bootstrap import CONFIDENCE
from nvcore.evidence.companions import Companions
from nvcore.evidence.operating_points import are_delivered, are_unequal, count_alarms, has_scores
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.units import WHOLE, Units, find_units
from nvcore.notes import Note

CLAIMED: Final = tuple(key for key in EVIDENCE_KEYS if inference_of(key).noun)
"""Keys of the measures whose differences the verdict may claim."""
FALSE_ALERTS: Final = "false_alert_episodes_per_hour"
MIN_ALARMS: Final = 8
"""Fewest false alarms of the other system that say anything about a ratio to them."""
ALARM_MARGIN: Final = 1.25
"""Delivered systems: most false alarms of the better one, as a multiple of the other's."""


class Basis(StrEnum):
    """Comparison that the verdict is about."""

    AS_SET = "as set"
    EQUAL_ALARMS = "equal false alarms"
    NONE = "none"


@dataclass(frozen=True)
class Claim:
    """Difference that is more than chance.

    Attributes
    ----------
    key
        Key of the measure.
    winner
        The better system, ``x`` or ``y``.
    p
        `p_corrected` of the evidence; NaN within a few recordings.
    n
        Number of recordings, units or blocks of time behind it.
    """

    key: str
    winner: str
    p: float
    n: int


@dataclass(frozen=True)
class Support:
    """Conclusions that the evidence supports.

    Attributes
    ----------
    basis
        Comparison that the claims are about. ``none``: nothing can be claimed.
    claims
        In the order of the table.
    withheld
        Reasons for not claiming a difference with a small enough p, by the measure's key.
    """

    basis: Basis
    claims: tuple[Claim, ...] = ()
    withheld: Mapping[str, Note] = field(default_factory=dict)


def find_claims(
    result: Result, evidence: pd.DataFrame | None, companions: Companions | None
) -> Support:
    """Return the differences between X and Y that may be claimed.

    A claim needs a small `p_corrected` (p itself for the primary measure) over at least six
    recordings or units. It must not depend on the operating points: if X and Y have unequal false
    alarms, the claim is about the comparison at equal false alarms. Otherwise it must hold there,
    too. Strict pairing must not reverse it. If the thresholds are delivered ones,
    it is about these, and the better system must not have clearly more false alarms. Nothing is
    claimed until the companions are known.

    Parameters
    ----------
    evidence
        `nvcore.evidence.table.evidence_table` of the result; None: not tested.
    companions
        `nvcore.evidence.companions.find_companions` of the result; None: not yet known.
    """
    about, tested = decided_on(result, evidence, companions)
    if are_unequal(about):
        return Support(Basis.NONE)
    is_as_set = about is result and result.as_set is None
    basis = Basis.AS_SET if is_as_set else Basis.EQUAL_ALARMS
    if tested is None:
        return Support(basis)
    rows = _significant_rows(tested)
    doubts, candidates = _doubts(rows), _candidates(about, rows)
    if companions is None:
        withheld = dict.fromkeys(
            candidates, Note("verdict.not_yet_compared", is_delivered=are_delivered(result))
        )
        return Support(basis, withheld=withheld | doubts)
    withheld = _not_confirmed(result, candidates, companions) if is_as_set else {}
    for key in candidates:
        if is_turned_strictly(key, about, companions.strict):
            withheld[key] = Note("verdict.turned_strictly")
    claims = tuple(claim for key, claim in candidates.items() if key not in withheld)
    return Support(basis, claims, withheld | doubts)


def decided_on(
    result: Result, evidence: pd.DataFrame | None, companions: Companions | None
) -> tuple[Result, pd.DataFrame | None]:
    """Return the comparison on which claims are based, and its evidence if known.

    At unequal operating points this is the comparison at equal false alarms.
    """
    if not are_unequal(result):
        return result, evidence
    if companions is None or companions.equal is None:
        return result, None
    return companions.equal, companions.evidence


def find_within(
    result: Result, evidence: pd.DataFrame, companions: Companions | None
) -> tuple[Claim, ...]:
    """Return differences that are clear within a few recordings, the clearest first.

    Their intervals exclude 0 even after Bonferroni's correction for the number of intervals. Like
    all claims, they need the companions and must survive equal false alarms and strict pairing. If
    no threshold gives equal false alarms, the better system must not have more of them.
    """
    if companions is None or result.as_set is not None or are_unequal(result):
        return ()
    rows = evidence[
        evidence["figure"].isin(CLAIMED)
        & np.isfinite(evidence["low"])
        & np.isfinite(evidence["high"])
    ].to_dict("records")
    clearness, claims = {}, {}
    for row in rows:
        key, n, apart = str(row["figure"]), int(row["n"]), float(row["difference"])
        if row["doubt"] or n < 2 or (result.is_short and inference_of(key).needs_tracks):
            continue
        to_zero = apart - float(row["low"]) if apart > 0 else float(row["high"]) - apart
        if abs(apart) > to_zero * _widening(n, len(rows)):
            winner = winner_of(apart, row["better"])
            clearness[key] = abs(apart) / to_zero if to_zero > 0 else np.inf
            claims[key] = Claim(key, winner, np.nan, n)
    equal, strict = companions.equal, companions.strict
    withheld = set(_not_dominant(result, claims)) if equal is None else set()
    if equal is not None:
        withheld |= {key for key in claims if measure_of(key).of and is_turned(key, result, equal)}
    withheld |= {key for key in claims if is_turned_strictly(key, result, strict)}
    ranked = sorted(claims.values(), key=lambda claim: -clearness[claim.key])
    return tuple(claim for claim in ranked if claim.key not in withheld)


def _widening(n: int, n_intervals: int) -> float:
    """Return the factor by which Bonferroni's correction widens each of `n_intervals` intervals."""
    alpha = (1 - CONFIDENCE) / 2
    return float(
        scipy.special.stdtrit(n - 1, alpha / n_intervals) / scipy.special.stdtrit(n - 1, alpha)
    )


def _candidates(result: Result, rows: Sequence[Mapping[Hashable, Any]]) -> dict[str, Claim]:
    """Return claims for significant differences that are not in doubt, by measure key."""
    claims = {}
    for row in rows:
        key = str(row["figure"])
        if row["doubt"] or (result.is_short and inference_of(key).needs_tracks):
            continue
        winner = winner_of(row["difference"], row["better"])
        claims[key] = Claim(key, winner, float(row["p_corrected"]), int(row["n"]))
    return claims


def _doubts(rows: Sequence[Mapping[Hashable, Any]]) -> dict[str, Note]:
    """Return why significant differences are in doubt, by measure key."""
    return {
        str(row["figure"]): Note("verdict.doubted", doubt=str(row["doubt"]))
        for row in rows
        if row["doubt"]
    }


def _significant_rows(evidence: pd.DataFrame) -> list[dict[Hashable, Any]]:
    """Return rows of measures that may be claimed and are significant over recordings."""
    small = evidence[evidence["p_corrected"] <= SIGNIFICANT]
    rows = [] if small.empty else small.to_dict("records")  # slow even if empty
    return [row for row in rows if row["unit"] in WHOLE and row["figure"] in CLAIMED]


def winner_of(difference: float, better: str) -> str:
    """Return the system, ``x`` or ``y``, that a difference X - Y favours."""
    return "x" if (difference > 0) == (better == "higher") else "y"


def _not_confirmed(
    result: Result, candidates: Mapping[str, Claim], companions: Companions
) -> dict[str, Note]:
    """Return why candidate claims fail at equal false alarms, by measure key."""
    if companions.evidence is None:
        return _not_dominant(result, candidates)
    confirmed = _candidates(result, _significant_rows(companions.evidence))
    return {
        key: Note("verdict.not_at_equal")
        for key, claim in candidates.items()
        if key not in confirmed or confirmed[key].winner != claim.winner
    }


def _worse_alarms(result: Result, candidates: Mapping[str, Claim]) -> dict[str, Note]:
    """Return why claims fail for delivered thresholds: the better system may alarm more."""
    note, units = Note("verdict.worse_alarms", margin=ALARM_MARGIN), find_units(result)
    is_worse = {of: alarm_ratio_limit(result, units, of) > ALARM_MARGIN for of in "xy"}
    reasons = {}
    for key, claim in candidates.items():
        if is_worse[claim.winner]:
            reasons[key] = note
        elif key == FALSE_ALERTS and _matches_fewer(result, claim.winner):
            reasons[key] = Note("verdict.fewer_matches", winner=claim.winner)
    return reasons


def _matches_fewer(result: Result, letter: str) -> bool:
    """Return whether a system matches fewer boxes than the other one."""
    n_matched = [int(system.matched.sum()) for _, system in result.sides]
    return n_matched["xy".index(letter)] < max(n_matched)


def alarm_ratio_limit(result: Result, units: Units, of: str) -> float:
    """Return the upper end of the 95 % interval of a system's false alarms over the other's.

    The interval is that of the logarithm of the ratio, by its linear part (delta method), with
    Student's t. Infinite if the other system has fewer than `MIN_ALARMS`.
    """
    own, other = (
        units.total(units.unit_of_frame, result.system(letter).false_alarms)
        for letter in (of, "y" if of == "x" else "x")
    )
    n, n_own, n_other = len(units), float(own.sum()), float(other.sum())
    if not n_own or n_other < MIN_ALARMS:
        return 0.0 if n_other >= MIN_ALARMS else np.inf
    parts = own / n_own - other / n_other
    error = np.sqrt(n / (n - 1) * (parts**2).sum())
    quantile = scipy.special.stdtrit(n - 1, (1 + CONFIDENCE) / 2)
    return float(n_own / n_other * np.exp(quantile * error))


def _not_dominant(result: Result, candidates: Mapping[str, Claim]) -> dict[str, Note]:
    """Return reasons against claims that an unequal operating point may explain, by measure key."""
    if are_delivered(result):
        return _worse_alarms(result, candidates)
    reasons = {}
    n_alarms = {letter: count_alarms(system) for letter, system in result.sides}
    can_move = any(has_scores(result, letter) for letter in n_alarms)
    for key, claim in candidates.items():
        winner, other = claim.winner, "y" if claim.winner == "x" else "x"
        if key == FALSE_ALERTS:
            of, is_owed = "matches", _matches_fewer(result, winner)
        else:
            of, is_owed = "alarms", n_alarms[winner] > n_alarms[other]
        if is_owed:
            reasons[key] = Note("verdict.not_dominant", of=of, winner=winner, has_scores=can_move)
    return reasons


def is_turned(key: str, result: Result, other: Result) -> bool:
    """Return whether a measure favours opposite systems in two comparisons."""
    differences = (np.subtract(*values_of(key, each)) for each in (result, other))
    return bool(np.prod(np.sign([*differences])) < 0)


def is_turned_strictly(key: str, result: Result, strict: Result) -> bool:
    """Return whether strict pairing makes a measure favour the other system."""
    return measure_of(key).depends_on("pairing") and is_turned(key, result, strict)


def values_of(key: str, result: Result) -> tuple[float, float]:
    """Return the values of a measure for X and Y, NaN if undefined.

    `key` is one of `nvcore.comparison.measures.table.MEASURES`.
    """
    value_of = measure_of(key).of
    assert value_of is not None, key
    return float(value_of(result, result.x)), float(value_of(result, result.y))


def has_primary(evidence: pd.DataFrame, key: str) -> bool:
    """Return whether the table has a p-value for the primary measure, `key`."""
    return bool((np.isfinite(evidence["p_corrected"]) & (evidence["figure"] == key)).any())
