"""Train estimators by nested cross-validation: a regression for each period, and one for all."""

from __future__ import annotations

import hashlib
import os
import threading
import time
from collections.abc import Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.common.errors import InputError
from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.progress import Progress, no_progress, part_of, run_steps, with_time_left
from nvcore.common.wording import count_text, percent
from nvcore.notes import Note
from nvcore.subjects.driver.estimators.model import Estimator, Origin, Quality, Regression
from nvcore.subjects.driver.estimators.search import (
    PAIRS,
    Check,
    Columns,
    Search,
    choose,
    fit,
    folds_of,
)
from nvcore.subjects.driver.features import FEATURE_KEYS
from nvcore.subjects.driver.inputs.study_tables import LEAST_PEDESTRIANS, PEDESTRIAN
from nvcore.subjects.driver.trials.table import TrainingTable

OUTER_FOLDS: Final = 5
"""Folds of the outer cross-validation, which gives the uncertainty of an estimate."""
LEAST_TRAINED: Final = 2
"""Minimum number of pedestrians at each period outside a fold: one to train, one to select."""
MOST_LACKING: Final = 0.1
"""Maximum share of pedestrians for which a feature may be undefined."""


@dataclass(frozen=True)
class Samples:
    """Training data of regressions, as arrays.

    Attributes
    ----------
    features
        All eight features, float64, shape (n, 8). Unused columns are NaN throughout.
    target
        Detectability, float64, shape (n,).
    period
        Row in `periods_s` of each sample, int64, shape (n,).
    group
        Number of each sample's pedestrian, int64, shape (n,).
    row
        Row of each sample in the training table, int64, shape (n,).
    periods_s
        Adaptation periods, ascending, float64, shape (p,).
    notes
        Notes on skipped rows and features.
    trials_file
        File of the table, for error messages.
    """

    features: NDArray[np.float64]
    target: NDArray[np.float64]
    period: NDArray[np.int64]
    group: NDArray[np.int64]
    row: NDArray[np.int64]
    periods_s: NDArray[np.float64]
    notes: tuple[Note, ...]
    trials_file: Path | None = None

    def __len__(self) -> int:
        return len(self.target)


def samples_of(table: TrainingTable) -> Samples:
    """Return the rows of a training table that can be used for training.

    A feature that is undefined for more than a tenth of the pedestrians is not used (grey pictures
    have no colour). Pedestrians that lack one of the used features are skipped.

    Raises
    ------
    InputError
        If a period has fewer than eight pedestrians, no feature is left, or all pedestrians have
        the same detectability.
    """
    features = table.rows[list(FEATURE_KEYS)].to_numpy(dtype=np.float64, copy=True)
    group = np.asarray(table.rows.groupby([*PEDESTRIAN], sort=False).ngroup(), dtype=np.int64)
    first = np.unique(group, return_index=True)[1]
    is_known = np.isnan(features[first]).mean(axis=0) <= MOST_LACKING
    if not is_known.any():
        raise InputError(
            "no feature is defined for nine tenths of the pedestrians", file=table.features_file
        )
    is_whole = np.isfinite(features[:, is_known]).all(axis=1)
    features[:, ~is_known] = np.nan
    periods_s, period = np.unique(table.rows["period_s"], return_inverse=True)
    counts = np.bincount(period[is_whole], minlength=len(periods_s))
    if counts.min() < LEAST_PEDESTRIANS:
        raise InputError(
            f"the period of {periods_s[counts.argmin()]:g} s has "
            f"{count_text(int(counts.min()), 'pedestrian')} with features; "
            f"{LEAST_PEDESTRIANS} are needed",
            file=table.trials_file,
        )
    _refuse_equal(table.rows[is_whole], table.trials_file)
    unknown = [key for key, known in zip(FEATURE_KEYS, is_known, strict=True) if not known]
    notes = [Note("driver.features_not_used", features=unknown)] if unknown else []
    if n_lost := len(np.unique(group[~is_whole])):
        notes.append(Note("driver.pedestrians_left_out", n=n_lost))
    return Samples(
        features=features[is_whole],
        target=table.rows["detectability"].to_numpy(dtype=np.float64)[is_whole],
        period=period[is_whole].astype(np.int64),
        group=group[is_whole],
        row=np.flatnonzero(is_whole),
        periods_s=periods_s.astype(np.float64),
        notes=tuple(notes),
        trials_file=table.trials_file,
    )


