"""The headline of the verdict: the strongest difference that the data support, or that none is."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
import pandas as pd

from nvcore.comparison import Result
from nvcore.evidence.claims import Claim, Support, find_within, has_primary
from nvcore.evidence.companions import Companions, is_unsure
from nvcore.evidence.measures import primary_of
from nvcore.evidence.operating_points import are_unequal, has_scores
from nvcore.evidence.units import MIN_RECORDINGS, WHOLE, count_whole
from nvcore.measures.table import evidence_form, measure_of, shown_as
from nvcore.sentences.facts import Amount, Better, BetterMeasure, Conclusion, Fact, Headline, Named
from nvcore.subjects import contributed


def headline(
    result: Result,
    evidence: pd.DataFrame | None,
    companions: Companions | None,
    support: Support,
) -> Headline:
    """What is claimed, or that nothing is, and why.

    Parameters
    ----------
    evidence
        Of the comparison that claims are about; None where it supports none.
    """
    conclusion = _conclusion(result, evidence, companions, support)
    if result.as_set is not None:
        return Headline("equal", conclusion)
    if not are_unequal(result):
        return Headline("alike", conclusion)
    if companions is None:
        return Headline("pending")
    if companions.equal is not None:
        return Headline("equal", conclusion)
    return Headline("threshold" if any(has_scores(result, letter) for letter in "xy") else "scores")


def _conclusion(
    result: Result,
    evidence: pd.DataFrame | None,
    companions: Companions | None,
    support: Support,
) -> Conclusion:
    if evidence is None:
        return Conclusion("untested")
    n, noun = count_whole(result.dataset)
    if support.claims:
        ranked = sorted(support.claims, key=lambda claim: claim.p)  # those alike in table's order
        return Conclusion(
            "claimed",
            n_recordings=max(claim.n for claim in support.claims),
            noun=noun,
            better=_better(result, ranked, evidence, 0 if are_unequal(result) else 1),
            remarks=_remarks(result, support.claims),
        )
    if companions is None and support.withheld:
        return Conclusion("pending")
    if not evidence["unit"].isin(WHOLE).any():
        within = find_within(result, evidence, companions)
        return Conclusion(
            "within" if within else "few",
            n_recordings=n,
            noun=noun,
            n_needed=MIN_RECORDINGS,
            better=_better(result, within, evidence, len(within)),
            remarks=_remarks(result, within),
        )
    if is_unsure(evidence):
        return Conclusion("unsure")
    if not np.isfinite(evidence["p_corrected"]).any():
        return Conclusion("untestable")
    n = int(evidence["n"][np.isfinite(evidence["p_corrected"])].max())
    if support.withheld:
        return Conclusion("withheld", n_recordings=n, noun=noun)
    primary = primary_of(result.dataset)
    if primary.is_changed or not has_primary(evidence, primary.key):
        return Conclusion("not shown", n_recordings=n, noun=noun)
    return Conclusion("primary not shown", n_recordings=n, noun=noun, primary=Named(primary.key))


def _remarks(result: Result, claims: Sequence[Claim]) -> tuple[Fact, ...]:
    """What subjects say of claims about these measures."""
    measures = [measure_of(claim.key) for claim in claims]
    remarks = (subject.of_claims(result, measures) for subject in contributed("remarks"))
    return tuple(remark for remark in remarks if remark is not None)


def _better(
    result: Result, claims: Sequence[Claim], evidence: pd.DataFrame, n_with_values: int
) -> tuple[Better, ...]:
    """In what each system is better, the first differences with their values."""
    of_key = {row["figure"]: row for row in evidence.to_dict("records")}
    first_winner = claims[0].winner if claims else ""
    with_values = {claim.key for claim in claims[:n_with_values]}

    def named(claim: Claim) -> Named:
        key, row = claim.key, of_key[claim.key]
        if key not in with_values:
            return Named(key)
        form, (_, unit) = evidence_form(key), shown_as(key, result)
        x, y = (Amount(float(row[letter]), form, unit) for letter in "xy")
        return BetterMeasure(key, x, y) if claim.winner == "x" else BetterMeasure(key, y, x)

    by_winner = sorted(claims, key=lambda claim: claim.winner != first_winner)
    return tuple(
        Better(winner, tuple(map(named, of_winner)))
        for winner, of_winner in groupby(by_winner, key=lambda claim: claim.winner)
    )
