"""What a comparison of groups has to say: facts, and how they are said."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

from nvcore.sentences.facts import Amount, Fact, P
from nvcore.sentences.texts import Texts

TESTS: Final = {
    "anova": "one-way ANOVA",
    "welch": "Welch's ANOVA",
    "kruskal": "Kruskal–Wallis",
    "permutation": "permutation of F",
    "permutation_ranks": "permutation of ranks",
    "repeated": "repeated measures",
    "repeated_gg": "repeated measures, Greenhouse–Geisser",
    "friedman": "Friedman",
    "within": "exchange within persons, F",
    "within_ranks": "exchange within persons, ranks",
}
"""Overall tests by key."""
PAIR_TESTS: Final = {
    "tukey": "Tukey",
    "games_howell": "Games–Howell",
    "permutation": "permutation",
    "paired": "paired t",
    "exchanged": "exchange within persons",
    "assumed": "paired t, as assumed",
}
"""Comparisons of pairs by key."""
CHECKS: Final = {
    "variance_ratio": "largest variance / smallest",
    "levene": "equal variances (Brown–Forsythe)",
    "shapiro": "normal residuals (Shapiro–Wilk)",
    "sphericity": "sphericity (Greenhouse–Geisser's epsilon)",
}
"""Checks of assumptions by key."""
DESIGNS: Final = {
    "same": "the same persons in all conditions",
    "different": "independent groups",
    "mixed": "some persons in several conditions",
    "unknown": "whether the persons are the same is not known",
}


@dataclass(frozen=True)
class TableRead(Fact):
    """What the table holds: ``values`` of a column, or ``summaries``.

    Attributes
    ----------
    scale
        What the numbers are taken for.
    """

    kind: Literal["values", "summaries"]
    n_conditions: int
    measure: str = ""
    scale: str = ""
    n: int = 0


@dataclass(frozen=True)
class Prepared(Fact):
    """What was done to the values before they are compared.

    Attributes
    ----------
    kind
        ``others``: columns that were not chosen. ``missing`` values; rows of one drive were
        ``joined``; values of one participant and condition are ``averaged``, times ``averaged
        times`` geometrically; ``incomplete`` participants are left out, as are conditions and
        participants on request (``left out``); conditions are ``renamed``.
    """

    kind: Literal[
        "others", "missing", "joined", "averaged", "averaged times", "incomplete", "left out",
        "renamed",
    ]  # fmt: skip
    n: int = 0
    names: tuple[str, ...] = ()
    name: str = ""


@dataclass(frozen=True)
class Persons(Fact):
    """Whether the same persons stand in all conditions.

    Attributes
    ----------
    n, n_several, n_all
        Participants; those in several conditions, and in all.
    """

    kind: Literal["same", "different", "mixed", "unknown values", "unknown summaries"]
    n: int = 0
    n_several: int = 0
    n_all: int = 0


@dataclass(frozen=True)
class Fitting(Fact):
    """Which test fits, and why.

    Attributes
    ----------
    kind
        ``repeated`` measures of values or of ``times``; exchange ``within`` persons of counts, or
        as they are few; permutation of ``counts`` or of ``few``; variances are ``unequal``,
        ``equal`` or ``unknown``.
    n
        Persons, or the smallest group.
    ratio
        Largest variance over the smallest.
    """

    kind: Literal[
        "repeated", "times", "within counts", "within few", "counts", "few", "unequal", "equal",
        "unknown",
    ]  # fmt: skip
    n: int = 0
    ratio: float = 0.0


@dataclass(frozen=True)
class Overall(Fact):
    """Whether all conditions together differ, by the test that fits."""

    kind: Literal["shown", "not shown", "untested"]
    test: str = ""
    p: P | None = None
    reason: str = ""


@dataclass(frozen=True)
class Apart(Fact):
    """Two conditions that differ: the first is larger, by an amount or as a ``ratio``."""

    kind: Literal["difference", "ratio"]
    first: str
    second: str
    amount: Amount
    p: P


@dataclass(frozen=True)
class PairsApart(Fact):
    """Which conditions differ, by the comparison of pairs that fits."""

    kind: Literal["some", "none"]
    test: str
    pairs: tuple[Apart, ...] = ()


@dataclass(frozen=True)
class Caution(Fact):
    """What to bear in mind.

    Attributes
    ----------
    kind
        ``best``: so few values have no smaller p. ``skewed``: residuals are not normal.
        ``summaries``: nothing else can be checked from them; ``few summaries``: and the groups are
        small. ``assumed``: paired comparisons with an assumed correlation are no result.
        ``optimistic``: differences as found are planned for.
    """

    kind: Literal["best", "skewed", "summaries", "few summaries", "assumed", "optimistic"]
    p: float = 0.0
    n: int = 0


@dataclass(frozen=True)
class Further(Fact):
    """How many persons a further study needs for a difference: in each ``group``, or in ``all``.

    Attributes
    ----------
    kind
        ``none``: no study has so many.
    """

    kind: Literal["group", "all", "none"]
    difference: Amount
    power: float
    n: int = 0


TEXTS: Final[Texts] = {
    TableRead: {
        "values": "{n!n:value} of {measure} in {n_conditions!n:condition}, taken as {scale}.",
        "summaries": "means, SD and n of {n_conditions!n:condition}.",
    },
    Prepared: {
        "others": "Not chosen as the measure: {names}.",
        "missing": "{n!n:row} without a value left out.",
        "joined": "{n!n:row} added to another one of the same drive.",
        "averaged": "Each participant counts once in a condition, by the mean.",
        "averaged times": "Each participant counts once in a condition, by the mean of the log "
        "times.",
        "incomplete": "Participants without a value in some condition left out: {names}.",
        "left out": "Left out as asked: {names}.",
        "renamed": "Compared as {name}: {names}.",
    },
    Persons: {
        "same": "The same {n_all!n:person} stand in all conditions, so each is compared with "
        "themselves. An analysis of independent groups would take the differences between persons "
        "for chance; it is not made.",
        "different": "No participant stands in two conditions: the groups are independent.",
        "mixed": "{n_several} of {n!n:participant} stand in several conditions, {n_all} in all. "
        "The groups are not independent, and too few persons are complete for repeated measures: "
        "none is made.",
        "unknown values": "Without a column of participants it cannot be known whether the same "
        "persons stand in several conditions. If they do, none of these tests fits: they are for "
        "independent groups.",
        "unknown summaries": "From means and SD it cannot be known whether the same persons stand "
        "in all conditions. If they do, none of these tests fits: they are for independent groups, "
        "and a paired analysis needs the values.",
    },
    Fitting: {
        "repeated": "Repeated measures fit, with Greenhouse and Geisser's degrees of freedom.",
        "times": "Repeated measures of the log times fit, with Greenhouse and Geisser's degrees of "
        "freedom: times are skewed, their logarithms less so.",
        "within counts": "Counts follow no normal distribution: exchanging them within persons "
        "fits, which assumes none.",
        "within few": "{n!n:person} are too few to see what repeated measures assume: exchanging "
        "values within persons fits, which assumes no distribution.",
        "counts": "Counts follow no normal distribution: permutation fits, which assumes none.",
        "few": "The smallest group has {n!n:value}, too few to see what an analysis of variance "
        "assumes: permutation fits, which assumes no distribution.",
        "unequal": "The variances differ (the largest is {ratio:.1f} times the smallest): Welch's "
        "ANOVA and Games–Howell comparisons fit, which do not assume equal ones.",
        "equal": "Nothing speaks against equal variances (the largest is {ratio:.1f} times the "
        "smallest): one-way ANOVA and Tukey's comparisons fit.",
        "unknown": "One-way ANOVA and Tukey's comparisons fit if the variances are equal, which "
        "cannot be seen here.",
    },
    Overall: {
        "shown": "The conditions differ by more than chance ({test}, {p}).",
        "not shown": "The conditions are not shown to differ ({test}, {p}), which does not show "
        "that they are alike.",
        "untested": "Whether the conditions differ is not tested: {reason}.",
    },
    Apart: {
        "difference": "{first} is above {second} by {amount} ({p})",
        "ratio": "{first} takes {amount} times as long as {second} ({p})",
    },
    PairsApart: {
        "some": "{test}, corrected for all pairs: {pairs:; }.",
        "none": "{test}, corrected for all pairs: no two conditions are shown to differ.",
    },
    Caution: {
        "best": "So few values cannot give a p below {p:.2g}, however far the groups are apart.",
        "skewed": "The residuals are not normal (Shapiro–Wilk p = {p:.2g}): see whether the tests "
        "that assume no distribution agree.",
        "summaries": "Means and SD do not show whether the values are normal.",
        "few summaries": "The smallest group has {n!n:value}: permutation would fit, and needs the "
        "values.",
        "assumed": "Paired comparisons with an assumed correlation show what a paired analysis "
        "might find; they are no result.",
        "optimistic": "The size of a further study is for the largest difference found, and such "
        "differences tend to be overestimates: name the smallest one that would matter instead.",
    },
    Further: {
        "group": "About {n!n:person} in each group would show a difference of {difference} in "
        "{power!p} of studies.",
        "all": "About {n!n:person}, each in all conditions, would show a difference of "
        "{difference} in {power!p} of studies.",
        "none": "No study of a feasible size would show a difference of {difference} in {power!p} "
        "of studies.",
    },
}
