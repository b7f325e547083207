"""What the driver sees, estimated in processes of their own.

An estimator is a stranger's file, and so may be the pictures, the light meter's readings and where
the driver looked.
"""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
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
from nvcore.errors import InputError
from nvcore.progress import Progress
from ui.confined.process import Allowance, Process, call

ALLOWANCE: Final = Allowance(memory_mb=3000, seconds=60.0)
"""For a run, and for an answer of its process."""
SMALL: Final = Allowance(memory_mb=1000, seconds=20.0)
"""For the readings of a light meter."""
STALLED_S: Final = 180.0
"""Without another picture a run is stopped."""
POLL_S: Final = 0.3
SHARE_OF_CORES: Final = 2
"""One picture for so many cores at a time: the others are for visitors."""
WHAT: Final = "estimating what the driver sees"


@dataclass(frozen=True)
class EstimatorSpec:
    """Which estimator: the path of its file; `version` changes with the content."""

    path: Path
    version: str


@dataclass(frozen=True)
class EstimatorFacts:
    """What an estimator is.

    Attributes
    ----------
    name, origin
        See `nvcore.driver.estimators.Estimator`.
    features
        Keys of those that it takes.
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
    """Features and estimates of all pedestrians of recordings, in a process of its own.

    Parameters
    ----------
    dataset
        With the session that it was loaded from as its settings.
    progress
        As of `nvcore.driver.run.run_features`; where it raises, the process ends.

    Raises
    ------
    InputError
        As `run_features` and `read_estimator`; or if it takes more than it may, or stands still.
    """
    process = Process(ALLOWANCE)
    try:
        process.call(_begin, _of_truth(dataset), spec, interpolate, what=WHAT)
        last_share, since = -1.0, time.monotonic()
        while True:
            share, step, is_done = process.call(_state, what=WHAT)
            if share != last_share:
                last_share, since = share, time.monotonic()
            elif time.monotonic() - since > STALLED_S:
                raise InputError(f"{WHAT} stood still for {STALLED_S:g} s, and was stopped")
            progress(share, step)
            if is_done:
                return process.call(_result, what=WHAT)
    finally:
        process.end()


def clock_by_meter(
    path: Path, frame: NDArray[np.int64], fps: float, settings: LightSettings
) -> AdaptationClock:
    """Light and adaptation in the frames of a recording, by the file of a light meter.

    Raises
    ------
    InputError
        If it cannot be used, or takes more than it may.
    """
    what = "reading the light meter"
    return call(_clock, path, frame, fps, settings, allowance=SMALL, what=what)


def _of_truth(dataset: Dataset) -> Dataset:
    """The dataset without its systems: what a process has to be sent."""
    boxes = dataset.boxes.iloc[: len(dataset.truth)]
    return replace(dataset, boxes=boxes, systems=(), provenance={}, findings=())


# What follows is called in the other process.


class _Run:
    """A run in a thread of its own, while others ask how far it is."""

    def __init__(self, dataset: Dataset, spec: EstimatorSpec, *, interpolate: bool) -> None:
        self.share, self.step = 0.0, ""
        self.outcome = ThreadPoolExecutor(1).submit(self._run, dataset, spec, interpolate)

    def _run(self, dataset: Dataset, spec: EstimatorSpec, interpolate: bool) -> EstimateRun:
        estimator = read_estimator(spec.path)
        n_threads = max(1, (os.cpu_count() or 1) // SHARE_OF_CORES)
        settings = settings_from({}, features=estimator.feature_settings)
        features = run_features(dataset, settings, n_threads=n_threads, progress=self._progress)
        return run_estimate(features, estimator, interpolate=interpolate)

    def _progress(self, share: float, step: str) -> None:
        self.share, self.step = share, step


_runs: list[_Run] = []
"""The one of this process."""


def _begin(dataset: Dataset, spec: EstimatorSpec, interpolate: bool) -> None:
    _runs[:] = [_Run(dataset, spec, interpolate=interpolate)]


def _state() -> tuple[float, str, bool]:
    (run,) = _runs
    is_done = bool(wait([run.outcome], POLL_S).done)
    return run.share, run.step, is_done


def _result() -> EstimateRun:
    (run,) = _runs
    return run.outcome.result()


_opened: dict[EstimatorSpec, Estimator] = {}
"""The estimator that was opened last."""


def _estimator(spec: EstimatorSpec) -> Estimator:
    if spec not in _opened:
        estimator = read_estimator(spec.path)
        _opened.clear()
        _opened[spec] = estimator
    return _opened[spec]


def describe_estimator(spec: EstimatorSpec) -> EstimatorFacts:
    """What an estimator is."""
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
    """As `nvcore.driver.simulation.simulate_change`."""
    estimator = _estimator(spec)
    return simulate_change(
        features, end_s, change_s, estimator, interpolate=interpolate, real_s=real_s
    )


def _clock(
    path: Path, frame: NDArray[np.int64], fps: float, settings: LightSettings
) -> AdaptationClock:
    return adaptation_clock(read_light(path), frame, fps, settings)
