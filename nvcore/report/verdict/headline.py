"""The headline of the verdict: the strongest difference that the data support, or that none is."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import Claim, Support, find_within, least_corrected_p
from nvcore.evidence.companions import Companions
from nvcore.evidence.operating_points import are_unequal, has_scores
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.evidence.planning.noninferiority import UNEQUAL_POINTS
from nvcore.evidence.units import MIN_RECORDINGS, RECORDINGS
from nvcore.measures.table import count_recordings, evidence_form, inference_of, measure_of
from nvcore.report.verdict.words import shown_value
from nvcore.subjects import contributed
from nvcore.wording import capitalised, count_text, listed, p_text


def headline(
    result: Result,
    evidence: pd.DataFrame | None,
    companions: Companions | None,
    support: Support,
) -> str:
    """What is claimed, or that nothing is, and why.

    Parameters
    ----------
    evidence
        Of the comparison that claims are about; None where it supports none.
    """
    conclusion = _conclusion(result, evidence, companions, support)
    if not are_unequal(result):
        return capitalised(conclusion)
    if companions is None:
        why = "nothing is claimed before they are compared at equal false alarms"
    elif companions.equal is not None:
        return f"{UNEQUAL_POINTS}; at equal false alarms, {conclusion}"
    elif any(has_scores(result, letter) for letter in "xy"):
        why = "nothing is claimed, as no threshold sets them alike"
    else:
        why = "nothing is claimed, as without scores they cannot be set alike"
    return f"{UNEQUAL_POINTS}: {why}."


def _conclusion(
    result: Result,
    evidence: pd.DataFrame | None,
    companions: Companions | None,
    support: Support,
) -> str:
    """The headline without the operating points and without a capital."""
    if support.claims and evidence is not None:
        return _claimed(result, support.claims, evidence)
    if evidence is None:
        return "nothing is claimed: the differences are not tested."
    if companions is None and support.withheld:
        return "nothing is claimed before X and Y are compared at equal false alarms."
    if (evidence["unit"] != RECORDINGS).all():
        n = count_recordings(result)
        few = "one recording does" if n == 1 else f"{n} recordings do"
        why = f"{few} not show what others would ({MIN_RECORDINGS} are needed)."
        within = find_within(result, evidence, companions)
        if not within:
            return f"nothing is claimed: {why}"
        where = "this recording" if n == 1 else f"these {n} recordings"
        better = _better_text(result, within, evidence, n_with_values=len(within))
        better += _remarks(result, within)
        return f"within {where} {better}; nothing is claimed of others: {why}"
    tested = evidence[np.isfinite(evidence["p_holm"])]
    if tested.empty:
        return "nothing is claimed: there are too few data to test a difference."
    by = f"by {count_text(int(tested['n'].max()), 'recording')}"
    least_p = least_corrected_p(evidence)
    if least_p > SIGNIFICANT:
        return (
            f"nothing is claimed: {by} and in {len(tested)} measures no difference can be shown to "
            "be more than chance, however large (the least possible "
            f"{p_text(least_p / len(tested), least_p, len(tested))})."
        )
    if support.withheld:
        return "nothing is claimed: each difference that is more than chance fails another check."
    return f"nothing is claimed: {by}, no difference is shown to be more than chance."


def _claimed(result: Result, claims: Sequence[Claim], evidence: pd.DataFrame) -> str:
    """Who is better in what, the strongest difference first and with its values."""
    ranked = sorted(claims, key=lambda claim: claim.p)  # those alike in the table's order
    by = count_text(max(claim.n for claim in claims), "recording")
    better = _better_text(result, ranked, evidence, n_with_values=1)
    return f"{better}: more than chance, by {by}{_remarks(result, claims)}."


def _remarks(result: Result, claims: Sequence[Claim]) -> str:
    """What subjects say of claims about these measures; empty: nothing."""
    measures = [measure_of(claim.key) for claim in claims]
    return "".join(remarks.of_claims(result, measures) for remarks in contributed("remarks"))


def _better_text(
    result: Result, claims: Sequence[Claim], evidence: pd.DataFrame, *, n_with_values: int
) -> str:
    """Who is better in what, each system once, the first differences with their values."""
    of_key = {row["figure"]: row for row in evidence.to_dict("records")}
    with_values = {claim.key for claim in claims[:n_with_values]}
    parts: list[str] = []
    for letter in dict.fromkeys(claim.winner for claim in claims):
        nouns = [
            result.objects.say(inference_of(claim.key).noun)
            + (f" ({_values_text(of_key[claim.key], letter)})" if claim.key in with_values else "")
            for claim in claims
            if claim.winner == letter
        ]
        better = "" if parts else "is better "
        parts.append(f"{letter.upper()} {better}in {listed(nouns)}")
    return ", ".join(parts)


def _values_text(row: Mapping[Hashable, Any], winner: str) -> str:
    """The better value and the other, such as "12.0 to 31.0 per hour"."""
    key = str(row["figure"])
    values = [shown_value(float(row[letter]), evidence_form(key)) for letter in "xy"]
    better, other = values if winner == "x" else values[::-1]
    return f"{better} to {other}{inference_of(key).noun_unit}"
