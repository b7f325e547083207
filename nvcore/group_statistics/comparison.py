"""Comparison of groups: all applicable tests, and the most suitable one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final, Literal, NamedTuple, get_args

import numpy as np
import pandas as pd
import scipy

from nvcore.arguments.groups import GroupArguments, Scale
from nvcore.errors import ParameterError
from nvcore.evidence.paired_tests import SIGNIFICANT, holm
from nvcore.group_statistics.notes import SMALL, cautions, results
from nvcore.group_statistics.permutation import Permuted, permute_between, permute_within
from nvcore.group_statistics.reading import GroupTable, read_groups
from nvcore.group_statistics.repeated import (
    friedman,
    paired,
    repeated_measures,
    residuals,
    sphericity,
)
from nvcore.group_statistics.sample_size import persons_for, power_of_anova, power_of_t
from nvcore.group_statistics.summaries import (
    PAIR_COLUMNS,
    Groups,
    Test,
    anova,
    assumed_pairs,
    cohens_d,
    games_howell,
    mean_interval,
    pair_table,
    pairs_of,
    tukey,
    welch,
)
from nvcore.group_statistics.text import render_groups
from nvcore.inputs.readers.parse.table import TextTable
from nvcore.notes import Note, say
from nvcore.objects import PEDESTRIAN

Design = Literal["same", "different", "mixed", "unknown"]
LARGE_RATIO: Final = 3.0
"""Ratio of the largest to the smallest variance above which variances count as unequal (Dean and
Voss 1999, Design and analysis of experiments, section 5.6)."""
CHECKED: Final = ["check", "value", "p", "holds"]
SIZED: Final = ["test", "effect", "level", "n"]
MOST_SHAPIRO: Final = 5_000
"""Maximum number of values for which SciPy knows the distribution of W."""


@dataclass(frozen=True, repr=False)
class GroupComparison:
    """Comparison of groups. NaN is undefined in its tables.

    Attributes
    ----------
    measure, scale
        The compared column (empty: means and SD were given), and the kind of its numbers.
    design
        ``same`` persons in all conditions, ``different`` ones, ``mixed`` (some in several), or
        ``unknown``.
    fits, fits_pairs
        Suitable test in `tests`, and suitable comparison in `pairs`. Empty: none.
    groups
        ``condition``, ``n``, ``mean``, ``sd``, ``low`` and ``high`` (95 % interval of the mean),
        ``median``, ``geometric_mean`` (of times).
    tests
        Fields of `nvcore.group_statistics.summaries.Test`, and ``fits``.
    pairs
        ``test``, ``first``, ``second``, ``difference`` (first less second) or in the same persons'
        times ``ratio`` (of geometric means), each with its 95 % interval (``low``, ``high``); q or
        t as ``value``, ``df``, uncorrected ``p``, ``p_corrected`` for all pairs, Cohen's ``d``,
        ``fits``. The intervals of Tukey and of Games and Howell hold for all pairs together.
    assumptions
        ``check``, ``value``, ``p``, and ``holds`` (1 or 0; NaN: not known).
    sizes
        Sizes of a further study: ``test`` (all conditions by ``anova``, or two of them by ``t``),
        ``effect`` (Cohen's f or d) shown at p of ``level``, and ``n`` (persons in each group, or in
        all if they are the same).
    notes
        Conclusions, which `sentences` renders.
    """

    measure: str
    scale: Scale
    design: Design
    fits: str
    fits_pairs: str
    groups: pd.DataFrame
    tests: pd.DataFrame
    pairs: pd.DataFrame
    assumptions: pd.DataFrame
    sizes: pd.DataFrame
    notes: tuple[Note, ...]

    @property
    def sentences(self) -> list[str]:
        """Conclusions in words."""
        return [say(note, PEDESTRIAN) for note in self.notes]

    def __str__(self) -> str:
        return render_groups(self)

    def __repr__(self) -> str:
        return f"<GroupComparison of {len(self.groups)} conditions: {self.fits or 'no test'} fits>"


class _Data(NamedTuple):
    """Values to compare in each condition, one per person or drive.

    `of_groups` is None if only summaries are known.

    Values of the same persons have one order. `wide` has them as persons by conditions, times as
    logarithms, and is empty otherwise.
    """

    design: Design
    groups: Groups
    of_groups: list[np.ndarray] | None
    wide: np.ndarray
    are_logs: bool = False
    notes: tuple[Note, ...] = ()


class _Analysis(NamedTuple):
    """Results of all applicable tests. A mixed design has none."""

    tests: list[Test]
    pairs: pd.DataFrame
    assumptions: pd.DataFrame


def compare_groups(asked: GroupArguments, text: TextTable | None = None) -> GroupComparison:
    """Compare groups by every test that their table allows.

    Parameters
    ----------
    text
        See `read_groups`.

    Raises
    ------
    InputError
        If the table cannot be used.
    ParameterError
        If a choice is impossible, or does not fit the table.
    """
    _check(asked)
    read = read_groups(asked, text)
    names, data = read.conditions, _data_of(read)
    is_comparable = len(names) > 1 and data.design != "mixed"
    analysis = _Analysis([], pd.DataFrame(columns=[*PAIR_COLUMNS]), pd.DataFrame(columns=CHECKED))
    why = None
    fits = fits_pairs = ""
    if is_comparable:
        analysis = _of_same(data) if data.design == "same" else _of_independent(data)
        fits, fits_pairs, why = _fitting(read.scale, data, analysis.assumptions)
    if is_comparable and asked.correlation is not None:
        if read.summaries is None:
            raise ParameterError("correlation: values hold it; it is asked of means and SD alone")
        if len({*data.groups.n}) > 1:
            raise ParameterError("correlation: the same persons in all conditions have one n")
        pairs = [analysis.pairs, assumed_pairs(data.groups, asked.correlation)]
        analysis = analysis._replace(pairs=pd.concat(pairs, ignore_index=True))
    tests = pd.DataFrame(analysis.tests, columns=[*Test._fields])
    pairs_named = analysis.pairs.assign(
        first=[names[place] for place in analysis.pairs["first"]],
        second=[names[place] for place in analysis.pairs["second"]],
        fits=analysis.pairs["test"] == fits_pairs,
    )
    comparison = GroupComparison(
        *(read.measure, read.scale, data.design, fits, fits_pairs),
        groups=_groups_table(read, data),
        tests=tests.assign(fits=tests["test"] == fits),
        pairs=pairs_named,
        assumptions=analysis.assumptions,
        sizes=_sizes(asked, data) if is_comparable else pd.DataFrame(columns=SIZED),
        notes=(*read.notes, *data.notes),
    )
    reasons = [why] if why is not None else []
    notes = (*comparison.notes, *reasons, *results(comparison), *cautions(comparison, asked))
    return replace(comparison, notes=notes)


def _check(asked: GroupArguments) -> None:
    for name, low, high in (("power", 0.5, 0.99), ("correlation", -1.0, 1.0)):
        value = getattr(asked, name)
        if value is not None and not low <= value <= high:
            raise ParameterError(f"{name}: expected {low:g} to {high:g}, got {value:g}")
    if asked.difference is not None and not 0 < asked.difference < np.inf:
        raise ParameterError(f"difference: expected a number above 0, got {asked.difference:g}")
    if asked.scale is not None and asked.scale not in get_args(Scale):
        raise ParameterError(f"scale: expected times, counts or numbers, got {asked.scale!r}")


def _data_of(read: GroupTable) -> _Data:
    """Return the values of each condition, and whether the same persons are in all of them."""
    names, none = read.conditions, np.empty((0, 0))
    has_several = len(names) > 1
    if read.summaries is not None:
        groups = Groups(*read.summaries[["n", "mean", "sd"]].to_numpy(dtype=float).T)
        notes = [Note("groups.unknown_persons_of_summaries")] if has_several else []
        return _Data("unknown", groups, None, none, notes=tuple(notes))
    rows = read.rows
    if not (rows["participant"] != "").any():
        of_groups = [own.to_numpy() for _, own in rows.groupby("condition", sort=False)["value"]]
        notes = [Note("groups.unknown_persons")] if has_several else []
        return _Data("unknown", _summarised(of_groups), of_groups, none, notes=tuple(notes))
    key = ["participant", "condition"]
    persons = rows.groupby("participant", sort=False)["condition"].nunique()
    n_several, n_all = int((persons > 1).sum()), int((persons == len(names)).sum())
    design: Literal["same", "different", "mixed"] = "mixed"
    if not has_several or not n_several:
        design = "different"
    elif n_all >= 2 and 2 * n_all >= len(persons):
        design = "same"
    are_logs = design == "same" and read.scale == "times"
    notes = []
    if rows.duplicated(key).any():
        notes.append(Note("groups.averaged", are_logs=are_logs))
    if design == "same" and n_all < len(persons):
        is_whole = persons == len(names)
        notes.append(Note("groups.incomplete", names=[*persons.index[~is_whole]]))
        rows = rows[rows["participant"].map(is_whole)]
    if has_several:
        of_design = {
            "same": Note("groups.same_persons", n_all=n_all),
            "different": Note("groups.different_persons"),
            "mixed": Note("groups.mixed_persons", n=len(persons), n_several=n_several, n_all=n_all),
        }
        notes.append(of_design[design])
    rows = rows.assign(value=np.log(rows["value"])) if are_logs else rows
    means = rows.groupby(key, sort=False)["value"].mean().reset_index()
    wide = none
    if design == "same":
        table = means.pivot_table(index="participant", columns="condition", values="value")
        wide = table[names].to_numpy(dtype=float)
        of_groups = [np.exp(own) if are_logs else own for own in wide.T]
    else:
        of_groups = [own.to_numpy() for _, own in means.groupby("condition", sort=False)["value"]]
    return _Data(design, _summarised(of_groups), of_groups, wide, are_logs, tuple(notes))


def _summarised(of_groups: list[np.ndarray]) -> Groups:
    n = np.array([len(own) for own in of_groups], dtype=float)
    sd = [own.std(ddof=1) if len(own) > 1 else np.nan for own in of_groups]
    return Groups(n, np.array([own.mean() for own in of_groups]), np.array(sd, dtype=float))


def _of_same(data: _Data) -> _Analysis:
    """Run all tests for a design with the same persons in all conditions."""
    wide, k = data.wide, data.wide.shape[1]
    of_ranks = scipy.stats.rankdata(wide, axis=1)
    repeated, by_rank = repeated_measures(wide), friedman(wide)
    tests = [
        *(*repeated, by_rank, _by_permutation("within", repeated[0], permute_within(wide))),
        _by_permutation("within_ranks", by_rank, permute_within(of_ranks)),
    ]
    p = np.array([permute_within(wide[:, [*pair]]).p for pair in combinations(range(k), 2)])
    first, second = pairs_of(k)
    apart = (wide[:, first] - wide[:, second]).mean(axis=0)
    effect = {"ratio": np.exp(apart)} if data.are_logs else {"difference": apart}
    exchanged = pair_table("exchanged", k, **effect, p=p, p_corrected=holm(p))
    epsilon = sphericity(wide) if k > 2 else np.nan
    checks = [("sphericity", epsilon, np.nan, np.nan), _normal(residuals(wide).ravel())]
    pairs = pd.concat([paired(wide, are_logs=data.are_logs), exchanged], ignore_index=True)
    return _Analysis(tests, pairs, pd.DataFrame(checks, columns=CHECKED))


def _of_independent(data: _Data) -> _Analysis:
    """Run all tests for groups that are, or are assumed to be, independent."""
    groups, own = data.groups, data.of_groups
    tests, pairs = [anova(groups), welch(groups)], [tukey(groups), games_howell(groups)]
    variances = groups.variances[groups.n > 1]
    ratio = np.nan
    if len(variances) > 1 and variances.min() > 0:
        ratio = float(variances.max() / variances.min())
    checks = [("variance_ratio", ratio, np.nan, _truth(ratio <= LARGE_RATIO, ratio))]
    if own is not None:
        every = np.concatenate(own)
        h = Test("kruskal", reason="all values are equal")
        if np.ptp(every) > 0:
            value, p = map(float, scipy.stats.kruskal(*own))
            h = Test("kruskal", "H", value, len(own) - 1.0, p=p)
        of_ranks = np.split(scipy.stats.rankdata(every), np.cumsum(groups.n[:-1]).astype(int))
        tests += [
            *(h, _by_permutation("permutation", tests[0], permute_between(own))),
            _by_permutation("permutation_ranks", h, permute_between(of_ranks)),
        ]
        first, second = pairs_of(len(own))
        of_pairs = np.array([permute_between(pair).p for pair in combinations(own, 2)])
        difference = groups.mean[first] - groups.mean[second]
        more = {"p": of_pairs, "p_corrected": holm(of_pairs), "d": cohens_d(groups)}
        pairs.append(pair_table("permutation", len(own), difference=difference, **more))
        value = p = np.nan
        apart = [np.abs(values - np.median(values)) for values in own]
        if (groups.n > 2).all() and _summarised(apart).within[0]:
            value, p = map(float, scipy.stats.levene(*own, center="median"))
        checks.append(("levene", value, p, _truth(p >= SIGNIFICANT, p)))
        left = np.concatenate([values - values.mean() for values in own])
        checks.append(_normal(left if groups.within[0] else np.zeros(0)))
    pairs_table = pd.concat(pairs, ignore_index=True)
    return _Analysis(tests, pairs_table, pd.DataFrame(checks, columns=CHECKED))


def _by_permutation(key: str, by_formula: Test, test: Permuted) -> Test:
    """Return a test with the same statistic, but with p by permutation."""
    reason = "" if test.n_ways else "there is nothing to exchange"
    known = by_formula._replace(test=key, df_between=np.nan, df_within=np.nan, reason=reason)
    return known._replace(**test._asdict())


def _normal(left: np.ndarray) -> tuple[str, float, float, float]:
    value = p = np.nan
    if 3 <= len(left) <= MOST_SHAPIRO and left.any():
        value, p = map(float, scipy.stats.shapiro(left))
    return "shapiro", value, p, _truth(p >= SIGNIFICANT, p)


def _truth(holds: bool, value: float) -> float:
    """Return `holds` as 1 or 0, or NaN if the value is NaN."""
    return np.nan if np.isnan(value) else float(holds)


def _fitting(scale: Scale, data: _Data, assumptions: pd.DataFrame) -> tuple[str, str, Note]:
    """Choose the test of all conditions and that of pairs, and give the reason."""
    n = int(data.groups.n.min())
    if data.design == "same":
        if scale == "counts" or n < SMALL:
            fitting = Note("groups.exchange_fits", are_counts=scale == "counts", n=n)
            return "within", "exchanged", fitting
        return "repeated_gg", "paired", Note("groups.repeated_fits", are_logs=data.are_logs)
    if data.of_groups is not None and (scale == "counts" or n < SMALL):
        fitting = Note("groups.permutation_fits", are_counts=scale == "counts", n=n)
        return "permutation", "permutation", fitting
    ratio = float(assumptions["value"].iloc[0])
    if assumptions.loc[assumptions["check"] != "shapiro", "holds"].eq(0).any():
        return "welch", "games_howell", Note("groups.welch_fits", ratio=ratio)
    return "anova", "tukey", Note("groups.anova_fits", ratio=ratio if ratio > 0 else None)


def _sizes(asked: GroupArguments, data: _Data) -> pd.DataFrame:
    """Return study sizes that show the smallest relevant difference, else the largest found.

    f assumes that all groups but the two that differ are in the middle, which is the hardest case
    to show (Cohen 1988, section 8.2.1). The difference of a pair is shown at 0.05 over the number
    of pairs.
    """
    k, (first, second) = len(data.groups.n), pairs_of(len(data.groups.n))
    level, is_paired = SIGNIFICANT / len(first), data.design == "same"
    if is_paired:
        apart = data.wide[:, first] - data.wide[:, second]
        variance, found = float(apart.var(axis=0, ddof=1).mean()), np.abs(apart.mean(axis=0)).max()
    else:
        within, df = data.groups.within
        variance, found = within / df if df else np.nan, np.ptp(data.groups.mean)
    difference = found
    if asked.difference is not None:
        middle = float(np.exp(data.wide.mean())) if data.are_logs else 1.0
        wanted = asked.difference
        difference = np.log1p(wanted / middle) if data.are_logs else wanted
    d = float(difference / np.sqrt(variance)) if variance > 0 else np.nan
    f = d / np.sqrt(2 * k)

    def by_anova(n: int) -> float:
        return power_of_anova(f, n, k, SIGNIFICANT)

    def by_t(n: int) -> float:
        return power_of_t(d, n, level, is_paired=is_paired)

    rows = [("t", d, level, persons_for(asked.power, d, by_t))]
    if not is_paired and k > 2:
        rows.insert(0, ("anova", f, SIGNIFICANT, persons_for(asked.power, f, by_anova)))
    return pd.DataFrame(rows, columns=SIZED)


def _groups_table(read: GroupTable, data: _Data) -> pd.DataFrame:
    n, mean, sd = data.groups
    low, high = mean_interval(data.groups)
    columns = {"n": n.astype(np.int64), "mean": mean, "sd": sd, "low": low, "high": high}
    own = data.of_groups or []
    median = [np.median(values) for values in own] or np.nan
    has_times = read.scale == "times" and own
    geometric = [np.exp(np.log(values).mean()) for values in own] if has_times else np.nan
    table = pd.DataFrame({"condition": pd.Series(read.conditions, dtype=str), **columns})
    return table.assign(median=median, geometric_mean=geometric)
