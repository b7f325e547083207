"""Estimates of what the driver sees, in processes of their own.

An estimator is a stranger's file. So may be the pictures, the readings of the light meter, and the
recorded gaze.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from nvcore.dataset import Dataset
from nvcore.driver.estimate import EstimateRun, run_estimate
from nvcore.driver.estimators import Estimator, fingerprint, read_estimator
from nvcore.driver.estimators.model import Origin
from nvcore.driver.estimators.words import caution_of
from nvcore.driver.illumination import LightSettings, read_light
from nvcore.driver.illumination.clock import AdaptationClock, adaptation_clock
from nvcore.driver.run import run_features
from nvcore.driver.settings import settings_from
from nvcore.driver.simulation import simulate_change
from nvcore.progress import Progress
from ui.confined.process import N_THREADS, Allowance, call

RUN: Final = Allowance(memory_mb=3000, seconds=180.0)
"""For a run; its time is from one picture to the next."""
SMALL: Final = Allowance(memory_mb=1000, seconds=20.0)
"""For the readings of a light meter."""


@dataclass(frozen=True)
class EstimatorSpec:
    """An estimator: the path of its file, and a `version` that changes with the content."""

    path: Path
    version: str


@dataclass(frozen=True)
class EstimatorFacts:
    """Description of an estimator (see `nvcore.driver.estimators.Estimator`).

    Attributes
    ----------
    features
        Keys of the features that it takes.
    periods_s
        Adaptation periods that it has a regression for.
    fingerprint
        sha256, as hexadecimal digits.
    caution
        Why its estimates are to be doubted; empty: nothing is known.
    """

    name: str
    origin: Origin
    features: tuple[str, ...]
    periods_s: tuple[float, ...]
    fingerprint: str
    caution: str


def run_confined(
    dataset: Dataset, spec: EstimatorSpec, *, interpolate: bool, progress: Progress
) -> EstimateRun:
    """Compute features and estimates of all pedestrians of recordings, in a process of its own.

    Parameters
    ----------
    dataset
        With the session that it was loaded from as its settings.
    progress
        As of `nvcore.driver.run.run_features`. If it raises CancelledError, the process ends.

    Raises
    ------
    InputError
        As `run_features` and `read_estimator`; or if the run exceeds its allowance or stands still.
    """
    boxes = dataset.boxes.iloc[: len(dataset.truth)]
    of_truth = replace(dataset, boxes=boxes, systems=(), provenance={}, findings=())
    return call(
        *(_estimate, of_truth, spec, interpolate),
        allowance=RUN,
        what="estimating what the driver sees",
        progress=progress,
    )


def clock_by_meter(
    path: Path, frame: NDArray[np.int64], fps: float, settings: LightSettings
) -> AdaptationClock:
    """Return light and adaptation in the frames of a recording, from the file of a light meter.

    Raises
    ------
    InputError
        If the file cannot be used, or exceeds its allowance.
    """
    what = "reading the light meter"
    return call(_clock, path, frame, fps, settings, allowance=SMALL, what=what)


# The rest is called in the other process.


def _estimate(
    dataset: Dataset, spec: EstimatorSpec, interpolate: bool, *, progress: Progress
) -> EstimateRun:
    estimator = read_estimator(spec.path)
    settings = settings_from({}, features=estimator.feature_settings)
    features = run_features(dataset, settings, n_threads=N_THREADS, progress=progress)
    return run_estimate(features, estimator, interpolate=interpolate)


@lru_cache(maxsize=1)
def _estimator(spec: EstimatorSpec) -> Estimator:
    return read_estimator(spec.path)


def describe_estimator(spec: EstimatorSpec) -> EstimatorFacts:
    """Describe an estimator."""
    estimator = _estimator(spec)
    return EstimatorFacts(
        estimator.name,
        estimator.origin,
        estimator.features,
        tuple(estimator.periods_s.tolist()),
        fingerprint(estimator),
        caution_of(estimator),
    )


def simulate(
    spec: EstimatorSpec,
    features: pd.DataFrame,
    end_s: NDArray[np.float64],
    change_s: float,
    interpolate: bool,
    real_s: NDArray[np.float64] | None,
) -> pd.DataFrame:
    """Run `nvcore.driver.simulation.simulate_change`."""
    estimator = _estimator(spec)
    return simulate_change(
        features, end_s, change_s, estimator, interpolate=interpolate, real_s=real_s
    )


def _clock(
    path: Path, frame: NDArray[np.int64], fps: float, settings: LightSettings
) -> AdaptationClock:
    return adaptation_clock(read_light(path), frame, fps, settings)