def _refuse_equal(rows: pd.DataFrame, trials_file: Path | None) -> None:
    """Raise an error if all rows have the same detectability."""
    share = rows["detectability"]
    if share.min() < share.max():
        return
    if 0 < share.iloc[0] < 1:
        what = f"{percent(share.iloc[0])} of the subjects see every pedestrian at every period"
        raise InputError(f"{what}: there is nothing to learn", file=trials_file)
    how = "right" if share.iloc[0] else "wrong, or not seen"
    raise InputError(
        f"all {count_text(int(rows['n_subjects'].sum()), 'response')} are {how}: there is nothing "
        "to learn; are touch_x and touch_y in pixels of the picture, and the boxes those of these "
        "pictures?",
        file=trials_file,
    )


@dataclass(frozen=True)
class OutOfFold:
    """Estimates of each pedestrian by regressions selected and trained without that pedestrian.

    Attributes
    ----------
    switched, single
        Estimates by the period's regression and by the single one, float64, shape (n,).
    constant, constant_of_all
        Mean training targets in the row's period, and over all periods, float64, shape (n,).
    pairs
        Estimates by the regression of the row's period on each of the 28 pairs of features
        (`nvcore.subjects.driver.estimators.search.PAIRS`), with settings chosen within the fold,
        float64, shape (n, 28). NaN: a feature is not used.
    columns
        Features chosen in each fold, by period, then for the regression over all periods.
    """

    switched: NDArray[np.float64]
    single: NDArray[np.float64]
    constant: NDArray[np.float64]
    constant_of_all: NDArray[np.float64]
    pairs: NDArray[np.float64]
    columns: tuple[tuple[Columns, ...], ...]


class _Outcome(NamedTuple):
    """Regression with its estimates for the rows left out."""

    test: NDArray[np.bool_]
    regression: Regression
    estimate: NDArray[np.float64]
    constant: float
    pairs: NDArray[np.float64]


def train_final(
    samples: Samples, search: Search, *, n_threads: int, progress: Progress
) -> tuple[Regression, ...]:
    """Select and train a regression for each period, then one for all periods, on all rows.

    Raises
    ------
    CancelledError
        If `progress` raises it.
    """
    nothing = np.zeros(len(samples), dtype=np.bool_)
    (outcomes,) = _train(samples, [nothing], search, n_threads, progress, "with all pedestrians")
    return tuple(outcome.regression for outcome in outcomes)


def out_of_fold(
    samples: Samples,
    fold: NDArray[np.int64],
    search: Search,
    *,
    n_threads: int,
    progress: Progress,
    has_pairs: bool = False,
) -> OutOfFold:
    """Estimate each fold's rows by regressions trained on the other folds.

    Parameters
    ----------
    fold
        Number of the fold of each row, shape (n,). All rows of a pedestrian share a fold.
    has_pairs
        True to also evaluate each pair of features.

    Raises
    ------
    InputError
        If a period has fewer than two pedestrians outside a fold.
    CancelledError
        If `progress` raises it.
    """
    _refuse_too_few(samples, fold)
    tests = [fold == number for number in np.unique(fold)]
    how = "with pedestrians left out"
    by_fold = _train(samples, tests, search, n_threads, progress, how, has_pairs=has_pairs)
    switched, single, constant, constant_of_all = np.full((4, len(samples)), np.nan)
    pairs = np.full((len(samples), len(PAIRS)), np.nan)
    for *of_periods, of_all in by_fold:
        single[of_all.test], constant_of_all[of_all.test] = of_all.estimate, of_all.constant
        for of in of_periods:
            switched[of.test], constant[of.test] = of.estimate, of.constant
            pairs[of.test] = of.pairs
    columns = tuple(
        tuple(tuple(of.regression.columns.tolist()) for of in outcomes) for outcomes in by_fold
    )
    return OutOfFold(switched, single, constant, constant_of_all, pairs, columns)


