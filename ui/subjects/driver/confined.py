"""Estimates of what the driver sees, in separate processes.

The estimator may be a file from a stranger. So may be the pictures, the readings of the light
meter, and the recorded gaze.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from nvcore.common.progress import Progress
from nvcore.common.wording import count_text, listed
from nvcore.dataset import Dataset
from nvcore.subjects.driver.estimators import Estimator, fingerprint, read_estimator
from nvcore.subjects.driver.features import LABELS
from nvcore.subjects.driver.illumination import LightSettings, read_light
from nvcore.subjects.driver.illumination.clock import AdaptationClock, adaptation_clock
from nvcore.subjects.driver.running.estimate import EstimateRun, run_estimate
from nvcore.subjects.driver.running.run import run_features
from nvcore.subjects.driver.settings import settings_from
from ui.confined.process import N_THREADS, Allowance, call
from ui.widgets.text import plain

T = TypeVar("T")

RUN: Final = Allowance(memory_mb=3000, seconds=180.0)
"""Limits of a run. The time counts from one picture to the next."""
SMALL: Final = Allowance(memory_mb=1000, seconds=20.0)
"""Limits of reading a light meter's file."""
SIMULATED: Final = {
    "no": "",
    "some": " Part of the subjects were simulated.",
    "all": " The subjects were **simulated**, not people.",
}


@dataclass(frozen=True)
class EstimatorSpec:
    """Path of an estimator's file, and a `version` that changes with its content."""

    path: Path
    version: str


def run_confined(
    dataset: Dataset, spec: EstimatorSpec, *, interpolate: bool, progress: Progress
) -> EstimateRun:
    """Compute features and estimates of all pedestrians of recordings, in a separate process.

    Parameters
    ----------
    dataset
        Dataset with the session that it was loaded from as its settings.
    progress
        Same as in `nvcore.subjects.driver.running.run.run_features`. If it raises CancelledError,
        the process ends.

    Raises
    ------
    InputError
        As for `run_features` and `read_estimator`, or if the run exceeds its limits or hangs.
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
    """Return light and adaptation in the frames of a recording, from a light meter's file.

    Raises
    ------
    InputError
        If the file cannot be used, or reading it exceeds the limits.
    """
    what = "reading the light meter"
    return call(_clock, path, frame, fps, settings, allowance=SMALL, what=what)


# The functions below run in the other process.


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


def on_estimator(spec: EstimatorSpec, function: Callable[[Estimator], T]) -> T:
    """Call a function with an estimator."""
    return function(_estimator(spec))


def describe_estimator(estimator: Estimator) -> str:
    """Describe an estimator as Markdown: its training, features and fingerprint."""
    origin, caution = estimator.origin, estimator.caution()
    doubts = SIMULATED.get(origin.simulated, "")
    doubts += f" Its estimates are {caution}." if caution else ""
    labels = plain(listed([LABELS[key] for key in estimator.features]))
    periods = ", ".join(f"{period:g}" for period in estimator.periods_s)
    return (
        f"Trained on {count_text(origin.n_trials, 'trial')} of "
        f"{count_text(origin.n_subjects, 'subject')} with "
        f"{count_text(origin.n_pedestrians, 'pedestrian')}.{doubts} Features: {labels}. "
        f"Adaptation periods: {periods} s. Fingerprint {fingerprint(estimator)[:12]}."
    )


def _clock(
    path: Path, frame: NDArray[np.int64], fps: float, settings: LightSettings
) -> AdaptationClock:
    return adaptation_clock(read_light(path), frame, fps, settings)
