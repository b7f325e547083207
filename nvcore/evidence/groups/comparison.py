"""Comparison of groups: all applicable tests, and the most suitable one."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Final, Literal, NamedTuple, get_args

import numpy as np
import pandas as pd
import scipy

from nvcore.common.arguments.groups import GroupArguments, Scale
from nvcore.common.errors import ParameterError
from nvcore.evidence.groups.analyses import (
    Groups,
    Test,
    anova,
    assumed_pairs,
    cohens_d,
    friedman,
    games_howell,
    pair_table,
    paired,
    pairs_of,
    persons_for,
    power_of_f,
    repeated_measures,
    residuals,
    sphericity,
    t_interval,
    tukey,
    welch,
)
from nvcore.evidence.groups.permutation import permute_between, permute_within
from nvcore.evidence.groups.reading import GroupTable, read_groups
from nvcore.evidence.groups.text import PAIR_TESTS, TESTS, amount_form, render_groups
from nvcore.evidence.paired_tests import SIGNIFICANT, holm
from nvcore.inputs.readers.parse.table import TextTable
from nvcore.notes import Note, say
from nvcore.settings.objects import PEDESTRIAN

Design = Literal["same", "different", "mixed", "unknown"]
SMALL: Final = 6
"""Fewest values or persons in a group for checking assumptions."""
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
        Fields of `nvcore.evidence.groups.analyses.Test`, and ``fits``.
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

    `of_groups` is empty if only summaries are known. `wide` has the values of the same persons as
    persons by conditions, times as logarithms, and is empty otherwise.
    """

    design: Design
    groups: Groups
    of_groups: list[np.ndarray]
    wide: np.ndarray
    are_logs: bool
    notes: list[Note]


_Analysis = tuple[list[Test], list[pd.DataFrame], list[tuple[str, float, float, float]]]
"""Tests of all conditions, comparisons of pairs, and checks of assumptions."""


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
    data = _data_of(read)
    analysis: _Analysis = [], [pair_table("", 0)], []
    sizes: list[tuple[str, float, float, float]] = []
    notes = [*read.notes, *data.notes]
    fits = fits_pairs = ""
    if len(read.conditions) > 1 and data.design != "mixed":
        analysis = _of_same(data) if data.design == "same" else _of_independent(data)
        fits, fits_pairs, why = _fitting(read.scale, data, analysis[2])
        notes.append(why)
        sizes = _sizes(asked, data)
        if asked.correlation is not None:
            if "value" in read.rows:
                raise ParameterError(
                    "correlation: values hold it; it is asked of means and SD alone"
                )
            if len({*data.groups.n}) > 1:
                raise ParameterError("correlation: the same persons in all conditions have one n")
            analysis[1].append(assumed_pairs(data.groups, asked.correlation))
    tests = pd.DataFrame(analysis[0], columns=[*Test._fields])
    pairs = pd.concat(analysis[1], ignore_index=True)
    named = {
        name: pairs[name].map(dict(enumerate(read.conditions))) for name in ("first", "second")
    }
    comparison = GroupComparison(
        *(read.measure, read.scale, data.design, fits, fits_pairs),
        groups=_groups_table(read, data),
        tests=tests.assign(fits=tests["test"] == fits),
        pairs=pairs.assign(**named, fits=pairs["test"] == fits_pairs),
        assumptions=pd.DataFrame(analysis[2], columns=CHECKED),
        sizes=pd.DataFrame(sizes, columns=SIZED),
        notes=(),
    )
    notes += [*_results(comparison), *_cautions(comparison, asked)]
    return replace(comparison, notes=tuple(notes))


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
    names, rows, none = read.conditions, read.rows, np.empty((0, 0))
    has_several, notes = len(names) > 1, []
    if "value" not in rows:
        groups = Groups(*rows[["n", "mean", "sd"]].to_numpy(dtype=float).T)
        notes = [Note("groups.unknown_persons_of_summaries")] if has_several else []
        return _Data("unknown", groups, [], none, False, notes)
    if not (rows["participant"] != "").any():
        own = _by_condition(rows)
        notes = [Note("groups.unknown_persons")] if has_several else []
        return _Data("unknown", _summarised(own), own, none, False, notes)
    key = ["participant", "condition"]
    persons = rows.groupby("participant", sort=False)["condition"].nunique()
    n_several, n_all = int((persons > 1).sum()), int((persons == len(names)).sum())
    design: Literal["same", "different", "mixed"] = "mixed"
    if not has_several or not n_several:
        design = "different"
    elif n_all >= 2 and 2 * n_all >= len(persons):
        design = "same"
    are_logs = design == "same" and read.scale == "times"
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
    if are_logs:
        rows = rows.assign(value=np.log(rows["value"]))
    rows = rows.groupby(key, sort=False)["value"].mean().reset_index()
    own, wide = _by_condition(rows), none
    if design == "same":
        table = rows.pivot_table(index="participant", columns="condition", values="value")
        wide = table[names].to_numpy()
        own = [*np.exp(wide).T] if are_logs else [*wide.T]
    return _Data(design, _summarised(own), own, wide, are_logs, notes)


