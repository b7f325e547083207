"""Estimators on the sample's simulated trials: what they have to reach on unseen pedestrians.

To be done within seconds they are searched for in few settings and trained without every fifth of
the pedestrians (`OUTER_FOLDS`). The sample's own estimator is searched for in all settings
and trained on all pedestrians: here only what it says that it was trained on is compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest
from places import SAMPLE

from nvcore.common.output.csv_text import to_csv_bytes
from nvcore.common.progress import no_progress
from nvcore.subjects.driver.estimators import Search, read_estimator
from nvcore.subjects.driver.estimators.model_file import SAMPLE_ESTIMATOR
from nvcore.subjects.driver.estimators.search import folds_of
from nvcore.subjects.driver.estimators.training import (
    OUTER_FOLDS,
    OutOfFold,
    Samples,
    errors_by_period,
    origin_of,
    out_of_fold,
    samples_of,
)
from nvcore.subjects.driver.features.feature_record import record_beside
from nvcore.subjects.driver.features.images import image_features
from nvcore.subjects.driver.trials import TrainingTable, training_table

FOLDER = SAMPLE.parent
SEARCH = Search(n_settings=4, n_folds=2)


@dataclass(frozen=True)
class LeftOut:
    """Estimates of pedestrians that had no part in them, and what the simulated observer says."""

    table: TrainingTable
    samples: Samples
    estimates: OutOfFold
    truth: np.ndarray


@pytest.fixture(scope="module")
def left_out(tmp_path_factory: pytest.TempPathFactory) -> LeftOut:
    study = FOLDER / "study"
    features = tmp_path_factory.mktemp("sample") / "study.csv"
    run = image_features(study, study / "boxes.csv")
    content = to_csv_bytes(run.table)
    features.write_bytes(content)
    record_beside(features).write_bytes(run.record({features.name: content}))
    table = training_table(FOLDER / "trials_simulated.csv", features)
    samples = samples_of(table)
    fold = folds_of(samples.group, OUTER_FOLDS, SEARCH.seed + 1)
    estimates = out_of_fold(samples, fold, SEARCH, n_threads=2, progress=no_progress)
    return LeftOut(table, samples, estimates, truth_of(table.rows))


def truth_of(rows: pd.DataFrame) -> np.ndarray:
    """The probability with which a simulated subject sees the pedestrian of each row."""
    keys = ["image", "pedestrian", "period_s"]
    truth = pd.read_csv(FOLDER / "trials_simulated_truth.csv", dtype={"pedestrian": str})
    known = rows[keys].merge(truth, on=keys, how="left", validate="one_to_one")
    return known["probability"].to_numpy()


def test_from_3_s_on_the_estimator_of_the_period_beats_the_single_one(left_out: LeftOut):
    switched = errors_by_period(left_out.samples, left_out.estimates.switched)
    single = errors_by_period(left_out.samples, left_out.estimates.single)
    is_late = left_out.samples.periods_s >= 3
    assert is_late.tolist() == [False, False, True, True, True, True]
    assert (switched[is_late] < single[is_late]).all()


def test_over_all_periods_both_beat_the_constant(left_out: LeftOut):
    estimates = left_out.estimates
    constant = errors_by_period(left_out.samples, estimates.constant).mean()
    assert errors_by_period(left_out.samples, estimates.switched).mean() < constant
    assert errors_by_period(left_out.samples, estimates.single).mean() < constant


def test_estimates_correlate_with_what_the_simulated_observer_sees(left_out: LeftOut):
    assert np.corrcoef(left_out.estimates.switched, left_out.truth)[0, 1] >= 0.8


def test_the_samples_estimator_was_trained_on_the_samples_trials(left_out: LeftOut):
    assert read_estimator(SAMPLE_ESTIMATOR).origin == origin_of(left_out.table, Search())
