"""Evaluate estimators by leaving out one pedestrian at a time, and tabulate the results."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
import pandas as pd
import scipy
from numpy.typing import NDArray

from nvcore.common.progress import Progress, no_progress, with_time_left
from nvcore.subjects.driver.estimators.search import PAIRS, Search
from nvcore.subjects.driver.estimators.training import (
    OutOfFold,
    Samples,
    errors_by_period,
    out_of_fold,
    samples_of,
)
from nvcore.subjects.driver.evaluation import published
from nvcore.subjects.driver.features import FEATURE_KEYS, words_of
from nvcore.subjects.driver.trials.table import TrainingTable

MOST_BARS: Final = 11
"""Maximum number of bars of a histogram."""


@dataclass(frozen=True)
class Evaluation:
    """Result of an evaluation: each pedestrian estimated by regressions trained on all others.

    `evaluation_tables` converts it to tables.

    Attributes
    ----------
    table
        Data of the evaluation.
    samples
        Usable rows of the table, as arrays.
    estimates
        Estimates for each row by regressions that were selected and trained without the pedestrian.
    search
        Search for features and settings.
    seconds
        Duration of the evaluation.
    """

    table: TrainingTable
    samples: Samples
    estimates: OutOfFold
    search: Search
    seconds: float

    @property
    def rows(self) -> pd.DataFrame:
        """Rows of the training table that were evaluated."""
        return self.table.rows.iloc[self.samples.row].reset_index(drop=True)


def evaluate_estimators(
    table: TrainingTable,
    *,
    search: Search | None = None,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Evaluation:
    """Estimate each pedestrian by estimators chosen and trained on all others.

    The cross-validation is nested: for each pedestrian, features and settings are selected again by
    five-fold cross-validation over the others
    (`nvcore.subjects.driver.estimators.train_estimator`). With 51 pedestrians and 6 periods these
    are two million small regressions.

    Parameters and errors are those of `nvcore.subjects.driver.estimators.train_estimator`.
    """
    began = time.perf_counter()
    search = search or Search()
    samples = samples_of(table)
    estimates = out_of_fold(
        samples,
        samples.group,
        search,
        n_threads=n_threads or os.cpu_count() or 1,
        progress=with_time_left(progress),
        has_pairs=True,
    )
    return Evaluation(table, samples, estimates, search, time.perf_counter() - began)


def errors_table(evaluation: Evaluation) -> pd.DataFrame:
    """Return mean squared errors at each period on pedestrians left out (0 is best).

    Returns
    -------
    ``period_s`` (NaN: the mean over the periods), ``n`` pedestrians (at the period, in the last row
    at any period), ``switched`` (the period's estimator), ``single`` (the estimator for all
    periods), ``constant`` (the mean of the training targets at the period), ``sampling`` (error of
    the true probabilities due to few subjects: the mean of d (1 - d) / (n - 1) for detectability d
    of n subjects, NaN with only one), and the paper's ``published_switched`` and
    ``published_single`` at its periods, NaN elsewhere. ``published_single_printed`` in the last row
    is the mean that the paper prints, which is not the mean of its row
    (`nvcore.subjects.driver.evaluation.PUBLISHED_NOTE`).
    """
    samples, estimates = evaluation.samples, evaluation.estimates
    share = evaluation.rows["detectability"]
    others = (evaluation.rows["n_subjects"] - 1).replace(0, np.nan)
    variance = (share * (1 - share) / others).to_numpy(np.float64)
    n = np.bincount(samples.period)
    of_paper = pd.DataFrame(
        {"published_switched": published.SWITCHED, "published_single": published.SINGLE},
        index=list(published.PERIODS_S),
    ).reindex(np.round(samples.periods_s, 6))
    table = pd.DataFrame(
        {
            "period_s": samples.periods_s,
            "n": n,
            "switched": errors_by_period(samples, estimates.switched),
            "single": errors_by_period(samples, estimates.single),
            "constant": errors_by_period(samples, estimates.constant),
            "sampling": np.bincount(samples.period, variance) / n,
            **{name: of_paper[name].to_numpy() for name in of_paper},
        }
    )
    is_same = len(table) == len(published.PERIODS_S) and bool(of_paper.notna().all(axis=None))
    mean = table.drop(columns=["period_s", "n"]).mean(skipna=False).to_dict()
    last = {"period_s": np.nan, "n": len(np.unique(samples.group)), **mean}
    table = pd.concat([table, pd.DataFrame([last])], ignore_index=True)
    table["published_single_printed"] = np.nan
    if is_same:
        table.loc[len(table) - 1, "published_single_printed"] = published.SINGLE_PRINTED
    return table


def choices_table(evaluation: Evaluation) -> pd.DataFrame:
    """Count how often each choice of features was made at each period.

    Returns
    -------
    ``period_s`` (NaN: the single estimator), ``features`` in words, ``n`` (number of pedestrians
    left out for which they were chosen) and ``share``, the most frequent first.
    """
    by_regression = zip(*evaluation.estimates.columns, strict=True)
    periods = [*evaluation.samples.periods_s.tolist(), np.nan]
    rows = []
    for period_s, choices in zip(periods, by_regression, strict=True):
        for columns, n in Counter(choices).most_common():
            words = words_of([FEATURE_KEYS[column] for column in columns])
            rows.append((period_s, words, n, n / len(choices)))
    return pd.DataFrame(rows, columns=["period_s", "features", "n", "share"])


def pair_errors(evaluation: Evaluation) -> NDArray[np.float64]:
    """Return the mean squared error of each pair of features at each period, float64, (p, 28).

    Settings are chosen without the pedestrian left out. NaN: a feature is not used.
    """
    pairs = evaluation.estimates.pairs
    return np.stack(
        [errors_by_period(evaluation.samples, pairs[:, number]) for number in range(len(PAIRS))],
        axis=1,
    )


def pairs_table(evaluation: Evaluation) -> pd.DataFrame:
    """Rank the pairs of features by their error at each period.

    Returns
    -------
    ``period_s``, ``rank`` (1 is best), ``feature_1``, ``feature_2``, ``error`` (mean squared), and
    ``published_error`` for the three best pairs, which the paper prints.
    """
    parts = []
    for period_s, errors in zip(evaluation.samples.periods_s, pair_errors(evaluation), strict=True):
        of_paper = published.PAIRS.get(round(float(period_s), 6), {})
        names = [(FEATURE_KEYS[first], FEATURE_KEYS[second]) for first, second in PAIRS]
        part = pd.DataFrame(names, columns=["feature_1", "feature_2"])
        part.insert(0, "period_s", float(period_s))
        part["error"] = errors
        part["published_error"] = [of_paper.get(pair, np.nan) for pair in names]
        part = part[part["error"].notna()]
        part.insert(1, "rank", scipy.stats.rankdata(part["error"], method="min").astype(np.int64))
        parts.append(part.sort_values("rank", kind="stable"))
    return pd.concat(parts, ignore_index=True)


def pair_ranks_table(evaluation: Evaluation) -> pd.DataFrame:
    """Return rank correlations of the feature pairs' errors between every two periods.

    Returns
    -------
    ``period_1_s``, ``period_2_s`` and ``spearman``, the rank correlation of the pairs' errors, -1
    to 1. NaN with fewer than three pairs, or if all errors are equal.
    """
    errors = pair_errors(evaluation)
    errors = errors[:, ~np.isnan(errors).any(axis=0)]
    periods = evaluation.samples.periods_s.tolist()
    rows = []
    for first, second in combinations(range(len(periods)), 2):
        of = errors[[first, second]]
        is_defined = of.shape[1] >= 3 and np.ptp(of, axis=1).all()
        rank = float(scipy.stats.spearmanr(*of).statistic) if is_defined else np.nan
        rows.append((periods[first], periods[second], rank))
    return pd.DataFrame(rows, columns=["period_1_s", "period_2_s", "spearman"])


def periods_table(evaluation: Evaluation) -> pd.DataFrame:
    """Summarize detectability at each period: mean, SD, and shares seen by nobody or everybody.

    Returns
    -------
    ``period_s``, ``n`` pedestrians, ``mean``, ``sd`` (over pedestrians, n - 1), ``share_zero`` and
    ``share_one``: shares of pedestrians seen by nobody and by everybody.
    """
    rows = evaluation.rows
    groups = rows.groupby("period_s")["detectability"]
    table = pd.DataFrame(
        {
            "n": groups.size(),
            "mean": groups.mean(),
            "sd": groups.std(),
            "share_zero": groups.agg(lambda of: (of == 0).mean()),
            "share_one": groups.agg(lambda of: (of == 1).mean()),
        }
    )
    return table.reset_index()


def histograms_table(evaluation: Evaluation) -> pd.DataFrame:
    """Count pedestrians by detectability at each period.

    With up to ten subjects there is a bar for each possible value, otherwise eleven bars from 0 to
    1. The number of subjects is the maximum over pedestrians. If fewer subjects responded to a
    pedestrian, the nearest bar counts.

    Returns
    -------
    ``period_s``, ``detectability`` (the middle of the bar) and ``n``, including empty bars.
    """
    rows = evaluation.rows
    n_bars = min(int(rows["n_subjects"].max()) + 1, MOST_BARS)
    bar = np.floor(rows["detectability"].to_numpy() * (n_bars - 1) + 0.5).astype(np.int64)
    parts = []
    for period_s in evaluation.samples.periods_s.tolist():
        counts = np.bincount(bar[rows["period_s"].to_numpy() == period_s], minlength=n_bars)
        middle = np.arange(n_bars) / (n_bars - 1)
        parts.append(pd.DataFrame({"period_s": period_s, "detectability": middle, "n": counts}))
    return pd.concat(parts, ignore_index=True)


def estimates_table(evaluation: Evaluation) -> pd.DataFrame:
    """Return detectability and its estimates for every pedestrian at every period.

    Returns
    -------
    ``image``, ``pedestrian``, ``period_s``, ``detectability``, ``low`` and ``high`` (Wilson),
    ``n_subjects``, and the estimates ``switched``, ``single`` and ``constant``.
    """
    columns = ["image", "pedestrian", "period_s", "detectability", "low", "high", "n_subjects"]
    estimates = evaluation.estimates
    return evaluation.rows[columns].assign(
        switched=estimates.switched, single=estimates.single, constant=estimates.constant
    )


TABLES: Final[dict[str, Callable[[Evaluation], pd.DataFrame]]] = {
    "errors": errors_table,
    "choices": choices_table,
    "pairs": pairs_table,
    "pair_ranks": pair_ranks_table,
    "periods": periods_table,
    "histograms": histograms_table,
    "estimates": estimates_table,
    "subjects": lambda evaluation: evaluation.table.subjects,
}
"""Tables of an evaluation by file name without extension."""


def evaluation_tables(evaluation: Evaluation) -> dict[str, pd.DataFrame]:
    """Return all tables of an evaluation by file name without extension."""
    return {name: table(evaluation) for name, table in TABLES.items()}