def _by_condition(rows: pd.DataFrame) -> list[np.ndarray]:
    return [own.to_numpy() for _, own in rows.groupby("condition", sort=False)["value"]]


def _summarised(of_groups: list[np.ndarray]) -> Groups:
    parts = [
        (len(own), own.mean(), own.std(ddof=1) if len(own) > 1 else np.nan) for own in of_groups
    ]
    return Groups(*np.array(parts, dtype=float).reshape(-1, 3).T)


def _of_same(data: _Data) -> _Analysis:
    """Run all tests for a design with the same persons in all conditions."""
    wide, k = data.wide, data.wide.shape[1]
    repeated, by_rank = repeated_measures(wide), friedman(wide)
    of_ranks = permute_within(scipy.stats.rankdata(wide, axis=1))
    tests = [
        *(*repeated, by_rank, _by_permutation("within", repeated[0], permute_within(wide))),
        _by_permutation("within_ranks", by_rank, of_ranks),
    ]
    p = np.array([permute_within(wide[:, [*pair]]).p for pair in combinations(range(k), 2)])
    first, second = pairs_of(k)
    apart = (wide[:, first] - wide[:, second]).mean(axis=0)
    effect = {"ratio": np.exp(apart)} if data.are_logs else {"difference": apart}
    exchanged = pair_table("exchanged", k, **effect, p=p, p_corrected=holm(p))
    epsilon = sphericity(wide) if k > 2 else np.nan
    checks = [("sphericity", epsilon, np.nan, np.nan), _normal(residuals(wide).ravel())]
    return tests, [paired(wide, are_logs=data.are_logs), exchanged], checks


def _of_independent(data: _Data) -> _Analysis:
    """Run all tests for groups that are, or are assumed to be, independent."""
    groups, own = data.groups, data.of_groups
    tests, pairs = [anova(groups), welch(groups)], [tukey(groups), games_howell(groups)]
    variances = groups.variances[groups.n > 1]
    ratio = np.nan
    if len(variances) > 1 and variances.min() > 0:
        ratio = float(variances.max() / variances.min())
    checks = [("variance_ratio", ratio, np.nan, _truth(ratio <= LARGE_RATIO, ratio))]
    if not own:
        return tests, pairs, checks
    every = np.concatenate(own)
    h = Test("kruskal", reason="all values are equal")
    if np.ptp(every) > 0:
        value, p = map(float, scipy.stats.kruskal(*own))
        h = Test("kruskal", "H", value, len(own) - 1.0, p=p)
    ranks = np.split(scipy.stats.rankdata(every), np.cumsum(groups.n[:-1]).astype(int))
    tests += [
        *(h, _by_permutation("permutation", tests[1], permute_between(own))),
        _by_permutation("permutation_ranks", h, permute_between(ranks, has_welch=False)),
    ]
    of_pairs = np.array([permute_between(pair).p for pair in combinations(own, 2)])
    more = {"p": of_pairs, "p_corrected": holm(of_pairs), "d": cohens_d(groups)}
    pairs.append(pair_table("permutation", len(own), difference=groups.differences, **more))
    value = p = np.nan
    apart = [np.abs(values - np.median(values)) for values in own]
    if (groups.n > 2).all() and not np.isnan(_summarised(apart).within[0]):
        value, p = map(float, scipy.stats.levene(*own, center="median"))
    checks.append(("levene", value, p, _truth(p >= SIGNIFICANT, p)))
    left = np.concatenate([values - values.mean() for values in own])
    checks.append(_normal(np.zeros(0) if np.isnan(groups.within[0]) else left))
    return tests, pairs, checks


def _by_permutation(key: str, by_formula: Test, test: Test) -> Test:
    """Return a permutation test with the statistic and effects of the test by formula."""
    shared = ("statistic", "value", "eta2", "omega2", "f")
    return test._replace(test=key, **{name: getattr(by_formula, name) for name in shared})


def _normal(left: np.ndarray) -> tuple[str, float, float, float]:
    value = p = np.nan
    if 3 <= len(left) <= MOST_SHAPIRO and left.any():
        value, p = map(float, scipy.stats.shapiro(left))
    return "shapiro", value, p, _truth(p >= SIGNIFICANT, p)


