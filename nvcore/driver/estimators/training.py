"""Train estimators: a regression for each adaptation period, and one for all as comparison."""

from __future__ import annotations

import hashlib
import os
import time
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from nvcore.driver.estimators.model import Estimator, Origin, Quality
from nvcore.driver.estimators.nested import OutOfFold, Samples, out_of_fold, samples_of, train_final
from nvcore.driver.estimators.search import Search, folds_of
from nvcore.driver.features import FEATURE_KEYS
from nvcore.driver.trials.table import TrainingTable
from nvcore.notes import Note
from nvcore.output.csv_text import to_csv_bytes
from nvcore.progress import Progress, no_progress, part_of, with_time_left

OUTER_FOLDS: Final = 5
"""Folds of the outer cross-validation, by which the uncertainty of an estimate is told."""


@dataclass(frozen=True)
class Training:
    """Trained estimator with its errors on pedestrians left out.

    Attributes
    ----------
    estimator
        The model.
    table
        What it was trained on.
    switched_errors, single_errors, constant_errors
        Mean squared error at each period, on pedestrians left out: of the period's estimator, of
        the single one, and of the mean of the training's targets; float64, shape (p,), 0 is best.
    notes
        What was not learned.
    seconds
        How long it took.
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

    Support vector regression on standardised features. The choice of features (each alone, each
    pair, all), kernel, C, epsilon and gamma are those with the least error in a five-fold
    cross-validation by pedestrian. All of that is done again without each of five folds of the
    pedestrians, which gives the uncertainty: no pedestrian is judged by anything trained on
    them. The same table, settings and seed give the same model.

    Parameters
    ----------
    table
        Of `nvcore.driver.trials.training_table`.
    search
        How features and settings are chosen; None: as by default.
    n_threads
        Regressions at a time; None: as many as there are cores.
    progress
        Called with the share done, and the time left in words. It may raise `CancelledError`.

    Raises
    ------
    InputError
        If there is too little to learn, at all or at a period without one of the folds.
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
        Of each row, float64, shape (n,).
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
