"""Notes on a comparison of groups: results of the tests, and cautions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
import pandas as pd

from nvcore.arguments.groups import GroupArguments
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.group_statistics.text import PAIR_TESTS, TESTS, amount_form
from nvcore.notes import Note

if TYPE_CHECKING:
    from nvcore.group_statistics.comparison import GroupComparison

SMALL: Final = 6
"""Groups with fewer values or persons than this are compared by permutation."""


def results(comparison: GroupComparison) -> list[Note]:
    """Return notes on the results of the suitable tests."""
    names = comparison.groups["condition"]
    if len(names) < 2:
        reason = "there is one condition alone" if len(names) else "there is no value"
        return [Note("groups.untested", reason=reason)]
    if not comparison.fits:
        return []
    test = comparison.tests[comparison.tests["fits"]].iloc[0]
    p = float(test["p"])
    if np.isnan(p):
        return [Note("groups.untested", reason=test["reason"])]
    label = TESTS[comparison.fits]
    notes = [Note("groups.differ", is_shown=p <= SIGNIFICANT, test=label, p=p)]
    if len(names) > 2:
        form = amount_form(comparison.groups["mean"].to_numpy())
        shown = comparison.pairs[comparison.pairs["fits"]]
        shown = shown[shown["p_corrected"] <= SIGNIFICANT]
        apart = [_pair(row, form) for _, row in shown.iterrows()]
        notes.append(Note("groups.pairs", test=PAIR_TESTS[comparison.fits_pairs], pairs=apart))
    return notes


def _pair(pair: pd.Series, form: str) -> Note:
    """Return a note on two conditions that differ, the larger first."""
    is_ratio = not np.isnan(pair["ratio"])
    size = float(np.log(pair["ratio"]) if is_ratio else pair["difference"])
    first, second = ("first", "second") if size >= 0 else ("second", "first")
    return Note(
        "groups.pair",
        first=pair[first],
        second=pair[second],
        ratio=float(np.exp(abs(size))) if is_ratio else None,
        amount=None if is_ratio else abs(size),
        form=form,
        p=pair["p_corrected"],
    )


def cautions(comparison: GroupComparison, asked: GroupArguments) -> list[Note]:
    """Return notes with cautions about the results, and on the size of a further study."""
    notes = []
    fitting = comparison.tests[comparison.tests["fits"]]
    for n_ways in fitting.loc[fitting["is_exact"], "n_ways"]:
        if 1 / n_ways > SIGNIFICANT:
            notes.append(Note("groups.least_p", p=1 / n_ways))
    checks = comparison.assumptions
    for p in checks.loc[(checks["check"] == "shapiro") & (checks["holds"] == 0), "p"]:
        if not fitting["n_ways"].any():
            notes.append(Note("groups.skewed", p=p))
    if not comparison.measure and comparison.fits:
        notes.append(Note("groups.summaries_alone"))
        if (n := int(comparison.groups["n"].min())) < SMALL:
            notes.append(Note("groups.few_summaries", n=n))
        if asked.correlation is not None:
            notes.append(Note("groups.assumed_correlation"))
    known = comparison.sizes.dropna(subset="effect")
    for n_needed in known.loc[known["test"] == "t", "n"]:
        n_persons = None if np.isnan(n_needed) else int(n_needed)
        if asked.difference is not None:
            study = {"power": asked.power, "n": n_persons, "is_within": comparison.design == "same"}
            notes.append(Note("groups.further_study", difference=asked.difference, **study))
        elif n_persons is not None:
            notes.append(Note("groups.optimistic"))
    return notes