def _truth(holds: bool, value: float) -> float:
    """Return `holds` as 1 or 0, or NaN if the value is NaN."""
    return np.nan if np.isnan(value) else float(holds)


def _fitting(
    scale: Scale, data: _Data, checks: list[tuple[str, float, float, float]]
) -> tuple[str, str, Note]:
    """Choose the test of all conditions and that of pairs, and give the reason.

    Where few values cannot show whether variances are equal, Welch's tests keep their level better
    than permutations do (docs/decisions/089-small-groups-by-welch.md).
    """
    n, ratio = int(data.groups.n.min()), checks[0][1]
    are_counts, is_small = scale == "counts", n < SMALL
    if data.design == "same":
        if are_counts or is_small:
            fitting = Note("groups.exchange_fits", are_counts=are_counts, n=n)
            return "within", "exchanged", fitting
        return "repeated_gg", "paired", Note("groups.repeated_fits", are_logs=data.are_logs)
    if data.of_groups and (are_counts or (data.groups.variances == 0).any()):
        return "permutation", "permutation", Note("groups.permutation_fits", are_counts=are_counts)
    if is_small:
        return "welch", "games_howell", Note("groups.welch_fits", n=n)
    if any(holds == 0 for check, _, _, holds in checks if check != "shapiro"):
        return "welch", "games_howell", Note("groups.welch_fits", ratio=ratio)
    return "anova", "tukey", Note("groups.anova_fits", ratio=ratio if ratio > 0 else None)


def _sizes(asked: GroupArguments, data: _Data) -> list[tuple[str, float, float, float]]:
    """Return study sizes that show the smallest relevant difference, else the largest found.

    f assumes that all groups but the two that differ are in the middle, which is the hardest case
    to show (Cohen 1988, section 8.2.1). The difference of a pair is shown at 0.05 over the number
    of pairs.
    """
    k, (first, second) = len(data.groups.n), pairs_of(len(data.groups.n))
    level, is_paired = SIGNIFICANT / len(first), data.design == "same"
    variance, difference = data.groups.within[0], np.ptp(data.groups.mean)
    if is_paired:
        apart = data.wide[:, first] - data.wide[:, second]
        variance = float(apart.var(axis=0, ddof=1).mean())
        difference = np.abs(apart.mean(axis=0)).max()
    if asked.difference is not None:
        middle = np.exp(data.wide.mean()) if data.are_logs else np.nan
        difference = np.log1p(asked.difference / middle) if data.are_logs else asked.difference
    d = float(difference / np.sqrt(variance)) if variance > 0 else np.nan
    f = d / np.sqrt(2 * k)
    n_groups = 1 if is_paired else 2
    of_pairs = partial(power_of_f, d / n_groups, k=n_groups, level=level)
    sizes = [("t", d, level, persons_for(asked.power, d, of_pairs))]
    if not is_paired and k > 2:
        of_all = partial(power_of_f, f, k=k, level=SIGNIFICANT)
        sizes.insert(0, ("anova", f, SIGNIFICANT, persons_for(asked.power, f, of_all)))
    return sizes


def _groups_table(read: GroupTable, data: _Data) -> pd.DataFrame:
    n, mean, sd = data.groups
    low, high = t_interval(mean, sd / np.sqrt(n), n)
    columns = {"n": n.astype(np.int64), "mean": mean, "sd": sd, "low": low, "high": high}
    own = data.of_groups
    has_times = read.scale == "times" and own
    geometric = [np.exp(np.log(values).mean()) for values in own] if has_times else np.nan
    table = pd.DataFrame({"condition": pd.Series(read.conditions, dtype=str), **columns})
    median = [np.median(values) for values in own] or np.nan
    return table.assign(median=median, geometric_mean=geometric)


def _results(comparison: GroupComparison) -> list[Note]:
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


def _cautions(comparison: GroupComparison, asked: GroupArguments) -> list[Note]:
    """Return notes with cautions about the results, and on the size of a further study."""
    notes = []
    fitting = comparison.tests[comparison.tests["fits"]]
    for n_ways in fitting.loc[
        fitting["is_exact"] & (fitting["n_ways"] < 1 / SIGNIFICANT), "n_ways"
    ]:
        notes.append(Note("groups.least_p", p=1 / n_ways))
    checks = comparison.assumptions
    for p in checks.loc[(checks["check"] == "shapiro") & (checks["holds"] == 0), "p"]:
        if not fitting["n_ways"].any():
            notes.append(Note("groups.skewed", p=p))
    if not comparison.measure and comparison.fits:
        notes.append(Note("groups.summaries_alone"))
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
