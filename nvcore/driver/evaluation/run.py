"""Cross-validation of estimators that leaves out one pedestrian at a time."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.driver.estimators.nested import OutOfFold, Samples, out_of_fold, samples_of
from nvcore.driver.estimators.search import Search
from nvcore.driver.trials.table import TrainingTable
from nvcore.progress import Progress, no_progress, with_time_left


@dataclass(frozen=True)
class Evaluation:
    """Result of an evaluation: each pedestrian estimated by regressions trained on all others.

    `nvcore.driver.evaluation.evaluation_tables` makes tables of them.

    Attributes
    ----------
    table
        What was evaluated on.
    samples
        Its rows that could be used, as arrays.
    estimates
        Of each of them, by regressions that were chosen and trained without the pedestrian.
    search
        How features and settings were chosen.
    seconds
        How long it took.
    """

    table: TrainingTable
    samples: Samples
    estimates: OutOfFold
    search: Search
    seconds: float

    @property
    def periods_s(self) -> NDArray[np.float64]:
        """Adaptation periods, ascending, float64, shape (p,)."""
        return self.samples.periods_s

    @property
    def rows(self) -> pd.DataFrame:
        """The rows of the training table that were evaluated."""
        return self.table.rows.iloc[self.samples.row].reset_index(drop=True)


def evaluate_estimators(
    table: TrainingTable,
    *,
    search: Search | None = None,
    n_threads: int | None = None,
    progress: Progress = no_progress,
) -> Evaluation:
    """Estimate each pedestrian by estimators chosen and trained on all others.

    Nested: for each pedestrian, features and settings are chosen anew by five-fold
    cross-validation over the others (`nvcore.driver.estimators.train_estimator`). With 51
    pedestrians and 6 periods these are two million small regressions.

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
        If there is too little to learn.
    MissingExtraError
        If the extra ``driver`` is not installed.
    CancelledError
        If `progress` raises it.
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
