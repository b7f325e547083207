"""An estimator trained on few pedestrians, once for all tests of this folder."""

from __future__ import annotations

import pytest
from driver_trials import made_table

from nvcore.subjects.driver.estimators import Search, Training, train_estimator
from nvcore.subjects.driver.trials import TrainingTable

SEARCH = Search(n_settings=2, n_folds=3)


@pytest.fixture(scope="session")
def table(tmp_path_factory: pytest.TempPathFactory) -> TrainingTable:
    return made_table(tmp_path_factory.mktemp("trials"), n=24)


@pytest.fixture(scope="session")
def training(table: TrainingTable) -> Training:
    return train_estimator(table, name="made up", search=SEARCH, n_threads=2)
