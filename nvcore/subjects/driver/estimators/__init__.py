"""Estimators of detectability: one for each adaptation period, and one for all."""

from nvcore.subjects.driver.estimators.model import (
    Estimates,
    Estimator,
    Origin,
    Quality,
    Regression,
)
from nvcore.subjects.driver.estimators.model_file import (
    estimator_path,
    fingerprint,
    read_estimator,
    write_estimator,
)
from nvcore.subjects.driver.estimators.search import QUICK, Search
from nvcore.subjects.driver.estimators.training import Training, train_estimator

__all__ = [
    "QUICK",
    "Estimates",
    "Estimator",
    "Origin",
    "Quality",
    "Regression",
    "Search",
    "Training",
    "estimator_path",
    "fingerprint",
    "read_estimator",
    "train_estimator",
    "write_estimator",
]
