"""Headline of the verdict: the strongest difference that the data support, if there is one."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
import pandas as pd

from nvcore.comparison.compare import Result
from nvcore.comparison.measures.table import evidence_form, measure_of, shown_as
from nvcore.evidence.claims import Claim, Support, find_within, has_primary
from nvcore.evidence.companions import Companions, is_unsure
from nvcore.evidence.measures import primary_of
from nvcore.evidence.operating_points import are_delivered, are_unequal, has_scores
from nvcore.evidence.units import MIN_RECORDINGS, WHOLE, count_whole
from nvcore.notes import Note
from nvcore.report.remarks import all_remarks


def headline(
    result: Result, evidence: pd.DataFrame | None, companions: Companions | None, support: Support
) -> Note:
    """Return the claim with its reason, or why nothing is claimed.

    Parameters
    ----------
    evidence
        Table of evidence of the comparison that claims are about; None if it supports no claim.
    """
    conclusion = _conclusion(result, evidence, companions, support)
    if are_delivered(result):
        return Note("verdict.as_delivered", conclusion=conclusion)
    is_unequal = result.as_set is None and are_unequal(result)
    if result.as_set is None and not is_unequal:
        return Note("verdict.as_set", conclusion=conclusion)
    if is_unequal and companions is None:
        return Note("verdict.not_yet_equal")
    if not is_unequal or (companions is not None and companions.equal is not None):
        return Note("verdict.at_equal_alarms", conclusion=conclusion)
    can_move = any(has_scores(result, letter) for letter in "xy")
    return Note("verdict.no_threshold") if can_move else Note("verdict.no_scores")


def _conclusion(
    result: Result, evidence: pd.DataFrame | None, companions: Companions | None, support: Support
) -> Note:
    if evidence is None:
        return Note("verdict.untested")
    n, noun = count_whole(result.dataset)
    if support.claims:
        ranked = sorted(support.claims, key=lambda claim: claim.p)  # ties keep the table's order
        return Note(
            "verdict.claimed",
            n=max(claim.n for claim in support.claims),
            noun=noun,
            better=_better(result, ranked, evidence, 0 if are_unequal(result) else 1),
            remarks=_remarks(result, support.claims),
        )
    if companions is None and support.withheld:
        return Note("verdict.pending", is_delivered=are_delivered(result))
    if not evidence["unit"].isin(WHOLE).any():
        within = find_within(result, evidence, companions)
        extent: dict[str, Any] = {"n": n, "noun": noun, "n_needed": MIN_RECORDINGS}
        if not within:
            return Note("verdict.few", **extent)
        better = _better(result, within, evidence, len(within))
        return Note("verdict.within", **extent, better=better, remarks=_remarks(result, within))
    if is_unsure(evidence):
        return Note("verdict.unsure")
    if not np.isfinite(evidence["p_corrected"]).any():
        return Note("verdict.untestable")
    if support.withheld:
        return Note("verdict.withheld")
    n = int(evidence["n"][np.isfinite(evidence["p_corrected"])].max())
    primary = primary_of(result.dataset)
    is_of_all = primary.is_changed or not has_primary(evidence, primary.key)
    named = None if is_of_all else Note("verdict.measure", key=primary.key)
    return Note("verdict.not_shown", n=n, noun=noun, primary=named)


def _remarks(result: Result, claims: Sequence[Claim]) -> list[Note]:
    """Return what subjects add to claims about their measures."""
    measures = [measure_of(claim.key) for claim in claims]
    remarks = (known.of_claims(result, measures) for known in all_remarks())
    return [remark for remark in remarks if remark is not None]


def _better(
    result: Result, claims: Sequence[Claim], evidence: pd.DataFrame, n_with_values: int
) -> list[Note]:
    """Say in which measures each system is better, giving values for the first `n_with_values`."""
    of_key = {row["figure"]: row for row in evidence.to_dict("records")}
    first_winner = claims[0].winner if claims else ""
    with_values = {claim.key for claim in claims[:n_with_values]}

    def measure(claim: Claim) -> Note:
        key, row = claim.key, of_key[claim.key]
        if key not in with_values:
            return Note("verdict.measure", key=key)
        x, y = float(row["x"]), float(row["y"])
        better, other = (x, y) if claim.winner == "x" else (y, x)
        form, (_, unit) = evidence_form(key), shown_as(key, result)
        return Note("verdict.measure", key=key, better=better, other=other, form=form, unit=unit)

    by_winner = sorted(claims, key=lambda claim: claim.winner != first_winner)
    return [
        Note("verdict.better", winner=winner, measures=[measure(claim) for claim in of_winner])
        for winner, of_winner in groupby(by_winner, key=lambda claim: claim.winner)
    ]
