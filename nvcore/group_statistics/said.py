"""What a comparison of groups has to say, as facts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal

import numpy as np
import pandas as pd

from nvcore.arguments.groups import GroupArguments
from nvcore.evidence.paired_tests import SIGNIFICANT
from nvcore.group_statistics.text import amount_form
from nvcore.sentences import groups as said
from nvcore.sentences.facts import Amount, Fact, P

if TYPE_CHECKING:
    from nvcore.group_statistics.comparison import GroupComparison

SMALL: Final = 6
"""Groups of fewer values, or fewer persons, are compared by permutation."""


def results(comparison: GroupComparison) -> list[Fact]:
    """What the tests that fit show."""
    names = comparison.groups["condition"]
    if len(names) < 2:
        reason = "there is one condition alone" if len(names) else "there is no value"
        return [said.Overall("untested", reason=reason)]
    if not comparison.fits:
        return []
    test = comparison.tests[comparison.tests["fits"]].iloc[0]
    label, p = said.TESTS[comparison.fits], float(test["p"])
    if np.isnan(p):
        return [said.Overall("untested", label, reason=test["reason"])]
    facts: list[Fact] = [said.Overall("shown" if p <= SIGNIFICANT else "not shown", label, P(p, p))]
    if len(names) > 2:
        form = amount_form(comparison.groups["mean"].to_numpy())
        shown = comparison.pairs[comparison.pairs["fits"]]
        shown = shown[shown["p_corrected"] <= SIGNIFICANT]
        apart = tuple(_apart(row, form) for _, row in shown.iterrows())
        label = said.PAIR_TESTS[comparison.fits_pairs]
        facts.append(said.PairsApart("some" if apart else "none", label, apart))
    return facts


def _apart(pair: pd.Series, form: str) -> said.Apart:
    """The two conditions of a pair, the larger first."""
    is_ratio = not np.isnan(pair["ratio"])
    size = float(np.log(pair["ratio"]) if is_ratio else pair["difference"])
    order = (pair["first"], pair["second"]) if size >= 0 else (pair["second"], pair["first"])
    p = P(pair["p_corrected"], pair["p_corrected"])
    if is_ratio:
        return said.Apart("ratio", *order, Amount(float(np.exp(abs(size))), ".2f"), p)
    return said.Apart("difference", *order, Amount(abs(size), form), p)


def cautions(comparison: GroupComparison, asked: GroupArguments) -> list[Fact]:
    """What to bear in mind, and the size of a further study."""
    facts: list[Fact] = []
    fitting = comparison.tests[comparison.tests["fits"]]
    for n_ways in fitting.loc[fitting["is_exact"], "n_ways"]:
        if 1 / n_ways > SIGNIFICANT:
            facts.append(said.Caution("best", p=1 / n_ways))
    checks = comparison.assumptions
    for p in checks.loc[(checks["check"] == "shapiro") & (checks["holds"] == 0), "p"]:
        if not fitting["n_ways"].any():
            facts.append(said.Caution("skewed", p=p))
    if not comparison.measure and comparison.fits:
        facts.append(said.Caution("summaries"))
        if (n := int(comparison.groups["n"].min())) < SMALL:
            facts.append(said.Caution("few summaries", n=n))
        if asked.correlation is not None:
            facts.append(said.Caution("assumed"))
    known = comparison.sizes.dropna(subset="effect")
    for _, row in known[known["test"] == "t"].iterrows():
        where: Literal["group", "all", "none"] = "group"
        if np.isnan(row["n"]):
            where = "none"
        elif comparison.design == "same":
            where = "all"
        if asked.difference is not None:
            amount, n = Amount(asked.difference, "g"), 0 if where == "none" else int(row["n"])
            facts.append(said.Further(where, amount, asked.power, n))
        elif where != "none":
            facts.append(said.Caution("optimistic"))
    return facts