def _refuse_too_few(samples: Samples, fold: NDArray[np.int64]) -> None:
    """Raise an error if a period without one of the folds has too few pedestrians."""
    pedestrians = pd.DataFrame(
        {"period": samples.period, "fold": fold, "group": samples.group}
    ).drop_duplicates()
    counts = pd.crosstab(pedestrians["period"], pedestrians["fold"]).to_numpy()
    left = counts.sum(axis=1) - counts.max(axis=1)
    number = int(left.argmin())
    if left[number] < LEAST_TRAINED:
        raise InputError(
            f"at the period of {samples.periods_s[number]:g} s "
            f"{count_text(int(left[number]), 'pedestrian is', 'pedestrians are')} left to learn "
            f"from when those of one fold are left out; {LEAST_TRAINED} are needed: show more "
            "pedestrians at that period, or draw the folds anew (seed)",
            file=samples.trials_file,
        )


def _train(
    samples: Samples,
    tests: Sequence[NDArray[np.bool_]],
    search: Search,
    n_threads: int,
    progress: Progress,
    how: str,
    *,
    has_pairs: bool = False,
) -> list[list[_Outcome]]:
    """Train without each set of rows: a regression for each period, then one for all periods."""
    is_cancelled = threading.Event()

    def check() -> None:
        if is_cancelled.is_set():
            raise CancelledError

    n_periods = len(samples.periods_s)
    members = [samples.period == number for number in range(n_periods)]
    members.append(np.ones(len(samples), dtype=np.bool_))
    jobs = [
        partial(_regression, samples, is_in & ~test, is_in & test, search, check, of_pairs)
        for test in tests
        for is_in, of_pairs in zip(members, [has_pairs] * n_periods + [False], strict=True)
    ]
    what = f"{count_text(len(jobs), 'search', 'searches')} {how}"
    with ThreadPoolExecutor(n_threads) as executor:
        try:
            outcomes = run_steps(jobs, executor, progress, what)
        finally:
            is_cancelled.set()  # stops the other regressions if `progress` raises
    return [outcomes[at : at + n_periods + 1] for at in range(0, len(outcomes), n_periods + 1)]


def _regression(
    samples: Samples,
    train: NDArray[np.bool_],
    test: NDArray[np.bool_],
    search: Search,
    check: Check,
    has_pairs: bool,
) -> _Outcome:
    """Select and train one regression, then estimate the rows left out."""
    features, target, left_out = (
        samples.features[train],
        samples.target[train],
        samples.features[test],
    )
    choices = choose(features, target, samples.group[train], search, check=check)
    pairs = np.full((len(left_out), len(PAIRS)), np.nan)
    for columns, settings, _ in choices:
        if has_pairs and len(columns) == 2:
            regression = fit(features, target, columns, settings)
            pairs[:, PAIRS.index(columns)] = regression.predict(left_out)
    chosen = min(choices, key=lambda choice: choice.error)
    best = fit(features, target, chosen.columns, chosen.settings)
    return _Outcome(test, best, best.predict(left_out), target.mean(), pairs)


@dataclass(frozen=True)
class Training:
    """Trained estimator with its errors on pedestrians left out.

    Attributes
    ----------
    estimator
        The model.
    table
        Training data.
    switched_errors, single_errors, constant_errors
        Mean squared error at each period on pedestrians left out, for the period's estimator, for
        the single one, and for the mean of the training targets, float64, shape (p,). 0 is best.
    notes
        Notes on data that were not learned.
    seconds
        Duration of the training.
    """

    estimator: Estimator
    table: TrainingTable
    switched_errors: NDArray[np.float64]
    single_errors: NDArray[np.float64]
    constant_errors: NDArray[np.float64]
    notes: tuple[Note, ...]
    seconds: float


def train_estimator(
    table: TrainingTable,
    *,
    name: str,
    search: Search | None = None,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Training:
    """Train an estimator of detectability.

    A support vector regression on standardised features is fitted. Features (each alone, each pair,
    all), kernel, C, epsilon and gamma are those with the lowest error in a five-fold
    cross-validation by pedestrian. The whole procedure is repeated without each of five folds of
    the pedestrians, which gives the uncertainty: no pedestrian is judged by a model that was
    trained on them. The same table, settings and seed give the same model.

    Parameters
    ----------
    table
        Table from `nvcore.subjects.driver.trials.training_table`.
    search
        Search for features and settings. None: the default.
    n_threads
        Number of regressions trained in parallel. None: the number of cores.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`.

    Raises
    ------
    InputError
        If there are too few data, overall or at a period outside a fold.
    MissingExtraError
        If the extra ``driver`` is not installed.
    CancelledError
        If `progress` raises it.
    """
    began = time.perf_counter()
    search = search or Search()
    samples = samples_of(table)
    progress = with_time_left(progress)
    threads = n_threads or os.cpu_count() or 1
    fold = folds_of(samples.group, OUTER_FOLDS, search.seed + 1)
    end = OUTER_FOLDS / (OUTER_FOLDS + 1)
    left_out = out_of_fold(
        samples, fold, search, n_threads=threads, progress=part_of(progress, 0, end)
    )
    regressions = train_final(
        samples, search, n_threads=threads, progress=part_of(progress, end, 1)
    )
    estimator = Estimator(
        name=name,
        periods_s=samples.periods_s,
        regressions=regressions,
        qualities=_qualities(samples, left_out),
        origin=origin_of(table, search),
        feature_settings=table.feature_settings,
    )
    return Training(
        estimator,
        table,
        switched_errors=errors_by_period(samples, left_out.switched),
        single_errors=errors_by_period(samples, left_out.single),
        constant_errors=errors_by_period(samples, left_out.constant),
        notes=samples.notes,
        seconds=time.perf_counter() - began,
    )


def errors_by_period(samples: Samples, estimate: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean squared error at each period, float64, (p,), NaN if an estimate is NaN.

    Parameters
    ----------
    estimate
        Estimate for each row, float64, shape (n,).
    """
    squares = (estimate - samples.target) ** 2
    n_periods = len(samples.periods_s)
    sums = np.bincount(samples.period, squares, minlength=n_periods)
    errors: NDArray[np.float64] = sums / np.bincount(samples.period, minlength=n_periods)
    return errors


def _qualities(samples: Samples, left_out: OutOfFold) -> tuple[Quality, ...]:
    """Return the quality of each period's regression, then of the one for all periods."""

    def errors_of(
        of_periods: NDArray[np.float64], of_all: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        squares = (of_all - samples.target) ** 2
        return np.append(errors_by_period(samples, of_periods), squares.mean())

    errors = errors_of(left_out.switched, left_out.single)
    constant_errors = errors_of(left_out.constant, left_out.constant_of_all)
    members = [samples.period == number for number in range(len(samples.periods_s))]
    targets = [*(samples.target[is_in] for is_in in members), samples.target]
    return tuple(
        Quality(len(target), float(error), float(target.mean()), float(constant_error))
        for target, error, constant_error in zip(targets, errors, constant_errors, strict=True)
    )


def origin_of(table: TrainingTable, search: Search) -> Origin:
    """Return the origin of an estimator: facts about its training table and search."""
    columns = ["image", "pedestrian", "period_s", "detectability", "n_subjects", *FEATURE_KEYS]
    content = to_csv_bytes(table.rows[columns], digits=None)
    return Origin(
        n_pedestrians=table.n_pedestrians,
        n_subjects=table.n_subjects,
        n_trials=table.n_trials,
        simulated=table.simulated,
        square_px=float(table.judging.square_px),
        centre_share=float(table.judging.centre_share),
        display_s=float(table.judging.display_s),
        seed=search.seed,
        fingerprint=hashlib.sha256(content).hexdigest(),
        search="quick" if search.is_quick else "",
        picture_px=table.picture_px,
    )
